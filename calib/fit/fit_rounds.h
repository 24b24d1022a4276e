// SPDX-License-Identifier: Apache-2.0
#pragma once

// The course of a fit: plain least squares on some pixels to come close, then the robust loss on all; the same from
// further starts where they are asked for; then, where the residuals show the need, again with gradients of the
// plateaus, with noise that follows from the fitted values, with noise that agrees with the residuals.

#include "calib/fit/fit_report.h"

namespace calib {

struct MinimiseOptions {
  bool robust = true;
  int starts = 1;
  std::function<bool()> go_on{};
};

/// Leaves the minimum in the problem, and its normal matrices and noise factors in `solved`. It may add unknowns to
/// edges.
Solution minimise(FitProblem& problem, Solved& solved, const MinimiseOptions& options);

/// The fits that follow a first minimum, whose count of iterations they continue; results as above.
Solution finish(FitProblem& problem, Solved& solved, const Solution& first, const MinimiseOptions& options);

/// Gives the plateaus of an edge gradients, 0 so far.
void add_gradients(FitProblem& problem, std::size_t edge);

/// Chi-square per degree of freedom of all data, by which rises of chi-square are divided.
double noise_factor_of(const FitProblem& problem, const Solved& solved);

}  // namespace calib
