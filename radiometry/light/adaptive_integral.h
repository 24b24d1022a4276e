// SPDX-License-Identifier: Apache-2.0
#pragma once

// Integral of a smooth function between two limits by Gauss-Legendre panels that are halved where they have to be, with
// its error. A panel is accepted when its 12 nodes and those of its two halves agree; the halves are kept, so the error
// stated is that of the coarser result, far above that of the finer one for a function without kinks.

#include <cmath>
#include <vector>

#include "mtf/math/quadrature.h"
#include "mtf/math/special.h"

namespace radiometry {

template <class S>
struct Integral {
  S value{};
  double error = 0.0;  ///< absolute, of the value; the derivatives of a Jet are taken to be as smooth as it
};

inline constexpr double kIntegralTolerance = 1e-11;  ///< of the integral of |f|
inline constexpr int kMostPanels = 2000;             ///< with so many the value is taken as it is, with its error

/// Integral of f(double) -> S over [lo, hi], lo <= hi; `panels` equal ones to begin with.
template <class S, class F>
Integral<S> integrate(const F& f, double lo, double hi, int panels = 1, double tolerance = kIntegralTolerance) {
  struct Panel {
    double lo, hi;
    S whole;
    double size;  ///< integral of |f|
  };
  const mtf::GaussRule& rule = mtf::gauss_legendre(12);
  const auto panel = [&](double a, double b) {
    const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
    Panel p{a, b, S(0), 0.0};
    for (std::size_t i = 0; i < rule.node.size(); ++i) {
      const S value = f(middle + half * rule.node[i]);
      p.whole += S(half * rule.weight[i]) * value;
      p.size += half * rule.weight[i] * std::abs(mtf::value_of(value));
    }
    return p;
  };
  Integral<S> result;
  if (!(hi > lo)) return result;
  std::vector<Panel> open;
  double size = 0.0;
  const double step = (hi - lo) / panels;
  for (int i = panels; i-- > 0;) {
    open.push_back(panel(lo + i * step, i + 1 == panels ? hi : lo + (i + 1) * step));
    size += open.back().size;
  }
  int used = panels;
  while (!open.empty()) {
    const Panel p = open.back();
    open.pop_back();
    const double middle = 0.5 * (p.lo + p.hi);
    const Panel left = panel(p.lo, middle), right = panel(middle, p.hi);
    const S halves = left.whole + right.whole;
    const double error = std::abs(mtf::value_of(p.whole) - mtf::value_of(halves));
    used += 2;
    // Written so that NaN ends it, as does a panel that cannot be halved.
    if (!(error > tolerance * size) || used > kMostPanels || !(middle > p.lo && middle < p.hi)) {
      result.value += halves;
      result.error += error;
    } else {
      size += left.size + right.size - p.size;  // what the coarse panels missed
      open.push_back(right);
      open.push_back(left);
    }
  }
  return result;
}

}  // namespace radiometry
