// SPDX-License-Identifier: Apache-2.0
#include "calib/edge/edge_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "mtf/math/clones.h"
#include "mtf/work/stop.h"

namespace calib {

namespace {

// How many values lie between two bounds (NaN and infinite ones lie in none), the least and the largest of them.
struct Extent {
  std::int64_t count = 0;
  float low = INFINITY, high = -INFINITY;
};

MTFKIT_CLONES void extend(const float* values, std::int64_t n, float from, float to, Extent& extent) {
  constexpr std::size_t kLanes = 16;
  std::array<float, kLanes> low, high;
  std::array<std::int32_t, kLanes> count{};
  low.fill(extent.low);
  high.fill(extent.high);
  const auto take = [&](std::size_t k, float value) {
    const bool inside = value >= from && value <= to;
    count[k] += inside ? 1 : 0;
    low[k] = inside && value < low[k] ? value : low[k];
    high[k] = inside && value > high[k] ? value : high[k];
  };
  std::int64_t i = 0;
  for (; i + static_cast<std::int64_t>(kLanes) <= n; i += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) take(k, values[static_cast<std::size_t>(i) + k]);
  for (; i < n; ++i) take(0, values[i]);
  for (std::size_t k = 0; k < kLanes; ++k) {
    extent.low = std::min(extent.low, low[k]);
    extent.high = std::max(extent.high, high[k]);
    extent.count += count[k];
  }
}

Extent extent_of(mtf::ImageView<const float> image, const Roi& roi, float from, float to) {
  Extent extent;
  for (std::int64_t j = roi.y; j < roi.y + roi.height; ++j) {
    mtf::require_going_on();
    extend(image.row(j) + roi.x, roi.width, from, to, extent);
  }
  return extent;
}

// The range of all but a few of a region's values, widened several times: one hot pixel must not set the scale of all.
struct Range {
  double low = 0.0, high = 0.0;
  bool holds(const Extent& extent) const {
    return static_cast<double>(extent.low) >= low && static_cast<double>(extent.high) <= high;
  }
};
std::optional<Range> usual_range(mtf::ImageView<const float> image, const Roi& roi, std::int64_t some,
                                 double outside_share) {
  constexpr double kTimes = 20.0;
  const std::int64_t step = std::max<std::int64_t>(1, roi.width * roi.height / some) | 1;
  std::vector<float> values;
  values.reserve(static_cast<std::size_t>(roi.width * roi.height / step + 1));
  visit_some(roi, step, [&](std::int64_t x, std::int64_t y) {
    if (std::isfinite(image.at(x, y))) values.push_back(image.at(x, y));
  });
  const auto outside = static_cast<std::ptrdiff_t>(outside_share * static_cast<double>(values.size()));
  if (outside < 1) return std::nullopt;
  std::nth_element(values.begin(), values.begin() + outside, values.end());
  const double low = static_cast<double>(values[static_cast<std::size_t>(outside)]);
  std::nth_element(values.begin() + outside, values.end() - 1 - outside, values.end());
  const double high = static_cast<double>(*(values.end() - 1 - outside));
  return Range{low - kTimes * (high - low), high + kTimes * (high - low)};
}

// The bounds of the values that are used, neither wild nor clipped. NaN lies within no bounds.
struct ValueBounds {
  float low, high;
};
ValueBounds bounds_of(const RegionFacts& facts, const ValueLimits& limits) {
  ValueBounds bounds{static_cast<float>(facts.low), static_cast<float>(facts.high)};
  if (limits.saturation)
    bounds.high = std::min(bounds.high, std::nextafter(static_cast<float>(*limits.saturation), -INFINITY));
  if (limits.floor) bounds.low = std::max(bounds.low, std::nextafter(static_cast<float>(*limits.floor), INFINITY));
  return bounds;
}

MTFKIT_CLONES bool all_within(const float* values, std::int64_t n, ValueBounds bounds) {
  std::int32_t outside = 0;
  for (std::int64_t i = 0; i < n; ++i) outside += values[i] >= bounds.low && values[i] <= bounds.high ? 0 : 1;
  return outside == 0;
}

// Positions and scaled values of a row of pixels.
MTFKIT_CLONES void fill_row(const float* __restrict row, std::int64_t n, double left, double offset, double scale,
                            double* __restrict x, double* __restrict values) {
  const auto size = static_cast<std::int32_t>(n);
  for (std::int32_t i = 0; i < size; ++i) {
    x[i] = static_cast<double>(i) + left;
    values[i] = (static_cast<double>(row[i]) - offset) * scale;
  }
}

// Sums of the rows' values, less the offset.
MTFKIT_CLONES void add_row(const float* __restrict row, std::int64_t n, double offset, double* __restrict sums) {
  for (std::int64_t i = 0; i < n; ++i) sums[i] += static_cast<double>(row[i]) - offset;
}

}  // namespace

std::size_t step_for(const EdgePixels& pixels, std::size_t some) {
  std::size_t row = 0, step = std::max<std::size_t>(1, pixels.size() / some);
  while (row < pixels.size() && pixels.y()[row] == pixels.y()[0]) ++row;
  while (std::gcd(step, row) > 1) ++step;
  return step;
}

RegionFacts survey(mtf::ImageView<const float> image, const Roi& roi, const ValueLimits& limits) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  RegionFacts facts{.middle = {static_cast<double>(roi.x) + 0.5 * static_cast<double>(roi.width),
                               static_cast<double>(roi.y) + 0.5 * static_cast<double>(roi.height)}};
  Extent extent = extent_of(image, roi, -kLargest, kLargest);
  facts.finite = extent.count;
  if (facts.finite == 0) return facts;
  // The narrower range of most of a sample of 300 is a quick test: where all values lie within it, none is wild.
  if (const auto most = usual_range(image, roi, 300, 0.05); !most || !most->holds(extent)) {
    const auto usual = usual_range(image, roi, 20000, 0.005);
    if (usual && usual->high > usual->low && !usual->holds(extent)) {
      extent = extent_of(image, roi, static_cast<float>(usual->low), static_cast<float>(usual->high));
      facts.wild = facts.finite - extent.count;
    }
  }
  facts.low = static_cast<double>(extent.low);
  facts.high = static_cast<double>(extent.high);
  if (limits.clipped(extent.low) || limits.clipped(extent.high))
    for (std::int64_t j = roi.y; j < roi.y + roi.height; ++j) {
      mtf::require_going_on();
      for (const float value : std::span(image.row(j) + roi.x, static_cast<std::size_t>(roi.width)))
        facts.clipped += facts.holds(static_cast<double>(value)) && limits.clipped(value) ? 1 : 0;
    }
  facts.offset = 0.5 * facts.low + 0.5 * facts.high;
  facts.scale = facts.high > facts.low ? facts.high - facts.low : 1.0;
  return facts;
}

std::string why_infinite(mtf::ImageView<const float> image, const Roi& roi) {
  std::int64_t count = 0;
  for (std::int64_t j = roi.y; j < roi.y + roi.height; ++j)
    for (const float value : std::span(image.row(j) + roi.x, static_cast<std::size_t>(roi.width)))
      count += std::isinf(value) ? 1 : 0;
  if (count == 0) return "";
  return "no pixel holds a finite value, and " + std::to_string(count) +
         " are infinite or beyond 3.4e38, the largest value that is kept: divide the values by a constant";
}

EdgePixels gather_blocks(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& facts,
                         const ValueLimits& limits, std::int64_t& block_px) {
  constexpr std::int64_t kMostBlocks = 48;
  const std::int64_t shorter = std::min(roi.width, roi.height), longer = std::max(roi.width, roi.height);
  block_px = std::max<std::int64_t>({1, (longer + kMostBlocks - 1) / kMostBlocks, shorter >= 24 ? 2 : 1});
  const ValueBounds bounds = bounds_of(facts, limits);
  // The centroid of the pixels that are used, for blocks where some are not.
  const auto centroid = [&](std::int64_t left, std::int64_t top, std::int64_t right, std::int64_t bottom) {
    double x = 0.0, y = 0.0, n = 0.0;
    for (std::int64_t j = top; j < bottom; ++j)
      for (std::int64_t i = left; i < right; ++i) {
        const float value = image.at(roi.x + i, roi.y + j);
        if (!(value >= bounds.low && value <= bounds.high)) continue;
        x += static_cast<double>(i) + 0.5;
        y += static_cast<double>(j) + 0.5;
        n += 1.0;
      }
    return Point{x / n, y / n};
  };
  EdgePixels blocks(
      static_cast<std::size_t>((roi.width + block_px - 1) / block_px * ((roi.height + block_px - 1) / block_px)));
  std::vector<double> column(static_cast<std::size_t>(roi.width));
  for (std::int64_t top = 0; top < roi.height; top += block_px) {
    mtf::require_going_on();
    const std::int64_t bottom = std::min(top + block_px, roi.height);
    bool all = true;
    std::fill(column.begin(), column.end(), 0.0);
    for (std::int64_t j = top; j < bottom && all; ++j) {
      const float* row = image.row(roi.y + j) + roi.x;
      all = all_within(row, roi.width, bounds);
      if (all) add_row(row, roi.width, facts.offset, column.data());
    }
    for (std::int64_t left = 0; left < roi.width; left += block_px) {
      const std::int64_t right = std::min(left + block_px, roi.width);
      double sum = 0.0, n = 0.0;
      if (all) {
        for (std::int64_t i = left; i < right; ++i) sum += column[static_cast<std::size_t>(i)];
        n = static_cast<double>((right - left) * (bottom - top));
      }
      for (std::int64_t j = top; j < bottom && !all; ++j) {
        const float* row = image.row(roi.y + j) + roi.x;
        for (std::int64_t i = left; i < right; ++i) {
          const bool taken = row[i] >= bounds.low && row[i] <= bounds.high;
          sum += taken ? static_cast<double>(row[i]) - facts.offset : 0.0;
          n += taken ? 1.0 : 0.0;
        }
      }
      if (n == 0.0) continue;
      Point middle{0.5 * static_cast<double>(left + right), 0.5 * static_cast<double>(top + bottom)};
      if (n < static_cast<double>((right - left) * (bottom - top))) middle = centroid(left, top, right, bottom);
      blocks.add(middle.x - 0.5 * static_cast<double>(roi.width), middle.y - 0.5 * static_cast<double>(roi.height),
                 sum / n / facts.scale);
    }
  }
  return blocks;
}

EdgePixels gather_pixels(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& facts,
                         const ValueLimits& limits, const EdgeCurve& curve, double range_px) {
  const Point n = curve.normal();
  const double left = 0.5 - 0.5 * static_cast<double>(roi.width), top = 0.5 - 0.5 * static_cast<double>(roi.height);
  struct Part {
    std::int64_t first = 0, size = 0;
  };
  std::vector<Part> parts(static_cast<std::size_t>(roi.height));  // of each row
  std::size_t most = 0;
  for (std::size_t j = 0; j < parts.size(); ++j) {
    const double u0 = n.y * (static_cast<double>(j) + top - curve.origin.y) + n.x * (left - curve.origin.x);
    // |u0 + n.x i| < range_px
    double first = 0.0, end = static_cast<double>(roi.width);
    if (std::abs(n.x) * end > 1e-9) {
      const double a = (-range_px - u0) / n.x, b = (range_px - u0) / n.x;
      first = std::clamp(std::ceil(std::min(a, b)), 0.0, end);
      end = std::clamp(std::floor(std::max(a, b)) + 1.0, first, end);
    } else if (std::abs(u0) >= range_px) {
      end = 0.0;
    }
    parts[j] = {static_cast<std::int64_t>(first), static_cast<std::int64_t>(end - first)};
    most += static_cast<std::size_t>(parts[j].size);
  }
  const double scale = 1.0 / facts.scale;
  const ValueBounds bounds = bounds_of(facts, limits);
  EdgePixels pixels(most);
  for (std::size_t j = 0; j < parts.size(); ++j) {
    mtf::require_going_on();
    const auto [first, size] = parts[j];
    const float* row = image.row(roi.y + static_cast<std::int64_t>(j)) + roi.x + first;
    const double from = static_cast<double>(first) + left;
    const double y = static_cast<double>(j) + top;
    if (all_within(row, size, bounds)) {
      const std::size_t count = pixels.size();
      fill_row(row, size, from, facts.offset, scale, pixels.x() + count, pixels.value() + count);
      std::fill_n(pixels.y() + count, size, y);
      pixels.resize(count + static_cast<std::size_t>(size));
      continue;
    }
    for (std::int64_t i = 0; i < size; ++i)
      if (row[i] >= bounds.low && row[i] <= bounds.high)
        pixels.add(static_cast<double>(i) + from, y, (static_cast<double>(row[i]) - facts.offset) * scale);
  }
  return pixels;
}

}  // namespace calib
