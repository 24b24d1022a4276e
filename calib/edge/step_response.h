// SPDX-License-Identifier: Apache-2.0
#pragma once

// The edge spread function of an OTF. Along the normal of an edge an OTF H(f) of unit value at 0, f in cycles per
// pixel, spreads the unit step into
//   E(d) = 1/2 + (1/pi) integral over f > 0 of [Re H(f) sin(2 pi f d) + Im H(f) cos(2 pi f d)] / f df,
// (the transform of a step with H(-f) = conj H(f)), d in pixels, and the derivative of H by a parameter into that of E,
// without the 1/2. The integral is taken by Gauss-Legendre rules between the kinks of H, with as many nodes as the
// fastest oscillation needs (mtf/math/quadrature.h), once for each point of a table; between the points E is
// interpolated by cubics through value and slope. H above the highest frequency has to be negligible.

#include <cstddef>
#include <span>
#include <vector>

#include "mtf/frame.h"

namespace calib {

/// Frequencies at which the OTF is asked for, rising, all above 0, and their weights for integrals over [0, top].
struct SliceNodes {
  std::vector<double> f_cy_px{};
  std::vector<double> weight{};
  double range_px = 0.0;  ///< largest |d| of the table
};

/// Nodes for distances up to `range_px` and frequencies up to `top_cy_px`; `breaks_cy_px` are frequencies between which
/// H is smooth (kinks, cutoffs), in any order. Throws UsageError where more than 65536 nodes would be needed.
SliceNodes slice_nodes(double top_cy_px, double range_px, std::span<const double> breaks_cy_px = {});

/// E and its derivatives as one table of `count()` functions: function 0 is E (H itself), the others derivatives.
class StepResponse {
 public:
  /// h[k][i]: H (k = 0) and its derivatives (k > 0) at node i.
  StepResponse(const SliceNodes& nodes, std::span<const std::vector<mtf::Complex<double>>> h);

  std::size_t count() const { return count_; }
  double range_px() const { return range_px_; }
  /// values[k] = function k at distance d, k < count(); returns the slope of function 0 there, the line spread in 1/px.
  /// Beyond range_px() the functions keep their values at its end.
  double at(double d_px, std::span<double> values) const;

 private:
  struct Zone {
    double start = 0.0, step = 0.0, steps_per_px = 0.0;
    std::size_t first = 0, intervals = 0;
  };
  /// Numbers a knot: value and slope x step of the odd part, then of the even part unless all H are real.
  std::size_t knot_width() const { return count_ * (symmetric_ ? 2 : 4); }

  std::size_t count_ = 0;
  double range_px_ = 0.0;
  std::vector<Zone> zones_;
  std::vector<double> knots_;
  bool symmetric_ = true;
};

}  // namespace calib
