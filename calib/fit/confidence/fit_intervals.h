// SPDX-License-Identifier: Apache-2.0
#pragma once

// Intervals from the likelihood, where they were asked for and where a flat point makes standard errors wrong, and
// what then is known of each parameter.

#include <functional>

#include "calib/fit/confidence/flat_points.h"
#include "calib/fit/confidence/mirrors.h"

namespace calib {

/// Where the minimiser has ended at a flat point it is started once more where the parameters act; a lower minimum is
/// taken and `solved` updated. Returns true when there was one.
bool leave_flat_points(FitProblem& problem, Solved& solved, std::span<const FlatPoint> flat, Solution& solution,
                       const MinimiseOptions& options);

/// A square at whose far end the root of the rise of chi-square differs from what the covariance foretells.
struct BentSquare {
  std::vector<double> x{};  ///< all parameters, fitted with the square held there
};

/// Intervals of parameters that are fitted as squares and known to a tenth or worse: that of the square, cut to its
/// range, as value +- 1.96 stderr never holds 0; where 0 is no bound of the parameter it extends to both sides. Where
/// the interval holds the bound of the square, chi-square at its far end is computed: those for which that is not what
/// the covariance foretells, so that only profiles can be trusted.
std::vector<BentSquare> report_squares(FitProblem& problem, const Solved& solved, double cost,
                                       const std::function<bool()>& go_on, FitResult& result);

/// Sets intervals, limits, knowledge; takes back correlations and directions that stand for no more than the missing
/// derivative. `cost`: at the minimum, where the problem stands. Standard errors that the profile contradicts are taken
/// back about flat points and `bent` squares. Without a flat point, and unless `all` are asked for, those are profiled
/// that move by more than counts where a bent square is at its far end. Parameters on which the data do not depend are
/// left out unless a flat point is near. About a flat point the interval has a part at each of the `mirrors` that the
/// data allow.
void report_intervals(FitProblem& problem, const Solved& solved, std::span<const FlatPoint> flat,
                      std::span<const BentSquare> bent, bool all, double cost, std::span<const Mirror> mirrors,
                      const std::function<bool()>& go_on, FitResult& result);

/// The root of the rise of chi-square, in sd of the noise, where variable i is held at x; `cost` is at the minimum, at
/// which the problem is before and after, and `noise_factor` that by which rises are divided. Refits begin away from
/// the `flat` points. `all`: takes x of all variables at that fit.
double rise_at(FitProblem& problem, std::size_t i, double x, double cost, double noise_factor,
               std::span<const FlatPoint> flat, const std::function<bool()>& go_on, std::vector<double>* all = nullptr);

}  // namespace calib
