// SPDX-License-Identifier: Apache-2.0
#pragma once

// Profile likelihood: how far a parameter can move, everything else fitted anew, until chi-square has risen by
// a quantile (allowed_rise). It holds also where the likelihood is not a parabola, and costs a few fits per end.

#include "calib/fit/confidence/flat_points.h"

namespace calib {

/// Fits with variable i held. `cost` and `noise_factor`: as for profile().
struct Profiler {
  FitProblem& problem;
  std::size_t i;
  double cost, noise_factor;
  std::span<const FlatPoint> flat;
  const std::function<bool()>& go_on;
  bool stopped = false;

  /// The root of the rise of chi-square at x, in sd of the noise: nearly linear in x. The problem is at that fit then,
  /// and the next one begins there.
  double at(double x);
};

/// Ends of intervals, in x; a bound where chi-square does not rise that far.
struct XEnds {
  std::array<double, 2> x68{}, x95{};
};

/// The profile of variable i around the minimum, at which the problem is before and after. `sd`: of x. `noise_factor`:
/// chi-square per degree of freedom, times the ratio of the variance to that with independent pixels (J. T. Kent,
/// Biometrika 69, 19 (1982)), by which rises are divided. Refits begin away from the `flat` points, which the minimiser
/// would not leave. The result is empty when the fit was stopped.
std::optional<XEnds> profile(FitProblem& problem, std::size_t i, double sd, double cost, double noise_factor,
                             std::span<const FlatPoint> flat, const std::function<bool()>& go_on);

/// The root of the rise of chi-square, in sd of the noise, where variable i is held at x; otherwise as above.
double rise_at(FitProblem& problem, std::size_t i, double x, double cost, double noise_factor,
               std::span<const FlatPoint> flat, const std::function<bool()>& go_on);

}  // namespace calib
