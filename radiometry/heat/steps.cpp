// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/steps.h"

#include <algorithm>

namespace radiometry::heat {
namespace {

constexpr std::size_t kMostEliminations = 1024;

/// M D2 = kKeep M D1 + a F_(n+1)
constexpr double kKeep = (1.0 - kGamma) * (1.0 - kGamma) / (kGamma * (2.0 - kGamma));

// 2 k h [F_n / gamma - F_g / (gamma (1 - gamma)) + F_(n+1) / (1 - gamma)] with h = 2 a / gamma,
// a F_g = M D1 - a F_n and a F_(n+1) = M (D2 - kKeep D1).
constexpr double kError = (-3.0 * kGamma * kGamma + 4.0 * kGamma - 2.0) / (12.0 * (2.0 - kGamma)) * 4.0 / kGamma;
constexpr ErrorWeights kErrorWeights{.of_flow = kError * (1.0 / kGamma + 1.0 / (kGamma * (1.0 - kGamma))),
                                     .of_first = -kError * (1.0 / (kGamma * (1.0 - kGamma)) + kKeep / (1.0 - kGamma)),
                                     .of_second = kError / (1.0 - kGamma)};

}  // namespace

const Elimination<double>& Eliminations::of_step(double step_s) {
  const auto found = of_step_.find(step_s);
  if (found != of_step_.end()) return found->second;
  return of_step_.emplace(step_s, eliminate(*grid_, sheet_, 0.5 * kGamma * step_s)).first->second;
}

void Eliminations::limit() {
  if (of_step_.size() > kMostEliminations) of_step_.clear();
}

void take_step(const GroupGrid& group, const Elimination<double>& elimination, const StepBoundaries& boundaries,
               GroupState& state, HeatSums* heat) {
  const double outer = (1.0 + kKeep) * elimination.a;  // w h
  if (heat) add_heat(group, *boundaries.begin, state.t, outer, *heat);
  run_stage(group, {&elimination, 0.0, boundaries.begin, boundaries.middle}, state.t, state.first, state.scratch);
  if (heat) add_heat(group, *boundaries.middle, state.t, outer, *heat);
  std::copy(state.first.begin(), state.first.end(), state.second.begin());
  run_stage(group, {&elimination, kKeep, nullptr, boundaries.end}, state.t, state.second, state.scratch);
  if (heat) add_heat(group, *boundaries.end, state.t, elimination.a, *heat);
}

double step_error(const GroupGrid& group, const Elimination<double>& elimination, const Boundary& begin,
                  const std::vector<double>& before, GroupState& after) {
  return surface_error(group, elimination, kErrorWeights, begin, before, after.first, after.second, after.scratch);
}

}  // namespace radiometry::heat
