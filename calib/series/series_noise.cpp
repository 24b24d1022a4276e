// SPDX-License-Identifier: Apache-2.0
#include "calib/series/series_noise.h"

#include <algorithm>
#include <cmath>

#include "calib/dense.h"

namespace calib {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double kLargestPhi = 0.999;

/// R m for R_ij = phi^|place_i - place_j|, by the recursion from both ends.
MatrixXd correlated(double phi, const std::vector<std::size_t>& place, const MatrixXd& m) {
  const Index n = m.rows();
  MatrixXd before = m, after = m;
  for (Index i = 1; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    before.row(i) += std::pow(phi, static_cast<double>(place[at] - place[at - 1])) * before.row(i - 1);
  }
  for (Index i = n - 2; i >= 0; --i) {
    const auto at = static_cast<std::size_t>(i);
    after.row(i) += std::pow(phi, static_cast<double>(place[at + 1] - place[at])) * after.row(i + 1);
  }
  return before + after - m;
}

struct Expected {
  double squares, neighbours;
};

/// Traces of Q R Q along its diagonal and beside it. `basis`: orthonormal columns that span J.
Expected expected_sums(double phi, const std::vector<std::size_t>& place, const MatrixXd& basis) {
  const MatrixXd seen = correlated(phi, place, basis), inner = basis.transpose() * seen;
  const auto entry = [&](Index i, Index j, double r) {
    return r - basis.row(i).dot(seen.row(j)) - seen.row(i).dot(basis.row(j)) + (basis.row(i) * inner).dot(basis.row(j));
  };
  Expected sums{0.0, 0.0};
  for (Index i = 0; i < basis.rows(); ++i) {
    sums.squares += entry(i, i, 1.0);
    const auto at = static_cast<std::size_t>(i);
    if (at + 1 < place.size() && place[at + 1] == place[at] + 1) sums.neighbours += entry(i, i + 1, phi);
  }
  return sums;
}

}  // namespace

SeriesNoise series_noise(const MatrixXd& jacobian, const Eigen::VectorXd& residual,
                         const std::vector<std::size_t>& place) {
  const MatrixXd basis = orthonormal_basis(jacobian);
  double squares = 0.0, neighbours = 0.0;
  for (Index i = 0; i < residual.size(); ++i) {
    squares += residual[i] * residual[i];
    const auto at = static_cast<std::size_t>(i);
    if (at + 1 < place.size() && place[at + 1] == place[at] + 1) neighbours += residual[i] * residual[i + 1];
  }
  const double observed = squares > 0.0 ? neighbours / squares : 0.0;
  const auto excess = [&](double phi) {
    const Expected e = expected_sums(phi, place, basis);
    return e.neighbours / e.squares - observed;
  };
  SeriesNoise noise;
  if (excess(kLargestPhi) <= 0.0) {
    noise.phi = kLargestPhi;
  } else if (excess(0.0) < 0.0) {
    double lo = 0.0, hi = kLargestPhi;
    for (int step = 0; step < 40; ++step) {
      const double middle = 0.5 * (lo + hi);
      (excess(middle) < 0.0 ? lo : hi) = middle;
    }
    noise.phi = 0.5 * (lo + hi);
  }
  noise.degrees = std::max(expected_sums(noise.phi, place, basis).squares, 1e-9);
  noise.variance = squares / noise.degrees;
  noise.joint = jacobian.transpose() * correlated(noise.phi, place, jacobian);
  return noise;
}

}  // namespace calib
