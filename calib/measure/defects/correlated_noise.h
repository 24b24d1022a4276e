// SPDX-License-Identifier: Apache-2.0
#pragma once

// Noise that neighbouring pixels share, as after demosaicing, denoising, resampling or JPEG. Its autocorrelation is
// that of the residuals of the flat sides, where the model has no structure of its own.

#include "calib/measure/edge_fit.h"

namespace calib {

/// The correlation of the residuals of a fitted model; without lags where the noise is that of independent pixels, or
/// rounding.
NoiseCorrelation noise_correlation(const EdgePixels& pixels, const EdgeModel& model, const FitState& state,
                                   const Rounding& rounding);

}  // namespace calib
