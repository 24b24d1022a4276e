// SPDX-License-Identifier: Apache-2.0
#include "calib/edge_pixels.h"

#include <algorithm>
#include <cmath>

namespace calib {

namespace {

// Where all but a few of a region's values are, several times as wide: one hot pixel must not set the scale of all.
struct Range {
  double low = -INFINITY, high = INFINITY;
};
Range usual_range(mtf::ImageView<const float> image, const Roi& roi) {
  constexpr std::int64_t kSome = 20000;
  constexpr double kOutside = 0.005, kTimes = 20.0;
  const std::int64_t step = std::max<std::int64_t>(1, roi.width * roi.height / kSome) | 1;
  std::vector<float> values;
  for (std::int64_t k = 0; k < roi.width * roi.height; k += step)
    if (const float value = image.row(roi.y + k / roi.width)[roi.x + k % roi.width]; std::isfinite(value))
      values.push_back(value);
  const auto outside = static_cast<std::ptrdiff_t>(kOutside * static_cast<double>(values.size()));
  if (outside < 1) return {};
  std::nth_element(values.begin(), values.begin() + outside, values.end());
  const double low = static_cast<double>(values[static_cast<std::size_t>(outside)]);
  std::nth_element(values.begin(), values.end() - 1 - outside, values.end());
  const double high = static_cast<double>(*(values.end() - 1 - outside));
  if (!(high > low)) return {};
  return {low - kTimes * (high - low), high + kTimes * (high - low)};
}

}  // namespace

RegionFacts survey(mtf::ImageView<const float> image, const Roi& roi, const ValueLimits& limits) {
  RegionFacts facts{.middle = {static_cast<double>(roi.x) + 0.5 * static_cast<double>(roi.width),
                               static_cast<double>(roi.y) + 0.5 * static_cast<double>(roi.height)}};
  const Range usual = usual_range(image, roi);
  double low = INFINITY, high = -INFINITY;
  for (std::int64_t j = roi.y; j < roi.y + roi.height; ++j) {
    const float* row = image.row(j);
    for (std::int64_t i = roi.x; i < roi.x + roi.width; ++i) {
      const double value = static_cast<double>(row[i]);
      if (!std::isfinite(value)) continue;
      ++facts.finite;
      if (value < usual.low || value > usual.high) {
        ++facts.wild;
        continue;
      }
      if (limits.clipped(row[i])) ++facts.clipped;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (facts.finite == 0) return facts;
  facts.low = low;
  facts.high = high;
  facts.offset = 0.5 * low + 0.5 * high;
  facts.scale = high > low ? high - low : 1.0;
  return facts;
}

EdgePixels gather_blocks(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& facts,
                         const ValueLimits& limits, std::int64_t& block_px) {
  constexpr std::int64_t kMostBlocks = 48;
  const std::int64_t shorter = std::min(roi.width, roi.height), longer = std::max(roi.width, roi.height);
  block_px = std::max<std::int64_t>({1, (longer + kMostBlocks - 1) / kMostBlocks, shorter >= 24 ? 2 : 1});
  EdgePixels blocks;
  for (std::int64_t top = 0; top < roi.height; top += block_px) {
    for (std::int64_t left = 0; left < roi.width; left += block_px) {
      double sum = 0.0, x = 0.0, y = 0.0;
      std::int64_t count = 0;
      for (std::int64_t j = top; j < std::min(top + block_px, roi.height); ++j) {
        const float* row = image.row(roi.y + j) + roi.x;
        for (std::int64_t i = left; i < std::min(left + block_px, roi.width); ++i) {
          const double value = static_cast<double>(row[i]);
          if (!facts.holds(value) || limits.clipped(row[i])) continue;
          sum += (value - facts.offset) / facts.scale;
          x += static_cast<double>(i);
          y += static_cast<double>(j);
          ++count;
        }
      }
      if (count == 0) continue;
      const double n = static_cast<double>(count);
      blocks.x.push_back(static_cast<float>(x / n + 0.5 - 0.5 * static_cast<double>(roi.width)));
      blocks.y.push_back(static_cast<float>(y / n + 0.5 - 0.5 * static_cast<double>(roi.height)));
      blocks.value.push_back(static_cast<float>(sum / n));
    }
  }
  return blocks;
}

EdgePixels gather_pixels(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& facts,
                         const ValueLimits& limits, const EdgeCurve& curve, double reach_px) {
  const Point n = curve.normal();
  const double scale = 1.0 / facts.scale;
  EdgePixels pixels;
  std::size_t count = 0;
  for (std::int64_t j = 0; j < roi.height; ++j) {
    const float* row = image.row(roi.y + j) + roi.x;
    const double y = static_cast<double>(j) + 0.5 - 0.5 * static_cast<double>(roi.height);
    const double u0 = n.y * (y - curve.origin.y) - n.x * (curve.origin.x + 0.5 * static_cast<double>(roi.width) - 0.5);
    // |u0 + n.x i| < reach
    double first = 0.0, end = static_cast<double>(roi.width);
    if (std::abs(n.x) * end > 1e-9) {
      const double a = (-reach_px - u0) / n.x, b = (reach_px - u0) / n.x;
      first = std::clamp(std::ceil(std::min(a, b)), 0.0, end);
      end = std::clamp(std::floor(std::max(a, b)) + 1.0, first, end);
    } else if (std::abs(u0) >= reach_px) {
      continue;
    }
    const auto room = count + static_cast<std::size_t>(end - first);
    for (auto* list : {&pixels.x, &pixels.y, &pixels.value})
      if (list->size() < room)
        list->resize(count + static_cast<std::size_t>(end - first) * static_cast<std::size_t>(roi.height - j));
    for (auto i = static_cast<std::int64_t>(first); i < static_cast<std::int64_t>(end); ++i) {
      const double value = static_cast<double>(row[i]);
      if (!facts.holds(value) || limits.clipped(row[i])) continue;
      pixels.x[count] = static_cast<float>(static_cast<double>(i) + 0.5 - 0.5 * static_cast<double>(roi.width));
      pixels.y[count] = static_cast<float>(y);
      pixels.value[count++] = static_cast<float>((value - facts.offset) * scale);
    }
  }
  for (auto* list : {&pixels.x, &pixels.y, &pixels.value}) list->resize(count);
  return pixels;
}

}  // namespace calib
