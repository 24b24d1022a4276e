// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/time_scales.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "mtf/math/clones.h"

namespace calib {
namespace {

/// Joins two stretches: adds the square of their difference, and makes `later` the sum of both.
MTFKIT_CLONES void join_stretches(const float* __restrict earlier, float* __restrict later, float* __restrict squares,
                                  float scale, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const float difference = earlier[i] - later[i];
    squares[i] += scale * difference * difference;
    later[i] += earlier[i];
  }
}

}  // namespace

void TimeScales::reserve(std::int64_t frames) {
  const auto scales = static_cast<std::size_t>(std::bit_width(static_cast<std::uint64_t>(frames)));
  for (std::vector<std::vector<float>>* const planes : {&sums_, &squares_})
    while (planes->size() < scales) planes->emplace_back(static_cast<std::size_t>(pixels_), 0.0F);
}

void TimeScales::add(std::int64_t first, std::span<const double> values, std::int64_t t) {
  std::vector<float> stretch(values.size());
  std::transform(values.begin(), values.end(), stretch.begin(), [](double value) { return static_cast<float>(value); });
  std::size_t j = 0;
  for (; (t >> j) % 2 == 1; ++j)
    join_stretches(sums_[j].data() + first, stretch.data(), squares_[j].data() + first,
                   std::ldexp(1.0F, -static_cast<int>(j) - 1), stretch.size());
  std::copy(stretch.begin(), stretch.end(), sums_[j].begin() + first);
}

std::vector<std::vector<float>> TimeScales::squares(std::int64_t frames) const {
  std::vector<std::vector<float>> whole;
  for (std::size_t j = 0; j < squares_.size() && frames >> (j + 1) > 0; ++j) whole.push_back(squares_[j]);
  return whole;
}

double NoiseScales::variance(std::size_t pixel) const {
  double sum = 0.0, count = 0.0;
  for (std::size_t j = 0; j < pixels.size(); ++j) {
    sum += static_cast<double>(pixels[j][pixel]);
    count += differences(j);
  }
  return sum / count;
}

}  // namespace calib
