// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/normal_matrix.h"

#include <cmath>

namespace calib {

NormalMatrix::NormalMatrix(std::size_t unknowns) {
  const auto columns = static_cast<Eigen::Index>(unknowns + 1);
  sum_ = Eigen::MatrixXd::Zero(columns, columns);
  panel_ = Panel::Zero(kPanel, columns);
}

std::span<double> NormalMatrix::next() {
  return {panel_.data() + filled_ * panel_.cols(), static_cast<std::size_t>(panel_.cols())};
}

void NormalMatrix::flush() {
  const auto rows = panel_.topRows(filled_);
  sum_.noalias() += rows.transpose() * rows;
  filled_ = 0;
}

const Eigen::MatrixXd& NormalMatrix::matrix() {
  if (filled_ > 0) flush();
  return sum_;
}

Eigen::MatrixXd triangular_factor(const Eigen::MatrixXd& matrix) {
  const Eigen::Index n = matrix.rows();
  Eigen::MatrixXd r = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const double pivot = matrix(j, j) - r.col(j).head(j).squaredNorm();
    if (!(pivot > 1e-14 * matrix(j, j))) continue;
    r(j, j) = std::sqrt(pivot);
    for (Eigen::Index k = j + 1; k < n; ++k)
      r(j, k) = (matrix(j, k) - r.col(j).head(j).dot(r.col(k).head(j))) / r(j, j);
  }
  return r;
}

}  // namespace calib
