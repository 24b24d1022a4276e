// SPDX-License-Identifier: Apache-2.0
#pragma once

// Mean phase of n equally spaced points about their middle, x = frequency x spacing:
//   (1/n) sum over k = 0 ... n-1 of cos(2 pi x (k - (n-1)/2)) = sin(n pi x)/(n sin(pi x))
// = (-1)^((n-1) k) sinc(n r)/sinc(r), r = x - k the distance to the nearest whole number k: exact at the zeros of the
// denominator, since sinc(r) >= 2/pi.

#include "mtf/special.h"

namespace mtf {

/// 0 at infinity; 1 for one point.
inline ValueSlope dirichlet(double x, int n) {
  if (n == 1) return {1.0, 0.0};
  if (!std::isfinite(x)) return {0.0, 0.0};
  const double wide = std::remainder(x, 2.0), r = std::remainder(wide, 1.0), points = n;
  const double sign = n % 2 == 0 && std::abs(wide) > 0.5 ? -1.0 : 1.0;
  const ValueSlope top = sinc(points * r), bottom = sinc(r);
  return {sign * top.value / bottom.value,
          sign * (points * top.slope - top.value * bottom.slope / bottom.value) / bottom.value};
}

/// Bound of |1 - dirichlet| up to x: falls monotonically to its first zero, at x = 1/n.
inline double dirichlet_deviation(double x, int n) {
  if (n == 1) return 0.0;
  return x * n < 1.0 ? 1.0 - dirichlet(x, n).value : 2.0;
}

}  // namespace mtf
