// SPDX-License-Identifier: Apache-2.0
#pragma once

// Many residuals as few. With the columns of C = [J r], the Jacobian and the residuals of a set of data, the triangular
// factor R of C^T C = R^T R stands for them exactly: as many rows as columns, the same cost, gradient and Gauss-Newton
// matrix. So thousands of pixels cost the minimiser no more than a dozen residuals, and C itself is never stored.

#include <Eigen/Core>
#include <span>

namespace calib {

class NormalMatrix {
 public:
  /// `unknowns` columns of J, then r.
  explicit NormalMatrix(std::size_t unknowns);

  /// A row of C: derivatives of the residual, then the residual itself.
  std::span<double> next();
  /// Takes the row that next() gave.
  void add() {
    if (++filled_ == kPanel) flush();
  }

  /// C^T C.
  const Eigen::MatrixXd& matrix();
  std::size_t unknowns() const { return static_cast<std::size_t>(sum_.cols()) - 1; }

 private:
  static constexpr Eigen::Index kPanel = 128;
  using Panel = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  void flush();

  Eigen::MatrixXd sum_;
  Panel panel_;
  Eigen::Index filled_ = 0;
};

/// The upper triangular R with R^T R = `matrix`, which is positive semidefinite: rows without a pivot are zero.
Eigen::MatrixXd triangular_factor(const Eigen::MatrixXd& matrix);

}  // namespace calib
