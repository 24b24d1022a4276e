// SPDX-License-Identifier: Apache-2.0
#pragma once

// Profile likelihood: how far a parameter can move, everything else fitted anew, until chi-square has risen by
// a quantile. It holds also where the likelihood is not a parabola, and costs a few fits per end.

#include "calib/fit/confidence/flat_bounds.h"

namespace calib {

struct ProfileEnds {
  std::array<double, 2> interval68{}, interval95{};  ///< ends; a bound where chi-square does not rise that far
  bool low_open = false, high_open = false;          ///< true: that end of interval95 is the bound
};

/// The profile of variable i around the minimum, at which the problem is before and after. `sd`: of x. `noise_factor`:
/// chi-square per degree of freedom, times the ratio of the variance to that with independent pixels (J. T. Kent,
/// Biometrika 69, 19 (1982)), by which rises are divided. Refits begin away from the `flat` bounds, which the minimiser
/// would not leave. The result is empty when the fit was stopped.
std::optional<ProfileEnds> profile(FitProblem& problem, std::size_t i, double sd, double cost, double noise_factor,
                                   std::span<const FlatBound> flat, const std::function<bool()>& go_on);

/// The root of the rise of chi-square, in sd of the noise, where variable i is held at x; otherwise as above.
double rise_at(FitProblem& problem, std::size_t i, double x, double cost, double noise_factor,
               std::span<const FlatBound> flat, const std::function<bool()>& go_on);

}  // namespace calib
