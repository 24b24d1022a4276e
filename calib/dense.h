// SPDX-License-Identifier: Apache-2.0
#pragma once

// Dense matrices (Eigen): decompositions and sums of products, compiled once, as each takes the compiler seconds
// wherever it stands.

#include <Eigen/Cholesky>
#include <optional>
#include <span>

namespace calib {

/// A = L D L^T of a symmetric semidefinite matrix, n x n; solves A x = b for b of n rows.
class SymmetricFactor {
 public:
  explicit SymmetricFactor(const Eigen::MatrixXd& a);
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;

 private:
  Eigen::LDLT<Eigen::MatrixXd> factor_;
};

/// A = L L^T of a positive definite matrix and x = A^-1 b.
struct CholeskySolution {
  Eigen::VectorXd half, x;  ///< L^-1 b, A^-1 b
  double log_root = 0.0;    ///< log sqrt(det A)
};
/// Absent where A is not positive definite.
std::optional<CholeskySolution> cholesky_solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

struct Eigenpairs {
  Eigen::VectorXd values;   ///< rising
  Eigen::MatrixXd vectors;  ///< one a column, orthonormal: V^T V = 1, in the generalised problem V^T B V = 1
};
/// A v = lambda v, A symmetric.
Eigenpairs eigenpairs(const Eigen::MatrixXd& a);
/// A v = lambda B v, A symmetric and B positive definite; absent where the iteration does not converge.
std::optional<Eigenpairs> eigenpairs(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The x with the least |A x - b|, of several the shortest; of a matrix b column by column.
Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Orthonormal columns, as many as the rank of A, that span its columns.
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& a);
/// Pivots of a QR decomposition above `threshold` times the largest.
Eigen::Index rank_of(const Eigen::MatrixXd& a, double threshold);

/// A x = b and A^-1 of a square matrix that has an inverse; the first with full pivoting.
Eigen::VectorXd solution_of(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& a);

// Many residuals as few. With the columns of C = [J r], the Jacobian and the residuals of a set of data, the triangular
// factor R of C^T C = R^T R stands for them exactly: as many rows as columns, the same cost, gradient and Gauss-Newton
// matrix. So thousands of pixels cost the minimiser no more than a dozen residuals, and C itself is never stored.

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
