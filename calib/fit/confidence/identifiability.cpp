// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/confidence/identifiability.h"

#include <algorithm>
#include <cmath>

#include "calib/dense.h"

namespace calib {
namespace {

/// Smaller components of an eigenvector count as zero.
constexpr double kRounding = 1e-6;

}  // namespace

// The last rows of the triangular factor belong to what the columns before them cannot explain.
Eigen::MatrixXd project_out(const Eigen::MatrixXd& normal, std::size_t own, std::size_t shared) {
  const auto o = static_cast<Eigen::Index>(own), n = static_cast<Eigen::Index>(shared);
  const Eigen::MatrixXd factor = triangular_factor(normal.topLeftCorner(o + n, o + n));
  const auto corner = factor.block(o, o, n, n);
  return corner.transpose() * corner;
}

Eigen::MatrixXd project_scores(const Eigen::MatrixXd& normal, const Eigen::MatrixXd& scores, std::size_t own,
                               std::size_t shared) {
  const auto o = static_cast<Eigen::Index>(own), n = static_cast<Eigen::Index>(shared);
  const Eigen::VectorXd scale = normal.diagonal().head(o).cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd unit = scale.asDiagonal() * normal.topLeftCorner(o, o) * scale.asDiagonal();
  Eigen::MatrixXd keep(n, o + n);
  keep << -(scale.asDiagonal() * least_squares(unit, Eigen::MatrixXd(scale.asDiagonal() * normal.block(0, o, o, n))))
               .transpose(),
      Eigen::MatrixXd::Identity(n, n);
  return keep * scores * keep.transpose();
}

Eigen::MatrixXd sandwich_information(const Eigen::MatrixXd& information, const Eigen::MatrixXd& scores) {
  constexpr double kRidge = 1e-11;
  const Eigen::VectorXd scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const Eigen::VectorXd inverse = scale.cwiseInverse();
  const Eigen::MatrixXd unit = inverse.asDiagonal() * information * inverse.asDiagonal();
  Eigen::MatrixXd regular = unit;
  regular.diagonal().array() += kRidge;
  const auto pairs = eigenpairs(inverse.asDiagonal() * scores * inverse.asDiagonal(), regular);
  if (!pairs) return information;
  const Eigen::MatrixXd parts = scale.asDiagonal() * unit * pairs->vectors;
  return parts * pairs->values.cwiseMax(1.0).cwiseInverse().asDiagonal() * parts.transpose();
}

Identified identify(const Eigen::MatrixXd& information, std::span<const double> reference) {
  const Eigen::Index n = information.rows();
  const Eigen::Map<const Eigen::VectorXd> scale(reference.data(), n);
  const Eigenpairs eigen = eigenpairs(scale.asDiagonal() * information * scale.asDiagonal());
  // What is below rounding of the largest is no information.
  const double least = std::max(1e-14 * eigen.values.maxCoeff(), 1e-24);
  const Eigen::VectorXd step = eigen.values.cwiseMax(least).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd moves = eigen.vectors * step.asDiagonal();

  Identified result{.covariance = scale.asDiagonal() * (moves * moves.transpose()) * scale.asDiagonal(),
                    .determined = std::vector<bool>(static_cast<std::size_t>(n), true)};
  for (Eigen::Index d = 0; d < n; ++d) {
    if (moves.col(d).cwiseAbs().maxCoeff() <= kUndetermined) continue;
    WeakDirection weak;
    for (Eigen::Index i = 0; i < n; ++i)
      // A vast step moves everything a little; only what the direction is made of belongs to it, and what it alone
      // leaves open.
      if (const double share = std::abs(eigen.vectors(i, d)), move = std::abs(moves(i, d));
          (move > kPartOfDirection && share > 0.02) || (move > kUndetermined && share > kRounding))
        weak.members.push_back(static_cast<std::size_t>(i));
    const auto strength = [&](std::size_t i) { return eigen.vectors(static_cast<Eigen::Index>(i), d); };
    std::sort(weak.members.begin(), weak.members.end(),
              [&](std::size_t a, std::size_t b) { return std::abs(strength(a)) > std::abs(strength(b)); });
    for (const std::size_t i : weak.members) {
      weak.weight.push_back(strength(i));
      result.determined[i] = false;
    }
    result.weak.push_back(std::move(weak));
  }
  return result;
}

}  // namespace calib
