// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/spectra.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "mtf/engines/fft/fftw.h"
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

std::vector<double> line_spectrum(mtf::ImageView<const float> plane, LineAxis axis) {
  const bool rows = axis == LineAxis::rows;
  const std::int64_t n = rows ? plane.width : plane.height, lines = rows ? plane.height : plane.width;
  const mtf::fft::RealForward transform(n, mtf::Rigor::estimate);
  const mtf::AlignedBuffer<float> line(static_cast<std::size_t>(n)), out(static_cast<std::size_t>(n + 2));
  std::vector<double> power(static_cast<std::size_t>(n / 2), 0.0);
  for (std::int64_t l = 0; l < lines; ++l) {
    for (std::int64_t i = 0; i < n; ++i) line[static_cast<std::size_t>(i)] = rows ? plane.row(l)[i] : plane.row(i)[l];
    transform.execute(line.data(), out.data());
    for (std::size_t k = 1; k <= power.size(); ++k) {
      const auto re = static_cast<double>(out[2 * k]), im = static_cast<double>(out[2 * k + 1]);
      power[k - 1] += (re * re + im * im) / static_cast<double>(n * lines);
    }
  }
  return power;
}

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
