// SPDX-License-Identifier: Apache-2.0
#pragma once

// Weights over the image as values at Chebyshev points of -1 .. 1 and as Chebyshev series.

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "mtf/math/special.h"
#include "mtf/otf/otf_series.h"

namespace mtf {

/// Weights of the mean over -1 .. 1 of values at Chebyshev points (Clenshaw and Curtis).
inline std::vector<double> mean_weights(std::size_t n) {
  const std::size_t last = n - 1;
  std::vector<double> weight(n);
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 1.0;
    for (std::size_t k = 1; k <= last / 2; ++k) {
      const double b = 2 * k == last ? 1.0 : 2.0, order = static_cast<double>(k);
      sum -= b / (4.0 * order * order - 1.0) *
             std::cos(2.0 * kPi * order * static_cast<double>(i) / static_cast<double>(last));
    }
    weight[i] = (i == 0 || i == last ? 0.5 : 1.0) * sum / static_cast<double>(last);
  }
  return weight;
}

/// Turns values at those points into Chebyshev coefficients: [coefficient][point].
inline Eigen::MatrixXd to_series(std::size_t n) {
  const std::vector<double> falling = chebyshev_transform(static_cast<int>(n) - 1);  // [point][coefficient]
  const auto size = static_cast<Eigen::Index>(n);
  return Eigen::Map<const Eigen::MatrixXd>(falling.data(), size, size).rowwise().reverse();
}

/// T_0 .. T_(n-1) at t.
inline std::vector<double> chebyshev(std::size_t n, double t) {
  std::vector<double> value(n, 1.0);
  if (n > 1) value[1] = t;
  for (std::size_t m = 2; m < n; ++m) value[m] = 2.0 * t * value[m - 1] - value[m - 2];
  return value;
}

}  // namespace mtf
