// SPDX-License-Identifier: Apache-2.0
#include "mtf/statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>

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

Statistics statistics(ImageView<const float> image) {
  Statistics s;
  double sum = 0.0;
  std::int64_t finite = 0;
  for (std::int64_t y = 0; y < image.height; ++y) {
    const float* row = image.row(y);
    double row_sum = 0.0;
    for (std::int64_t x = 0; x < image.width; ++x) {
      const double v = row[x];
      if (!std::isfinite(v)) {
        if (s.not_finite++ == 0) s.first_x = x, s.first_y = y;
        continue;
      }
      if (finite++ == 0) s.min = s.max = v;
      s.min = std::min(s.min, v);
      s.max = std::max(s.max, v);
      row_sum += v;
    }
    sum += row_sum;
  }
  if (finite == 0) return s;
  // A flat image has exactly its value as mean and exactly zero contrast.
  s.mean = s.min == s.max ? s.min : sum / static_cast<double>(finite);
  const double scale = std::max(s.max - s.mean, s.mean - s.min);
  if (scale == 0.0) return s;
  double squares = 0.0;
  for (std::int64_t y = 0; y < image.height; ++y) {
    double row_squares = 0.0;
    for (std::int64_t x = 0; x < image.width; ++x) {
      const double d = (image.row(y)[x] - s.mean) / scale;
      if (std::isfinite(d)) row_squares += d * d;
    }
    squares += row_squares;
  }
  s.std = scale * std::sqrt(squares / static_cast<double>(finite));
  return s;
}

double canvas_norm(ImageView<const float> image, Border border, double border_value, double mean) {
  // Each pixel counts as often as the canvas repeats it: edge samples n + 1 times per replicated side.
  const auto weight = [border](std::int64_t i, std::int64_t n) {
    if (border == Border::reflect) return 2.0;
    if (border != Border::replicate) return 1.0;
    return 1.0 + (i == 0 ? static_cast<double>(n) : 0.0) + (i == n - 1 ? static_cast<double>(n) : 0.0);
  };
  double sum = 0.0;
  for (std::int64_t y = 0; y < image.height; ++y) {
    double row_sum = 0.0;
    for (std::int64_t x = 0; x < image.width; ++x) {
      const double d = image.row(y)[x] - mean;
      row_sum += weight(x, image.width) * d * d;
    }
    sum += weight(y, image.height) * row_sum;
  }
  const double area = static_cast<double>(image.width) * static_cast<double>(image.height);
  if (border == Border::constant) sum += 8.0 * area * (border_value - mean) * (border_value - mean);
  return std::sqrt(sum / area);
}

}  // namespace mtf
