// SPDX-License-Identifier: Apache-2.0
#pragma once

// Roots to the last digits of a double, and their derivatives by the implicit function: where g(x, p) = 0,
// dx = -(dg/dp) dp / (dg/dx).

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "mtf/math/special.h"

namespace radiometry {

/// Root of a function with g_lo = g(lo) and g_hi = g(hi) of different signs (one may be 0), by inverse quadratic
/// interpolation where that is safe and halving where not (Chandrupatla, Adv. Eng. Softw. 28, 145 (1997)). The values
/// may be infinite; a NaN ends the search.
template <class G>
double find_root(const G& g, double lo, double hi, double g_lo, double g_hi) {
  if (g_lo == 0.0) return lo;
  if (g_hi == 0.0) return hi;
  double a = lo, b = hi, c = lo, ga = g_lo, gb = g_hi, gc = g_lo, t = 0.5;
  for (int step = 0; step < 200; ++step) {
    const double x = a + t * (b - a), gx = g(x);
    if (std::isnan(gx)) return x;
    if ((gx > 0.0) == (ga > 0.0)) {
      c = a, gc = ga;
    } else {
      c = b, gc = gb;
      b = a, gb = ga;
    }
    a = x, ga = gx;
    const double best = std::abs(ga) < std::abs(gb) ? a : b;
    const double width = std::abs(b - a), least = 2.0 * std::numeric_limits<double>::epsilon() * std::abs(best) +
                                                  std::numeric_limits<double>::min();
    if (ga == 0.0) return a;
    if (gb == 0.0) return b;
    if (width <= least) return best;
    const double xi = (a - b) / (c - b), phi = (ga - gb) / (gc - gb);
    t = 0.5;
    if (std::isfinite(phi) && phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi) {
      const double q = ga / (gb - ga) * gc / (gb - gc) + (c - a) / (b - a) * ga / (gc - ga) * gb / (gc - gb);
      if (std::isfinite(q)) t = q;
    }
    const double edge = 0.5 * least / width;
    t = std::clamp(t, edge, 1.0 - edge);
  }
  return a;
}

/// Slope of a function of a double (its values only) by five points x + (-2 ... 2) h; h about 1e-3 of the distance over
/// which it changes gives ten digits and more where there is no kink.
template <class G>
double slope_at(const G& g, double x, double h) {
  const auto at = [&](double z) { return mtf::value_of(g(z)); };
  return (8.0 * (at(x + h) - at(x - h)) - (at(x + 2.0 * h) - at(x - 2.0 * h))) / (12.0 * h);
}

/// g at `moved`, whose value is x, with the derivatives that it has there: dg/dx comes from differences of h. Of plain
/// numbers nothing but g(x) is worked out.
template <class S, class G>
S continued(const G& g, double x, const S& moved, double h) {
  if constexpr (std::is_floating_point_v<S>)
    return S(g(x));
  else
    return g(x) + S(slope_at(g, x, h)) * (moved - S(x));
}

/// The root x of g with its derivatives: `g_at_root` is g(x) with those by the parameters, `slope` dg/dx. Where the
/// slope is 0 the root has no derivative and none is carried.
template <class S>
S implicit_root(double x, const S& g_at_root, double slope) {
  if (!(std::abs(slope) > 0.0) || !std::isfinite(slope)) return S(x);
  return S(x) - (g_at_root - S(mtf::value_of(g_at_root))) / S(slope);
}

}  // namespace radiometry
