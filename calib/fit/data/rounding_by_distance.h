// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rounding along the pixels' grid. Where an edge shows few distances a pixel, all pixels at one distance have the same
// value but for the noise. Noise that is small against the step between values does not break up their rounding errors:
// the pixels round alike and share one error.

#include <span>
#include <vector>

#include "calib/fit/data/data_block.h"

namespace calib {

struct RoundingByDistance {
  /// Of each pixel: how many pixels are as far from the edge, to an eighth of a pixel.
  std::vector<double> alike;
  /// Variance of the noise before rounding, in squared steps. Pixels at one distance scatter by what their place
  /// between two steps makes of the noise, from nothing to half a step; the mean over the places is the noise's and 1
  /// / 12.
  double noise_steps2 = 0.0;
};

/// `esf`: the edge spread function at each residual, whose plateaus are one place each; `quantum`: the step, above 0.
RoundingByDistance rounding_by_distance(std::span<const Residual> residuals, std::span<const double> esf,
                                        double quantum);

}  // namespace calib
