// SPDX-License-Identifier: Apache-2.0
#pragma once

// The 95 % interval of a parameter about a flat point (flat_points.h), where chi-square is no parabola. Where the
// effect is mirrored, the interval may be two parts, one for each sign, or hold the centre.
//
// A value belongs to it where chi-square, the other parameters fitted anew, rises by no more than it does in 95 % of
// images of a sensor with that value. By how much that is depends on how the model bends: 2.7 at a point beyond which
// nothing differs, 3.84 where the effect is in proportion, up to 5 where two signs are half told apart. (Feldman and
// Cousins, Phys. Rev. D 57, 3873 (1998).) The images are those of the model itself: the residuals r(u) of fits with the
// parameter held at u, which differ by what the data see of the parameter, r(u) - r(w), however much noise they have.
// These differences span few dimensions, in which noise is drawn.

#include <functional>

#include "calib/fit/confidence/flat_points.h"

namespace calib {

/// Parts of the range of x, in rising order, with the x of the least chi-square in each.
struct IntervalPart {
  double low = 0.0, high = 0.0, best = 0.0;
  double rise = 0.0;  ///< of chi-square there, above the minimum
};
struct FlatInterval {
  std::vector<IntervalPart> parts68, parts95;
};

/// `cost` at the minimum, at which the problem is before and after; `noise_factor` as for profile.h. The other `flat`
/// points are left by every fit. Empty when the fit was stopped.
std::optional<FlatInterval> flat_interval(FitProblem& problem, const FlatPoint& point, double first_step, double cost,
                                          double noise_factor, std::span<const FlatPoint> flat,
                                          const std::function<bool()>& go_on);

}  // namespace calib
