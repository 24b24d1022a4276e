// SPDX-License-Identifier: Apache-2.0
#include "mtf/math/quadrature.h"

#include <array>
#include <cassert>
#include <cmath>
#include <mutex>
#include <numbers>

namespace mtf {
namespace {

// Newton's iteration on the Legendre polynomial from Chebyshev's guess converges in a few steps for any n.
GaussRule make_rule(int n) {
  GaussRule rule;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), derivative = 1.0;
    for (int step = 0; step < 8; ++step) {
      double p = 1.0, previous = 0.0;
      for (int k = 1; k <= n; ++k) {
        const double next = ((2.0 * k - 1.0) * x * p - (k - 1.0) * previous) / k;
        previous = p;
        p = next;
      }
      derivative = n * (x * p - previous) / (x * x - 1.0);
      const double change = p / derivative;
      x -= change;
      if (std::abs(change) < 1e-16) break;
    }
    rule.node.push_back(x);
    rule.weight.push_back(2.0 / ((1.0 - x * x) * derivative * derivative));
  }
  return rule;
}

}  // namespace

const GaussRule& gauss_legendre(int n) {
  assert(n >= 1 && n <= kMostGaussNodes);
  static std::array<GaussRule, kMostGaussNodes + 1> rules;
  static std::array<std::once_flag, kMostGaussNodes + 1> made;
  const auto i = static_cast<std::size_t>(n);
  std::call_once(made[i], [&] { rules[i] = make_rule(n); });
  return rules[i];
}

GaussRule mean_rule(double lo, double hi, int n) {
  const GaussRule& rule = gauss_legendre(n);
  const double middle = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
  GaussRule mean;
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    mean.node.push_back(middle - half * rule.node[i]);
    mean.weight.push_back(0.5 * rule.weight[i]);
  }
  return mean;
}

}  // namespace mtf
