// SPDX-License-Identifier: Apache-2.0

// Weak directions in words: which parameters they combine, what is known of these all the same, and what would separate
// them.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/fit/fit_report.h"
#include "mtf/words.h"

namespace calib {
namespace {

std::string list_of(std::span<const std::string> names) {
  std::string text;
  for (std::size_t k = 0; k < names.size(); ++k)
    text += (k == 0 ? "" : k + 1 == names.size() ? " and " : ", ") + names[k];
  return text;
}

/// The largest edge of the fit; nullptr without edges.
const EdgeBlock* largest_edge(const FitProblem& problem, std::size_t& index) {
  const EdgeBlock* most = nullptr;
  for (std::size_t b = 0; b < problem.blocks.size(); ++b)
    if (const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b]))
      if (most == nullptr || edge->pixels() > most->pixels()) most = edge, index = b;
  return most;
}

/// Information of one more edge as good as the largest one, turned by an angle: what its pixels determine after offset
/// and plateaus are projected out.
Eigen::MatrixXd one_more(const Solved& solved, double turn_rad) {
  const FitProblem& problem = *solved.problem;
  const std::size_t n = problem.variables.size();
  Eigen::MatrixXd none = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
  std::size_t b = 0;
  const EdgeBlock* const edge = largest_edge(problem, b);
  if (edge == nullptr) return none;
  constexpr double kRange_px = 24.0, kStep_px = 0.125;
  const double angle = edge->curve(problem.own[b]).angle_rad + turn_rad;
  const SliceNodes nodes = problem.sensors->slice(edge->condition(), angle, kRange_px);
  const StepResponse step(nodes, problem.sensors->otf(edge->condition(), along(angle, nodes.f_cy_px)));
  const double cnr = std::abs(problem.own[b][edge->contrast_index()]) / edge->middle_sd();
  const double length = std::max(1.0, edge->data().start.length_px);
  const double noise = trusted_noise(solved.noise_factor[b]) * std::max(1.0, solved.tests[b].noise.sum());
  const double weight = cnr * std::sqrt(length * kStep_px / noise);
  NormalMatrix normal(3 + n);
  std::vector<double> e(step.count());
  for (double d = -kRange_px; d <= kRange_px; d += kStep_px) {
    const double spread = step.at(d, e);
    const std::span<double> row = normal.next();
    row[0] = weight * spread;
    row[1] = weight;
    row[2] = weight * e[0];
    for (std::size_t i = 0; i < n; ++i) row[3 + i] = weight * e[1 + i] * problem.variables[i].slope(problem.x[i]);
    row[3 + n] = 0.0;
    normal.add();
  }
  return project_out(normal.matrix(), 3, n);
}

bool one_direction(std::span<const double> normals_rad) {
  for (const double a : normals_rad)
    if (std::abs(std::sin(a - normals_rad.front())) > std::sin(20.0 * std::numbers::pi / 180.0)) return false;
  return true;
}

/// Second moment that the members add together, with its sd: known where each acts by its square.
std::optional<Estimate> combined_moment(FitProblem& problem, const Solved& solved,
                                        std::span<const std::size_t> members) {
  for (const std::size_t i : members)
    if (!problem.variables[i].squared || problem.variables[i].lo > 0.0) return std::nullopt;
  Functional moment = equivalent_variance(solved);
  const std::vector<double> x = problem.x;
  for (const std::size_t i : members) problem.x[i] = 0.0;
  const bool allowed = problem.apply();
  if (allowed) moment.value -= equivalent_variance(solved).value;
  problem.x = x;
  problem.apply();
  for (Eigen::Index i = 0; i < moment.gradient.size(); ++i)
    if (std::find(members.begin(), members.end(), static_cast<std::size_t>(i)) == members.end())
      moment.gradient[i] = 0.0;
  const Estimate estimate{moment.value, sd_of(solved, moment)};
  return allowed && estimate.sd < 0.3 * std::abs(estimate.value) ? std::optional(estimate) : std::nullopt;
}

}  // namespace

std::string weak_direction_text(std::span<const std::string> names, const WeakWords& words) {
  if (names.size() == 1)
    return names.front() + " is not determined: the data hardly depend on it; " + words.single_advice;
  return list_of(names) + " are not separable from " + words.from + ": only " + words.known + "; " + words.advice;
}

std::vector<NullDirection> null_directions(FitProblem& problem, const Solved& solved,
                                           std::span<const FitParameter> parameters) {
  std::vector<NullDirection> all;
  if (solved.identified.weak.empty()) return all;
  // More of the same helps a little; an edge across is worth advising only where it does what that does not.
  const Identified with_across =
      identify(solved.information.matrix + one_more(solved, 0.5 * std::numbers::pi), solved.reference);
  const Identified with_same = identify(solved.information.matrix + one_more(solved, 0.0), solved.reference);
  const bool single = one_direction(solved.normals_rad);
  for (const WeakDirection& weak : solved.identified.weak) {
    const auto lead = static_cast<Eigen::Index>(weak.members.front());
    const bool helped = single && !solved.normals_rad.empty() &&
                        std::all_of(weak.members.begin(), weak.members.end(),
                                    [&](std::size_t i) { return with_across.determined[i]; }) &&
                        with_across.covariance(lead, lead) < 0.25 * with_same.covariance(lead, lead);
    std::vector<std::string> names;
    for (const std::size_t i : weak.members)
      names.push_back(parameters[i].name.empty() ? parameters[i].path : parameters[i].name);
    WeakWords words{.from = solved.normals_rad.empty()       ? "these data"
                            : solved.normals_rad.size() == 1 ? "one edge"
                            : single                         ? "edges of one direction"
                                                             : "these edges"};
    if (helped) words.advice = words.single_advice = "add an edge across";
    if (names.size() > 1)
      if (const auto moment = combined_moment(problem, solved, weak.members))
        words.known = "their combined second moment is known (" + mtf::significant(moment->value, 3) + " +- " +
                      mtf::significant(moment->sd, 2) + " px^2)";
    std::string text = weak_direction_text(names, words);
    all.push_back({weak.members, weak.weight, std::move(text)});
  }
  return all;
}

}  // namespace calib
