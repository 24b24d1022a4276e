// SPDX-License-Identifier: Apache-2.0
#pragma once

// Polynomials through values at Chebyshev points, in barycentric form (J.-P. Berrut and L. N. Trefethen, SIAM Review
// 46, 501 (2004)).

#include <cstddef>
#include <vector>

namespace mtf {

/// Points in -1 .. 1, rising.
struct Barycentric {
  std::vector<double> x, weight;  ///< the weights are barycentric

  /// Zeros of the polynomial of degree n, which lie inside.
  static Barycentric inside(std::size_t n);
  /// Extremes of the polynomial of degree n - 1, both ends among them; n is at least 2.
  static Barycentric with_ends(std::size_t n);
  /// Weights of the values at the points in the polynomial at t.
  void weights_at(double t, double* weights) const;
};

}  // namespace mtf
