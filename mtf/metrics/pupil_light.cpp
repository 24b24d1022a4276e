// SPDX-License-Identifier: Apache-2.0
#include "mtf/metrics/pupil_light.h"

namespace mtf {
namespace {

constexpr double kStep = 1.0 / 1024.0;

/// Mean over the directions of sinc(f cos) sinc(f sin), and its slope.
ValueSlope direct(double f) {
  constexpr int n = 64;  // exact to rounding for f up to 8
  ValueSlope mean;
  for (int i = 0; i < n; ++i) {
    const auto [s, c] = sin_cos_pi((i + 0.5) / (2.0 * n));
    const ValueSlope x = sinc(f * c), y = sinc(f * s);
    mean.value += x.value * y.value / n;
    mean.slope += (c * x.slope * y.value + s * x.value * y.slope) / n;
  }
  return mean;
}

std::vector<ValueSlope> make_table() {
  std::vector<ValueSlope> table;
  for (int i = 0; i * kStep <= kBoxMeanEnd + kStep; ++i) table.push_back(direct(i * kStep));
  return table;
}

}  // namespace

ValueSlope square_box_mean(double f_px) {
  static const std::vector<ValueSlope> table = make_table();
  const auto i = static_cast<std::size_t>(f_px / kStep);
  const double t = f_px / kStep - static_cast<double>(i);
  const ValueSlope &a = table[i], &b = table[i + 1];
  // Cubic through values and slopes: h^4 / 384 of the fourth derivative, which is below 40.
  const double d = b.value - a.value, p = kStep * a.slope, q = kStep * b.slope;
  const double c2 = 3.0 * d - 2.0 * p - q, c3 = p + q - 2.0 * d;
  return {a.value + t * (p + t * (c2 + t * c3)), (p + t * (2.0 * c2 + 3.0 * t * c3)) / kStep};
}

}  // namespace mtf
