// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the edge of a region roughly is: the best division of block means into two levels by a line, over a fan of
// directions, refined by fitting a Gaussian step. Blocks and whole lines average the noise, so that edges are found
// whose contrast is a few times that of a pixel.

#include "calib/measure/edge_sums.h"

namespace calib {

/// `blocks` as of gather_blocks. A straight model with levels and a Gaussian shape, in pixels. `width_px`, `height_px`:
/// of the region.
EdgeModel start_edge(const EdgePixels& blocks, double block_px, double width_px, double height_px);

/// The part of the edge's tangent inside a rectangle about the middle of the region: the origin is moved to its middle,
/// half of its length returned, 0 where the line misses the rectangle.
double centre_on_region(EdgeCurve& curve, double width_px, double height_px);

}  // namespace calib
