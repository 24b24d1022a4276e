// SPDX-License-Identifier: Apache-2.0
#pragma once

// Intervals by profile likelihood, where they were asked for and where a flat bound makes standard errors wrong, and
// what then is known of each parameter.

#include <functional>

#include "calib/fit_rounds.h"
#include "calib/flat_bounds.h"

namespace calib {

/// Where the minimiser has come to rest at a flat bound it is started once more where the parameters act; a lower
/// minimum is taken, and `solved` brought up to it. True when it was.
bool leave_flat_bounds(FitProblem& problem, Solved& solved, std::span<const FlatBound> flat, Solution& solution,
                       const MinimiseOptions& options);

/// Sets intervals, limits, knowledge; takes back correlations and directions that stand for no more than the missing
/// derivative. `cost`: at the minimum, where the problem stands. Parameters of which the data say nothing are left out
/// unless a flat bound is near.
void report_intervals(FitProblem& problem, const Solved& solved, std::span<const FlatBound> flat, double cost,
                      const std::function<bool()>& go_on, FitResult& result);

}  // namespace calib
