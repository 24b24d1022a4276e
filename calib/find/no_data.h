// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pixels that have no data become NaN.
//
// Of a colour filter mosaic one colour, without demosaicing: an image of the same size that is NaN where the sensor has
// another filter. Coordinates, and cycles per pixel, stay those of the sensor; distances from an edge that no pixel of
// the colour has at one place occur elsewhere along the edge. A pattern names the filters of the first two rows, two
// each: rggb is R G over G B. Of the greens, gr stands in rows of red and gb in rows of blue.
//
// A mask is an image of the same size, 0 (or NaN) where a pixel is not to be used.

#include <array>
#include <cstdint>
#include <string_view>

#include "mtf/image.h"

namespace calib {

inline constexpr std::array<std::string_view, 4> kBayerPatterns{"rggb", "grbg", "gbrg", "bggr"};
inline constexpr std::array<std::string_view, 5> kBayerPlanes{"r", "gr", "gb", "b", "g"};  ///< g: both greens

/// Throws UsageError for a pattern or plane that is none of these (lower or upper case).
mtf::Image bayer_plane(mtf::ImageView<const float> image, std::string_view pattern, std::string_view plane);

/// Pixels become NaN where the mask is 0 or NaN. Returns how many are left. Throws UsageError when sizes differ.
std::int64_t apply_mask(mtf::ImageView<float> image, mtf::ImageView<const float> mask);

}  // namespace calib
