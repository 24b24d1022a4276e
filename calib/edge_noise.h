// SPDX-License-Identifier: Apache-2.0
#pragma once

// Noise of the pixels of an edge, from what pixels at the same distance differ by: variance = dark + (bright - dark) E,
// straight in the level as photon noise is, equal on both sides where the data do not show that it differs. Pixels that
// differ less than the step between neighbouring values allows (a plateau on one value) count as uniformly rounded.

#include <algorithm>

#include "calib/edge_sums.h"

namespace calib {

struct NoiseModel {
  double dark = 1.0, bright = 1.0;  ///< variances
  double at(double esf) const { return std::max(least, dark + (bright - dark) * esf); }
  double least = 0.0;
};

/// `least` > 0: the smallest variance there can be.
NoiseModel estimate_noise(const EdgeSums& sums, const StepProfile& profile, double least);

}  // namespace calib
