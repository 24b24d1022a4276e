// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a fit starts from: the pixels about the edge of a region, a first model, and what is known of the noise.

#include <optional>

#include "calib/edge/edge_pixels.h"
#include "calib/measure/defects/cut_values.h"
#include "calib/measure/edge_fit.h"
#include "calib/measure/measure.h"
#include "calib/measure/residual_sums.h"

namespace calib {

struct EdgeRegion {
  EdgePixels pixels;            ///< within kRange_px of the starting line
  CutPixels cut;                ///< those of them that are at a limit of the values
  EdgeModel start;              ///< a straight Gaussian step
  double extent_px = 0.0;       ///< of the pixels on one side of the edge, mean of both
  double local_noise_sd = 0.0;  ///< from differences of neighbouring pixels
  FitSettings settings;         ///< with the noise, if it is known, and the rounding of the pixels
  double neighbour_px = 0.0;    ///< distance of another edge beside the region; 0 = none
};

/// Empty where no line divides the region into a dark and a bright side. Pixels at limits that the options do not state
/// are added to the clipped ones of the region.
std::optional<EdgeRegion> gather_edge(mtf::ImageView<const float> image, const Roi& roi, RegionFacts& region,
                                      const MeasureOptions& options);

// A first model of the edge: the line that best divides the block means of a region into two values, over a fan of
// directions, refined by fitting a Gaussian step. Blocks and whole lines average the noise, so that edges are found
// whose contrast is a few times the noise of a pixel.

/// A straight model with a dark and a bright value and a Gaussian shape, in pixels. `blocks` are those of
/// gather_blocks(), `width_px` and `height_px` the size of the region.
EdgeModel start_edge(const EdgePixels& blocks, double block_px, double width_px, double height_px);

}  // namespace calib
