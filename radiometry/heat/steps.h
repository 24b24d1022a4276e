// SPDX-License-Identifier: Apache-2.0
#pragma once

// TR-BDF2 for a group of facets: a trapezoidal stage to t + gamma h, then the second-order backward difference to
// t + h, gamma = 2 - sqrt(2), so that both stages have the matrix M + a K with a = gamma h / 2 (Bank et al., IEEE
// Trans. Electron Devices 32, 1992, 1985; Hosea & Shampine, Appl. Numer. Math. 20, 21, 1996, for the embedded error
// estimate of third order, smoothed by one more solution with that matrix). It is L-stable: what is faster than a step
// dies out.
//   M (T_(n+1) - T_n) = h [w F_n + w F_g + d F_(n+1)],  w = sqrt(2)/4, d = gamma/2
// so the heat of a step is the sum of the flows at the three instants with these weights, to rounding.

#include <map>
#include <vector>

#include "radiometry/heat/lanes.h"

namespace radiometry::heat {

inline constexpr double kGamma = 0.58578643762690495120;  ///< 2 - sqrt(2)

/// Eliminations of one grid by the length of the step.
class Eliminations {
 public:
  Eliminations(const Grid& grid, bool sheet) : grid_(&grid), sheet_(sheet) {}
  const Elimination<double>& of_step(double step_s);
  /// Forgets all when there are too many; references end.
  void limit();

 private:
  const Grid* grid_;
  bool sheet_;
  std::map<double, Elimination<double>> of_step_;
};

/// Temperatures of a group on one grid, and what a step leaves.
struct GroupState {
  explicit GroupState(std::size_t nodes) : t(nodes * kLanes), first(nodes * kLanes), second(t), scratch(t) {}
  std::vector<double> t;              ///< K
  std::vector<double> first, second;  ///< increments of the two stages of the last step
  std::vector<double> scratch;
};

/// The boundaries at the three instants of a step: t, t + gamma h and t + h.
struct StepBoundaries {
  const Boundary *begin, *middle, *end;
};

/// `heat`: the heat over the boundaries is added there, unless it is null.
void take_step(const GroupGrid& group, const Elimination<double>& elimination, const StepBoundaries& boundaries,
               GroupState& state, HeatSums* heat);

/// The error of the step that was just taken from the temperatures `before`, K: the largest of the lanes.
double step_error(const GroupGrid& group, const Elimination<double>& elimination, const Boundary& begin,
                  const std::vector<double>& before, GroupState& after);

}  // namespace radiometry::heat
