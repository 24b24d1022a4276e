// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "calib/edge/median.h"

#include "calib/find/find_parts.h"
#include "mtf/work/stop.h"

namespace calib::find {
namespace {

constexpr std::int64_t kMostCells = std::int64_t{1} << 24;
constexpr double kSparse = 0.6;                 // share of numbers below which pixels are paired
constexpr std::int64_t kMostSamples = 1 << 20;  // for the noise
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// Smoothing along an axis, and what it leaves of white noise in a gradient: central differences along x of binomials
/// along x and y.
constexpr std::array<float, 5> kBinomial{1.0F / 16, 4.0F / 16, 6.0F / 16, 4.0F / 16, 1.0F / 16};
constexpr double kGradientNoise = 0.1498;
/// Standard deviations of a gradient's component that noise does not exceed in millions of cells.
constexpr double kNoiseMargin = 6.0;
double valid_share(mtf::ImageView<const float> image) {
  std::int64_t valid = 0;
  for (std::int64_t y = 0; y < image.height; ++y) {
    mtf::require_going_on();
    for (std::int64_t x = 0; x < image.width; ++x) valid += std::isfinite(image.at(x, y)) ? 1 : 0;
  }
  return static_cast<double>(valid) / static_cast<double>(image.width * image.height);
}

/// The least and the largest value that at least three cells of some 3 x 3 neighbourhood have in common: one wild
/// pixel, or two that touch, are no part of the range. Only a cell beyond the range so far can extend it.
struct Range {
  float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
  double size() const { return static_cast<double>(high) - static_cast<double>(low); }
};
Range shared_range(const Cells& cells) {
  Range range;
  const auto third = [&](std::int64_t x, std::int64_t y, float sign) {
    std::array<float, 9> values;
    std::size_t count = 0;
    for (std::int64_t j = std::max<std::int64_t>(0, y - 1); j <= std::min(cells.height - 1, y + 1); ++j)
      for (std::int64_t i = std::max<std::int64_t>(0, x - 1); i <= std::min(cells.width - 1, x + 1); ++i)
        if (const float value = cells.at(i, j); !std::isnan(value)) values[count++] = sign * value;
    if (count < 3) return sign * std::numeric_limits<float>::lowest();
    std::nth_element(values.begin(), values.begin() + 2, values.begin() + count, std::greater<>());
    return sign * values[2];
  };
  for (std::int64_t y = 0; y < cells.height; ++y) {
    mtf::require_going_on();
    for (std::int64_t x = 0; x < cells.width; ++x) {
      const float value = cells.at(x, y);
      if (value > range.high) range.high = std::max(range.high, third(x, y, 1.0F));
      if (value < range.low) range.low = std::min(range.low, third(x, y, -1.0F));
    }
  }
  return range;
}

/// The median of |second differences along both axes|, which planes and straight edges along an axis do not show.
/// J. Immerkaer, Fast noise variance estimation, CVIU 64, 300 (1996), with a median in place of the mean.
double noise_of(const Cells& cells) {
  const std::int64_t inner = std::max<std::int64_t>(0, cells.width - 2) * std::max<std::int64_t>(0, cells.height - 2);
  const std::int64_t stride = 1 + inner / kMostSamples;
  std::vector<float> sample;
  for (std::int64_t i = 0; i < inner; i += stride) {
    const std::int64_t x = 1 + i % (cells.width - 2), y = 1 + i / (cells.width - 2);
    const auto row = [&](std::int64_t at) {
      return cells.at(x - 1, at) - 2.0F * cells.at(x, at) + cells.at(x + 1, at);
    };
    const float second = row(y - 1) - 2.0F * row(y) + row(y + 1);
    if (std::isfinite(second)) sample.push_back(std::abs(second));
  }
  if (sample.empty()) return 0.0;
  return static_cast<double>(median(sample)) / (0.6745 * 6.0);
}

/// Single cells far above or below all of their neighbours but one, as hot and dead pixels are (two of them may touch),
/// become cells without a value: each would count as structure, and end the region around an edge. No optics makes such
/// a spike that would be larger than the noise; corners, lines and their ends are none.
void leave_out_spikes(Cells& cells) {
  constexpr double kFar = 6.0;     // standard deviations of the noise
  constexpr double kLeast = 0.02;  // of the values' range
  const auto limit = static_cast<float>(std::max(kFar * cells.noise_sd, kLeast));
  std::vector<std::size_t> spikes;
  for (std::int64_t y = 1; y + 1 < cells.height; ++y) {
    mtf::require_going_on();
    for (std::int64_t x = 1; x + 1 < cells.width; ++x) {
      const float v = cells.at(x, y), left = cells.at(x - 1, y), right = cells.at(x + 1, y);
      // Most cells are not far from both of these, with which the others need no comparison.
      if (!(std::abs(v - left) > limit) && !(std::abs(v - right) > limit)) continue;
      int below = 0, above = 0, known = 0;
      for (std::int64_t j = y - 1; j <= y + 1; ++j)
        for (std::int64_t i = x - 1; i <= x + 1; ++i) {
          const float other = cells.at(i, j);
          if (std::isnan(other) || (i == x && j == y)) continue;
          ++known;
          below += v - other > limit ? 1 : 0;
          above += other - v > limit ? 1 : 0;
        }
      if (known >= 5 && std::max(below, above) >= known - 1)
        spikes.push_back(static_cast<std::size_t>(y * cells.width + x));
    }
  }
  for (const std::size_t i : spikes) cells.value[i] = kNone;
}

/// Weighted mean of five neighbours, `step` elements apart, of those that are numbers; `at` is the middle one.
float binomial_mean(const float* middle, std::int64_t at, std::int64_t count, std::int64_t step) {
  float sum = 0.0F, weight = 0.0F;
  for (std::int64_t k = std::max<std::int64_t>(-2, -at); k <= std::min<std::int64_t>(2, count - 1 - at); ++k) {
    const float v = middle[k * step];
    if (std::isnan(v)) continue;
    const float w = kBinomial[static_cast<std::size_t>(k + 2)];
    sum += w * v;
    weight += w;
  }
  return weight > 0.3F ? sum / weight : kNone;
}

std::vector<float> smoothed(const Cells& cells) {
  std::vector<float> rows(cells.value.size()), both(cells.value.size());
  std::size_t i = 0;
  for (std::int64_t y = 0; y < cells.height; ++y) {
    mtf::require_going_on();
    for (std::int64_t x = 0; x < cells.width; ++x, ++i) rows[i] = binomial_mean(&cells.value[i], x, cells.width, 1);
  }
  i = 0;
  for (std::int64_t y = 0; y < cells.height; ++y) {
    mtf::require_going_on();
    for (std::int64_t x = 0; x < cells.width; ++x, ++i) both[i] = binomial_mean(&rows[i], y, cells.height, cells.width);
  }
  return both;
}

}  // namespace

Cells make_cells(mtf::ImageView<const float> image) {
  Cells cells;
  const double share = valid_share(image);
  if (share < kSparse) cells.size_px = 2;
  const auto count = [&](std::int64_t pixels) { return (pixels + cells.size_px - 1) / cells.size_px; };
  while (count(image.width) * count(image.height) > kMostCells) cells.size_px *= 2;
  cells.width = count(image.width);
  cells.height = count(image.height);
  cells.value.resize(static_cast<std::size_t>(cells.width * cells.height));

  std::vector<double> sum(static_cast<std::size_t>(cells.width));
  std::vector<int> numbers(static_cast<std::size_t>(cells.width));
  float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
  std::int64_t known = 0;
  double pixels = 0.0;
  for (std::int64_t row = 0; row < cells.height; ++row) {
    mtf::require_going_on();
    std::fill(sum.begin(), sum.end(), 0.0);
    std::fill(numbers.begin(), numbers.end(), 0);
    const std::int64_t end = std::min(image.height, (row + 1) * cells.size_px);
    for (std::int64_t y = row * cells.size_px; y < end; ++y)
      for (std::int64_t x = 0; x < image.width; ++x) {
        const float v = image.at(x, y);
        if (!std::isfinite(v)) continue;
        sum[static_cast<std::size_t>(x / cells.size_px)] += v;
        ++numbers[static_cast<std::size_t>(x / cells.size_px)];
      }
    for (std::int64_t x = 0; x < cells.width; ++x) {
      const auto i = static_cast<std::size_t>(x);
      float& v = cells.value[static_cast<std::size_t>(row * cells.width + x)];
      v = numbers[i] > 0 ? static_cast<float>(sum[i] / numbers[i]) : kNone;
      if (numbers[i] == 0) continue;
      ++known;
      pixels += numbers[i];
      low = std::min(low, v);
      high = std::max(high, v);
    }
  }
  cells.valid = static_cast<double>(known) / static_cast<double>(cells.value.size());
  if (known > 0) {
    constexpr double kWild = 20.0;
    const Range shared = shared_range(cells);
    if (shared.size() > 0.0 && static_cast<double>(high) - static_cast<double>(low) > kWild * shared.size()) {
      low = shared.low;
      high = shared.high;
      for (float& v : cells.value)
        if (!(v >= low && v <= high)) v = kNone;
    }
    cells.range = static_cast<double>(high) - static_cast<double>(low);
    cells.pixels_a_cell = pixels / static_cast<double>(known);
    const double largest = std::max(std::abs(static_cast<double>(low)), std::abs(static_cast<double>(high)));
    cells.rounding = std::numeric_limits<float>::epsilon() * std::max(1.0, largest / cells.range);
    if (cells.range > 0.0)
      for (float& v : cells.value)
        v = static_cast<float>((static_cast<double>(v) - static_cast<double>(low)) / cells.range);
    cells.noise_sd = noise_of(cells);
    if (cells.size_px == 1) leave_out_spikes(cells);
  }
  return cells;
}

Gradients make_gradients(const Cells& cells) {
  const std::vector<float> value = smoothed(cells);
  Gradients gradients;
  gradients.width = cells.width;
  gradients.height = cells.height;
  gradients.magnitude.assign(value.size(), 0.0F);
  gradients.direction.assign(value.size(), 0);
  gradients.threshold = std::max(kNoiseMargin * kGradientNoise * cells.noise_sd, cells.rounding);
  for (std::int64_t y = 1; y + 1 < cells.height; ++y) {
    mtf::require_going_on();
    for (std::int64_t x = 1; x + 1 < cells.width; ++x) {
      const auto i = static_cast<std::size_t>(y * cells.width + x);
      const auto row = static_cast<std::size_t>(cells.width);
      const float gx = 0.5F * (value[i + 1] - value[i - 1]), gy = 0.5F * (value[i + row] - value[i - row]);
      const float magnitude = std::sqrt(gx * gx + gy * gy);
      if (std::isnan(magnitude)) continue;
      gradients.magnitude[i] = magnitude;
      if (magnitude <= gradients.threshold) continue;
      const float turn = std::atan2(gy, gx) / (2.0F * std::numbers::pi_v<float>);
      gradients.direction[i] = static_cast<std::uint8_t>(std::lround(turn * 256.0F) & 255);
    }
  }
  // Cells on the border take the gradient of their inner neighbours.
  if (cells.width < 3 || cells.height < 3) return gradients;
  for (std::int64_t y = 0; y < cells.height; ++y)
    for (std::int64_t x = 0; x < cells.width; ++x) {
      const auto i = static_cast<std::size_t>(y * cells.width + x);
      const auto inner = static_cast<std::size_t>(std::clamp<std::int64_t>(y, 1, cells.height - 2) * cells.width +
                                                  std::clamp<std::int64_t>(x, 1, cells.width - 2));
      gradients.magnitude[i] = gradients.magnitude[inner];
      gradients.direction[i] = gradients.direction[inner];
    }
  return gradients;
}

}  // namespace calib::find
