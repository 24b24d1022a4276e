// SPDX-License-Identifier: Apache-2.0
#pragma once

// Noise that neighbouring pixels share, as after demosaicing, denoising, resampling or JPEG. Its autocorrelation is
// that of the residuals of the flat sides, where the model has no structure of its own. Lags are taken ring by ring
// around zero as long as a ring as a whole differs from no correlation; noise of independent pixels has none, and
// nothing is changed then. The mean of a side is fitted, which lowers each of the estimated correlations by (sum of all
// correlations) x (number of fitted terms) / (number of pixels); that is added back.

#include "calib/measure/edge_fit.h"

namespace calib {

/// The correlation of the residuals of a fitted model; without lags where the noise is that of independent pixels, or
/// where the residuals show the misfit of the model or rounding rather than noise.
NoiseCorrelation correlation_of(const EdgePixels& pixels, const EdgeModel& model, const FitState& state,
                                const Rounding& rounding);

}  // namespace calib
