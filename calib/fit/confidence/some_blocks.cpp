// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/confidence/some_blocks.h"

#include <algorithm>
#include <cmath>

namespace calib {

SomeBlocks some_blocks(const FitProblem& problem, const Solved& solved) {
  constexpr std::size_t kFew = 24, kFewPlaces = 8;
  const std::size_t every = std::max<std::size_t>(1, problem.blocks.size() / kFew);
  SomeBlocks some{
      .problem = {.sensors = problem.sensors,
                  .variables = problem.variables,
                  .priors = problem.priors,
                  .blocks = {},
                  .threads = problem.threads,
                  .x = problem.x,
                  .own = {}},
      .solved = {.information = solved.information, .reference = solved.reference, .identified = solved.identified},
      .share = 1.0 / static_cast<double>(every)};
  const auto over_field = [&](const Block& block) {
    return problem.sensors->field_point(std::visit([](const auto& b) { return b.place(); }, block)).has_value();
  };
  const bool many_places = problem.blocks.size() > kFewPlaces && std::ranges::any_of(problem.blocks, over_field);
  for (std::size_t i = 0; i < problem.x.size(); ++i)
    some.told_apart.push_back(every > 1 || (many_places && problem.sensors->varies_over_field(i)));
  for (auto& prior : some.problem.priors)
    if (prior) (*prior)[1] *= std::sqrt(static_cast<double>(every));
  for (std::size_t b = 0; b < problem.blocks.size(); b += every) {
    some.problem.blocks.push_back(problem.blocks[b]);
    some.problem.own.push_back(problem.own[b]);
    some.solved.noise_factor.push_back(solved.noise_factor[b]);
    some.solved.tests.emplace_back().noise = solved.tests[b].noise;
  }
  return some;
}

}  // namespace calib
