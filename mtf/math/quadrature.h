// SPDX-License-Identifier: Apache-2.0
#pragma once

// Gauss-Legendre quadrature: sum weight[i] f(node[i]) = integral of f over [-1, 1], exact for polynomials of degree
// 2n - 1. For exp(i K x) the error is below 1e-15 from n = K/2 + 2 K^(1/3) + 14 on.

#include <vector>

namespace mtf {

struct GaussRule {
  std::vector<double> node;
  std::vector<double> weight;
};

inline constexpr int kMostGaussNodes = 2048;

/// The rule of n nodes in falling order, 1 <= n <= kMostGaussNodes (assert). Made once, then shared; safe to call from
/// many threads.
const GaussRule& gauss_legendre(int n);

/// The mean over [lo, hi]: nodes in rising order, weights that sum to 1.
GaussRule mean_rule(double lo, double hi, int n);

}  // namespace mtf
