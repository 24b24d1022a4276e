// SPDX-License-Identifier: Apache-2.0
#pragma once

// No-data masks: an image of the same size, 0 (or NaN) where a pixel is not to be used.

#include <cstdint>

#include "mtf/image.h"

namespace calib {

/// Pixels become NaN where the mask is 0 or NaN. Returns how many are left. Throws UsageError when sizes differ.
std::int64_t apply_mask(mtf::ImageView<float> image, mtf::ImageView<const float> mask);

}  // namespace calib
