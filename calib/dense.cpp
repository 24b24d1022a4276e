// SPDX-License-Identifier: Apache-2.0
#include "calib/dense.h"

#include <Eigen/Dense>
#include <cmath>

namespace calib {

using Eigen::MatrixXd;
using Eigen::VectorXd;

SymmetricFactor::SymmetricFactor(const MatrixXd& a) : factor_(a) {}
VectorXd SymmetricFactor::solve(const VectorXd& b) const { return factor_.solve(b); }
MatrixXd SymmetricFactor::solve(const MatrixXd& b) const { return factor_.solve(b); }

std::optional<CholeskySolution> cholesky_solution(const MatrixXd& a, const VectorXd& b) {
  const Eigen::LLT<MatrixXd> factor(a);
  if (factor.info() != Eigen::Success) return std::nullopt;
  CholeskySolution solution;
  solution.half = factor.matrixL().solve(b);
  solution.x = factor.matrixU().solve(solution.half);
  solution.log_root = factor.matrixLLT().diagonal().array().log().sum();
  return solution;
}

Eigenpairs eigenpairs(const MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(a);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

std::optional<Eigenpairs> eigenpairs(const MatrixXd& a, const MatrixXd& b) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> eigen(a, b);
  if (eigen.info() != Eigen::Success) return std::nullopt;
  return Eigenpairs{eigen.eigenvalues(), eigen.eigenvectors()};
}

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

VectorXd solution_of(const MatrixXd& a, const VectorXd& b) { return a.fullPivLu().solve(b); }
MatrixXd inverse_of(const MatrixXd& a) { return a.inverse(); }

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
