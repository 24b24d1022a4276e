// SPDX-License-Identifier: Apache-2.0
#pragma once

// Hot and dead pixels, cosmic rays and the like: single pixels that differ from the others at the same distance from
// the edge by more than noise can. A pixel's residual is compared with the median of those at its distance, so that
// what all of them share (overshoot, a blur that the reference step does not describe) is never an outlier, and the
// size of the noise is the median absolute deviation, which the outliers themselves do not raise (P. J. Huber, Robust
// Statistics, 1981).

#include <cstddef>

#include "calib/measure/edge_fit.h"

namespace calib {

/// Removes them; returns how many. More than 2 % of the pixels are structure: then none is removed.
std::size_t remove_outliers(EdgePixels& pixels, const EdgeModel& model, const FitState& state,
                            const Rounding& rounding);

}  // namespace calib
