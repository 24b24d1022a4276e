// SPDX-License-Identifier: Apache-2.0
#pragma once

// Residuals of a fitted series as a first-order autoregressive series.
//   E r r' = sigma^2 Q R Q,  R_ij = phi^|i - j|,  Q = 1 - J (J'J)^-1 J'
// A fit of p parameters takes away much more than p / n of correlated noise: phi and sigma are those at which the
// expected sums of r_i^2 and of r_i r_(i+1) are the observed ones.

#include <Eigen/Core>
#include <vector>

namespace calib {

struct SeriesNoise {
  double phi = 0.0, variance = 0.0;
  double degrees = 0.0;   ///< sum of r^2 over the variance
  Eigen::MatrixXd joint;  ///< J' R J
};

/// `place`: of each residual in the series, rising; rows of `jacobian` belong to the residuals.
SeriesNoise series_noise(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residual,
                         const std::vector<std::size_t>& place);

}  // namespace calib
