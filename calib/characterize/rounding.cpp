// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/rounding.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mtf/words.h"

namespace calib {

using std::numbers::pi;

std::string hidden_words() {
  return "noise below " + mtf::significant(kHidden_counts, 2) + " counts, and pixels within half a count of each other";
}

RoundedVariance rounded_variance(double s2) {
  constexpr double kFew = 0.08;  // both sums have six terms or fewer on their side
  if (s2 <= 0.0) return {0.0, 1e9};
  if (s2 > kFew) {
    RoundedVariance q{s2 + 1.0 / 12.0, 1.0};
    for (int k = 1; k <= 6; ++k) {
      const double e = std::exp(-4.0 * pi * pi * k * k * s2);
      q.value -= e / (2.0 * pi * pi * k * k);
      q.slope += 2.0 * e;
    }
    return q;
  }
  const double s = std::sqrt(s2);
  RoundedVariance q{s / std::sqrt(pi), 0.5 / (s * std::sqrt(pi))};
  for (int n = 1; n <= 5; ++n) {
    const double e = std::exp(-0.25 * n * n / s2);
    q.value += 2.0 * s / std::sqrt(pi) * e - n * std::erfc(0.5 * n / s);
    q.slope += e / (s * std::sqrt(pi));
  }
  return q;
}

double rounding_pattern(double s2) {
  double sum = 0.0;
  if (s2 <= 0.02) return std::max(0.0, s2) + 1.0 / 12.0 - rounded_variance(s2).value;
  for (int k = 1; k <= 8; ++k) sum += std::exp(-4.0 * pi * pi * k * k * s2) / (2.0 * pi * pi * k * k);
  return sum;
}

double unrounded_variance(double v) {
  if (!(v > 0.0)) return 0.0;
  // Q is concave and rises, so that Newton's steps from below stay below; s/sqrt(pi) <= Q <= s^2 + 1/12 bound the
  // start.
  double s2 = std::max(v - 1.0 / 12.0, v < 1.0 ? 0.25 * pi * v * v : 0.0);
  for (int i = 0; i < 60; ++i) {
    const RoundedVariance q = rounded_variance(s2);
    const double change = (v - q.value) / q.slope;
    s2 += change;
    if (std::abs(change) <= 1e-15 * s2) break;
  }
  return s2;
}

}  // namespace calib
