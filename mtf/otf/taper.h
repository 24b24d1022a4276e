// SPDX-License-Identifier: Apache-2.0
#pragma once

// A smooth end for an OTF beyond the frequencies that a scene holds, so that its kernel is short. The OTF of an optic
// that passes the scene's Nyquist frequency f_N stops there with a step (where it has phase) or a kink, and its kernel
// falls as 1/x or 1/x^2. On a scene that has been interpolated to a finer grid nothing lies between f_N and the finer
// Nyquist frequency, so the OTF may do there as it likes: along each axis it is multiplied by
//   T(f) = 1 up to f_N,  the integral of a Kaiser window I0(b sqrt(1 - u^2)) from f to the end, 0 beyond,
// whose transform falls to about exp(-b) within b / (pi x width) samples (Kaiser & Schafer, IEEE Trans. ASSP 28, 105
// (1980)).

#include <array>
#include <cmath>
#include <limits>

#include "mtf/math/quadrature.h"

namespace mtf {

struct Taper {
  bool operator==(const Taper&) const = default;
  std::array<double, 2> from_cy_mm{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::array<double, 2> to_cy_mm{};  ///< x, y
  double sharpness = 0.0;            ///< b

  /// T at f along axis 0 (x) or 1 (y).
  double factor(std::size_t axis, double f_cy_mm) const {
    const double from = from_cy_mm[axis], to = to_cy_mm[axis], f = std::abs(f_cy_mm);
    if (f <= from) return 1.0;
    if (f >= to) return 0.0;
    const auto window = [this](double lo, double hi) {
      const GaussRule rule = mean_rule(lo, hi, 24);
      double sum = 0.0;
      for (std::size_t i = 0; i < rule.node.size(); ++i)
        sum += rule.weight[i] * std::cyl_bessel_i(0.0, sharpness * std::sqrt(1.0 - rule.node[i] * rule.node[i]));
      return (hi - lo) * sum;
    };
    const double u = 2.0 * (f - from) / (to - from) - 1.0;
    return u > 0.0 ? 0.5 * window(u, 1.0) / window(0.0, 1.0) : 1.0 - 0.5 * window(-u, 1.0) / window(0.0, 1.0);
  }
};

}  // namespace mtf
