// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bessel functions as (value, slope). POSIX j0 and j1 of the C library keep 4 ulp of max(|J|, sqrt(2/(pi x))) up to
// 1e15 (tested against the reference table); std::cyl_bessel_j loses all digits from about 1e4 on.

#include <cmath>

#include "mtf/math/special.h"

namespace mtf {

/// J0(x); 0 at infinity.
inline ValueSlope bessel_j0(double x) {
  if (!std::isfinite(x)) return {0.0, 0.0};
  return {::j0(x), -::j1(x)};
}

/// 2 J1(x)/x, 1 at x = 0; 0 at infinity. Slope -2 J2(x)/x.
inline ValueSlope jinc(double x) {
  if (!std::isfinite(x)) return {0.0, 0.0};
  if (std::abs(x) < 0.1) {  // series: J2 by recurrence cancels here
    const double q = 0.25 * x * x;
    return {1.0 - q / 2.0 * (1.0 - q / 6.0 * (1.0 - q / 12.0 * (1.0 - q / 20.0))),
            -0.25 * x * (1.0 - q / 3.0 * (1.0 - q / 8.0 * (1.0 - q / 15.0 * (1.0 - q / 24.0))))};
  }
  const double value = 2.0 * ::j1(x) / x;
  return {value, 2.0 * (::j0(x) - value) / x};
}

}  // namespace mtf
