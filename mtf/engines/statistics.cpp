// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/statistics.h"

#include <algorithm>
#include <bit>

#include "mtf/engines/row_moments.h"

namespace mtf {

// The bits of a float without its sign are in the order of its magnitude, NaN beyond infinity.
bool all_finite(ImageView<const float> image) {
  constexpr std::uint32_t magnitude = 0x7fffffffU, infinity = 0x7f800000U;
  std::uint32_t largest = 0;
  for (std::int64_t y = 0; y < image.height; ++y) {
    const float* row = image.row(y);
    for (std::int64_t x = 0; x < image.width; ++x)
      largest = std::max(largest, std::bit_cast<std::uint32_t>(row[x]) & magnitude);
  }
  return largest < infinity;
}

Statistics statistics(ImageView<const float> image, int threads) {
  return statistics_of(row_moments(image, threads), image.width);
}

double canvas_norm(ImageView<const float> image, Border border, double border_value, double mean) {
  return canvas_norm_of(row_moments(image), image.width, border, border_value, mean);
}

}  // namespace mtf
