// SPDX-License-Identifier: Apache-2.0
#pragma once

// Noise of the pixels of an edge, from what pixels at the same distance differ by: variance = dark + (bright - dark) E,
// linear in the signal as that of photon noise, and equal on both sides unless the data show that it differs. Where
// pixels differ less than the step between neighbouring values allows (a plateau on one value), their noise is taken to
// be that of rounding, step^2 / 12.

#include <algorithm>

#include "calib/edge/pixel_correlation.h"
#include "calib/measure/residual_sums.h"

namespace calib {

/// Steps between neighbouring values at the dark and at the bright value, 0 = none.
struct Rounding {
  double dark = 0.0, bright = 0.0;
};

struct NoiseModel {
  double dark = 1.0, bright = 1.0;              ///< variances
  double least_dark = 0.0, least_bright = 0.0;  ///< the smallest variances there can be
  double at(double esf) const {
    const double inside = std::clamp(esf, 0.0, 1.0);
    return std::max(least_dark + (least_bright - least_dark) * inside, dark + (bright - dark) * esf);
  }
};

/// `least` > 0: the smallest variance there can be, besides that of rounding.
NoiseModel estimate_noise(const EdgeSums& sums, const StepProfile& profile, double least, const Rounding& rounding);

/// Variance of a pixel by bin.
BinRow variances(const NoiseModel& noise, const StepProfile& profile);

/// 1 / variance of a pixel by bin. Pixels within half a step of their plateau's value round alike where noise does not
/// break that up: all n of a plateau then share one error, of variance step^2 / 12 x exp(-4 pi^2 noise^2 / step^2) (the
/// first harmonic of rounding, B. Widrow and I. Kollar, Quantization Noise, 2008), and hold no more information than
/// one of them; each has the weight 1 / (variance + n x that). With `few_distances`, along the pixels' grid, so do the
/// pixels at each distance between the plateaus.
BinRow pixel_weights(const EdgeSums& sums, const EdgeModel& model, const StepProfile& profile, const NoiseModel& noise,
                     const Rounding& rounding, bool few_distances = false);

}  // namespace calib
