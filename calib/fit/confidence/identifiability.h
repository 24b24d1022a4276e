// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the data determine, from the Fisher information of the variables after each block's own unknowns are projected
// out. In the variables relative to their references (z = x / reference) the eigenvectors of the information are
// directions of independent error, 1 / sqrt(eigenvalue) long at one standard deviation.
//   A direction is not determined when one standard deviation along it changes some variable by more than half of its
//   reference. All variables that it changes by more than a tenth are part of it, and have no value of their own.
// The reference of a variable that is a size is its value, that of one with a sign the same, or what changes the OTF by
// kUnitEffect if that is more; the allowed range if that is less.

#include <Eigen/Core>
#include <span>
#include <vector>

namespace calib {

inline constexpr double kUndetermined = 0.5;
inline constexpr double kPartOfDirection = 0.1;

struct WeakDirection {
  std::vector<std::size_t> members;  ///< strongest first
  std::vector<double> weight;        ///< component of each, in units of its reference
};

struct Identified {
  Eigen::MatrixXd covariance;  ///< covariance of x; along weak directions it is as large as the data leave it
  std::vector<WeakDirection> weak{};
  std::vector<bool> determined;
};

/// The information of the shared variables in one block's C^T C (dense.h): S = A_pp - A_po A_oo^-1 A_op.
Eigen::MatrixXd project_out(const Eigen::MatrixXd& normal, std::size_t own, std::size_t shared);

/// The covariance of the scores of the shared variables, its own unknowns projected out likewise, from that of all of
/// the block's: T `scores` T^T with T = [-A_po A_oo^-1, 1].
Eigen::MatrixXd project_scores(const Eigen::MatrixXd& normal, const Eigen::MatrixXd& scores, std::size_t own,
                               std::size_t shared);

/// The inverse of the sandwich I^-1 `scores` I^-1, which is the information that is left where the scores vary by more
/// than those of independent pixels, whose covariance is I. It is no more than I in any direction: an estimated
/// correlation can be trusted to say that noise is more than that of independent pixels, but not that there is none.
Eigen::MatrixXd sandwich_information(const Eigen::MatrixXd& information, const Eigen::MatrixXd& scores);

Identified identify(const Eigen::MatrixXd& information, std::span<const double> reference);

}  // namespace calib
