// SPDX-License-Identifier: Apache-2.0
#include "apps/study/optimum/optimality.h"

#include <algorithm>
#include <cmath>

#include "calib/dense.h"

namespace study {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// x >= 0 with the least |A x - b|.
VectorXd non_negative(const MatrixXd& a, const VectorXd& b) {
  const Index m = a.cols();
  VectorXd x = VectorXd::Zero(m);
  std::vector<bool> free(static_cast<std::size_t>(m), false);
  const auto solve = [&] {
    std::vector<Index> columns;
    for (Index k = 0; k < m; ++k)
      if (free[static_cast<std::size_t>(k)]) columns.push_back(k);
    MatrixXd part(a.rows(), static_cast<Index>(columns.size()));
    for (std::size_t k = 0; k < columns.size(); ++k) part.col(static_cast<Index>(k)) = a.col(columns[k]);
    const VectorXd s = calib::least_squares(part, b);
    VectorXd whole = VectorXd::Zero(m);
    for (std::size_t k = 0; k < columns.size(); ++k) whole[columns[k]] = s[static_cast<Index>(k)];
    return whole;
  };
  const double small = 1e-13 * (1.0 + b.norm()) * (1.0 + a.norm());
  for (Index round = 0; round < 3 * m + 3; ++round) {
    const VectorXd pull = a.transpose() * (b - a * x);
    Index enter = -1;
    for (Index k = 0; k < m; ++k)
      if (!free[static_cast<std::size_t>(k)] && pull[k] > small && (enter < 0 || pull[k] > pull[enter])) enter = k;
    if (enter < 0) break;
    free[static_cast<std::size_t>(enter)] = true;
    for (Index inner = 0; inner <= m; ++inner) {
      const VectorXd s = solve();
      const auto falls = [&](Index k) { return free[static_cast<std::size_t>(k)] && s[k] <= 0.0; };
      double step = 1.0;
      for (Index k = 0; k < m; ++k)
        if (falls(k)) step = std::min(step, x[k] > 0.0 ? x[k] / (x[k] - s[k]) : 0.0);
      bool dropped = false;
      x += step * (s - x);
      for (Index k = 0; k < m; ++k)
        if (falls(k) && x[k] <= 1e-14 * (1.0 + x.norm())) {
          free[static_cast<std::size_t>(k)] = false;
          x[k] = 0.0;
          dropped = true;
        }
      if (!dropped) break;
    }
    x = x.cwiseMax(0.0);
  }
  return x;
}

void add_ends(std::span<const double> z, std::vector<ReachedLimit>& limits) {
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (z[i] <= kReached) limits.push_back({ReachedLimit::Kind::lower, i});
    if (z[i] >= 1.0 - kReached) limits.push_back({ReachedLimit::Kind::upper, i});
  }
}

/// Multipliers of the limits for the slope `b`.
void hold(Optimality& result, const VectorXd& b, const DesignSlopes& slopes, const ProblemScale& scale) {
  const Index n = b.size();
  if (n == 0) return;
  MatrixXd a = MatrixXd::Zero(n, static_cast<Index>(result.limits.size()));
  for (std::size_t k = 0; k < result.limits.size(); ++k) {
    const ReachedLimit& limit = result.limits[k];
    const auto column = static_cast<Index>(k), index = static_cast<Index>(limit.index);
    if (limit.kind == ReachedLimit::Kind::constraint)
      for (Index i = 0; i < n; ++i)
        a(i, column) = slopes.margin[static_cast<std::size_t>(index * n + i)] / scale.margin[limit.index];
    else
      a(index, column) = limit.kind == ReachedLimit::Kind::lower ? 1.0 : -1.0;
  }
  const VectorXd multipliers = non_negative(a, b);
  VectorXd left = b;
  if (a.cols() > 0) {
    left -= a * multipliers;
    result.shared = calib::rank_of(a, 1e-9) < a.cols();
  }
  for (std::size_t k = 0; k < result.limits.size(); ++k)
    result.limits[k].multiplier = multipliers[static_cast<Index>(k)];
  result.residual = left.cwiseAbs().maxCoeff();
  for (const double slope : left) result.downhill.push_back(-slope);
}

}  // namespace

Optimality optimality_at(DesignProblem& problem, const ProblemScale& scale, std::span<const double> z) {
  Optimality result;
  const DesignPoint point = problem.at(z);
  for (std::size_t j = 0; j < point.margin.size(); ++j) {
    const ConstraintValues& sides = problem.sides()[j];
    const double size = std::max({std::abs(sides.left), std::abs(sides.right), 1e-3 * scale.margin[j]});
    if (std::abs(point.margin[j]) <= kReached * size) result.limits.push_back({ReachedLimit::Kind::constraint, j});
  }
  add_ends(z, result.limits);
  const DesignSlopes slopes = problem.slopes(z);
  bool finite = std::all_of(slopes.f.begin(), slopes.f.end(), [](double v) { return std::isfinite(v); });
  for (const ReachedLimit& limit : result.limits)
    for (std::size_t i = 0; limit.kind == ReachedLimit::Kind::constraint && i < z.size(); ++i)
      finite = finite && std::isfinite(slopes.margin[limit.index * z.size() + i]);
  if (!finite) return result;
  result.smooth = true;
  hold(result, Eigen::Map<const VectorXd>(slopes.f.data(), static_cast<Index>(z.size())) / scale.f, slopes, scale);
  for (ReachedLimit& limit : result.limits)
    limit.gain = limit.multiplier * scale.f /
                 (limit.kind == ReachedLimit::Kind::constraint ? scale.margin[limit.index]
                                                               : problem.stretch(limit.index, z[limit.index]));
  return result;
}

Optimality nearness_at(DesignProblem& problem, const ProblemScale& scale, std::span<const double> z) {
  Optimality result;
  const DesignPoint point = problem.at(z);
  const DesignSlopes slopes = problem.slopes(z);
  add_ends(z, result.limits);
  const auto n = static_cast<Index>(z.size());
  VectorXd slope = VectorXd::Zero(n);
  for (std::size_t j = 0; j < point.margin.size(); ++j) {
    const double short_of = -point.margin[j] / scale.margin[j];
    if (!(short_of > 0.0)) continue;
    for (Index i = 0; i < n; ++i)
      slope[i] -=
          short_of * slopes.margin[j * static_cast<std::size_t>(n) + static_cast<std::size_t>(i)] / scale.margin[j];
  }
  if (!slope.allFinite()) return result;
  result.smooth = true;
  hold(result, slope, slopes, scale);
  return result;
}

}  // namespace study
