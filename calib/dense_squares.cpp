// SPDX-License-Identifier: Apache-2.0
#include <Eigen/QR>

#include "calib/dense.h"

namespace calib {

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd least_squares(const MatrixXd& a, const VectorXd& b) { return a.completeOrthogonalDecomposition().solve(b); }
MatrixXd least_squares(const MatrixXd& a, const MatrixXd& b) { return a.completeOrthogonalDecomposition().solve(b); }

MatrixXd orthonormal_basis(const MatrixXd& a) {
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(a);
  return qr.householderQ() * MatrixXd::Identity(a.rows(), qr.rank());
}

Eigen::Index rank_of(const MatrixXd& a, double threshold) {
  Eigen::ColPivHouseholderQR<MatrixXd> qr(a);
  qr.setThreshold(threshold);
  return qr.rank();
}

}  // namespace calib
