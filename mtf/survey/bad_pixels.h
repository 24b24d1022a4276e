// SPDX-License-Identifier: Apache-2.0
#pragma once

// NaN and infinite pixels, for users who ask that they be accepted.

#include "mtf/image.h"
#include "mtf/plan/sensor_plan.h"

namespace mtf {

/// Replaces every non-finite pixel by an average of finite ones near it: means over ever coarser 2x2 cells are taken
/// until every cell has a value, and gaps are filled from the finest cells that have one. Linear in the number of
/// pixels. Returns the number replaced. Throws RuntimeError when no pixel is finite.
std::int64_t fill_bad_pixels(ImageView<float> image);

/// 1 where the pixel is NaN or infinite, 0 elsewhere; empty (0x0) when all are finite.
Image bad_pixel_mask(ImageView<const float> image);

/// Sets to NaN every pixel of `image` that bad samples of the scene affect: their own pixel, and those within the box
/// around it in which the response to one sample exceeds `tolerance` of that sample. Filters after the sampling widen
/// these boxes by the same rule.
void propagate_bad_pixels(const SensorPlan& plan, const Image& mask, double tolerance, int threads,
                          ImageView<float> image);

}  // namespace mtf
