// SPDX-License-Identifier: Apache-2.0
#pragma once

// A first model of the edge: the line that best divides the block means of a region into two values, over a fan of
// directions, refined by fitting a Gaussian step. Blocks and whole lines average the noise, so that edges are found
// whose contrast is a few times the noise of a pixel.

#include "calib/measure/residual_sums.h"

namespace calib {

/// A straight model with a dark and a bright value and a Gaussian shape, in pixels. `blocks` are those of
/// gather_blocks(), `width_px` and `height_px` the size of the region.
EdgeModel start_edge(const EdgePixels& blocks, double block_px, double width_px, double height_px);

/// Moves the origin of the curve to the middle of the part of its tangent that lies inside a rectangle about the middle
/// of the region; returns half the length of that part, 0 where the line misses the rectangle.
double centre_on_region(EdgeCurve& curve, double width_px, double height_px);

}  // namespace calib
