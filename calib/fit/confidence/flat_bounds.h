// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bounds at which the effect of a parameter vanishes with its first derivative: a diffusion length towards 0 acts by
// its cube, a delay whose shift is the edge's own offset by its square. There the covariance, which is made of first
// derivatives, shows no dependence on the parameter and no correlation with it, and a minimiser that has
// come to the bound does not leave it. Intervals of such a parameter and of its partners come from the profile
// (profile.h).
//
// The information of the parameter alone, S(u) at the distance u from its bound, shows this: it is constant where the
// effect grows in proportion, and falls with u^(2p - 2) where it grows as u^p.

#include <optional>
#include <vector>

#include "calib/fit/fit_report.h"

namespace calib {

struct FlatBound {
  std::size_t parameter = 0;
  double bound = 0.0;     ///< value of x at the bound
  double inward = 1.0;    ///< +1 when the range lies above the bound, -1 when below
  double off = 0.0;       ///< distance from the bound at which the effect is above the noise
  bool at_bound = false;  ///< the present x differs from the bound by less than can be seen

  /// Returns x, or the place where the parameter acts if x is too near to the bound.
  double off_bound(double x) const;
};

/// For the parameters near a flat bound at the solution; afterwards the problem is at the solution again. Costs a
/// few passes over the data for a parameter that a bound is near to, nothing for the others.
std::vector<FlatBound> flat_bounds(FitProblem& problem, const Solved& solved);

/// Takes a parameter at its flat bound out of the information: except for rounding, first derivatives tell nothing of
/// its correlation with the others there.
void set_apart(Solved& solved, std::span<const FlatBound> flat);

}  // namespace calib
