// SPDX-License-Identifier: Apache-2.0
#pragma once

// A fit without a look at the pixels, from the sums that one look left. Levels and places of the edge act on a pixel
// nearly linearly, and the shape of the step by a change of E that hardly varies over a bin: what residuals and their
// products with t^k become follows from the sums of t^k alone,
//   r' = r - sum over levels and shifts of (change x derivative) - (B - D) (E' - E + shift^2 E'' / 2),
// where the pixels of each bin are on average: nearly exact in the shape, to third order in the shifts, or to second
// where the sums have too few powers of t. So many rounds cost less than one over the pixels; the end of them is what
// these would come to, or a start for their own fit, or a comparison of shapes.

#include "calib/measure/edge_fit.h"

namespace calib {

/// The best fit that the sums of `state` tell of. `state` is that of the model `from`; the rounds begin at `model`,
/// which differs in nothing but levels, shape and a short way of the curve, and moves. Noise stays that of the state.
FitState fit_on_bins(const FitState& state, const EdgeModel& from, EdgeModel& model, const FitRounds& rounds);

/// Whether another look at the pixels would tell no more than `near`, fitted on bins to the sums of a look at `from`:
/// derivatives of the pixels at their new distances are nearly those at the old ones, and the third order in the
/// shifts, which is left out above, comes to less than `enough` of chi2.
bool predicts_convergence(const EdgeModel& from, const FitState& near, const EdgeModel& model, double enough);

}  // namespace calib
