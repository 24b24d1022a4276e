// SPDX-License-Identifier: Apache-2.0
#include "mtf/math/barycentric.h"

#include <algorithm>
#include <cmath>

#include "mtf/math/special.h"

namespace mtf {

Barycentric Barycentric::inside(std::size_t n) {
  Barycentric points;
  for (std::size_t k = 0; k < n; ++k) {
    const double angle = kPi * (2.0 * static_cast<double>(k) + 1.0) / (2.0 * static_cast<double>(n));
    points.x.push_back(-std::cos(angle));
    points.weight.push_back(k % 2 == 0 ? std::sin(angle) : -std::sin(angle));
  }
  return points;
}

Barycentric Barycentric::with_ends(std::size_t n) {
  Barycentric points;
  for (std::size_t k = 0; k < n; ++k) {
    points.x.push_back(-std::cos(kPi * static_cast<double>(k) / static_cast<double>(n - 1)));
    points.weight.push_back((k % 2 == 0 ? 1.0 : -1.0) * (k == 0 || k == n - 1 ? 0.5 : 1.0));
  }
  return points;
}

void Barycentric::weights_at(double t, double* weights) const {
  constexpr double kOnPoint = 1e-15;
  double sum = 0.0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double away = t - x[k];
    if (std::abs(away) < kOnPoint) {
      std::fill_n(weights, x.size(), 0.0);
      weights[k] = 1.0;
      return;
    }
    weights[k] = weight[k] / away;
    sum += weights[k];
  }
  for (std::size_t k = 0; k < x.size(); ++k) weights[k] /= sum;
}

}  // namespace mtf
