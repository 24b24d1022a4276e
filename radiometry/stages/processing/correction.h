// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a camera does to its counts: two-point non-uniformity correction and replacement of bad pixels.
//   corrected = gain x raw + offset,   gain = response of all / response of the pixel,
// such that both flat frames it was measured with become uniform. At signals between and beyond the two a pixel that is
// not linear keeps a residual, and the noise of the flat frames stays in the maps: average many.

#include <cstdint>
#include <span>
#include <vector>

#include "mtf/image.h"

namespace radiometry {

struct Place {
  std::int64_t x = 0, y = 0;
};

struct TwoPoint {
  mtf::Image gain, offset;
  std::vector<Place> bad;  ///< they have gain 1 and offset 0, and are to be replaced
};

/// From two flat frames, each the mean of many. A pixel is bad when a value is not finite or its response, hot minus
/// cold, differs from the median one by more than `limit` of it, 0 < limit <= 1. Throws UsageError for images of
/// different or no size, and when the median response is not above 0.
TwoPoint two_point_correction(mtf::ImageView<const float> cold, mtf::ImageView<const float> hot, double limit = 0.5);

/// image = gain x image + offset. UsageError for an image of another size.
void correct(mtf::ImageView<float> image, const TwoPoint& correction, int threads = 1);

/// Gives each bad pixel the mean of the good ones in the smallest square around it that has any, up to 17 x 17, or else
/// of all good ones. Good pixels stay. Throws UsageError for places outside of the image and when no pixel is good.
void replace_bad(mtf::ImageView<float> image, std::span<const Place> bad);

}  // namespace radiometry
