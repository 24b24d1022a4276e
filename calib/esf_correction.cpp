// SPDX-License-Identifier: Apache-2.0
#include "calib/esf_correction.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace calib {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The cubic B-spline of unit knots and its slope.
double spline(double x) {
  const double a = std::abs(x);
  if (a >= 2.0) return 0.0;
  const double b = 2.0 - a;
  return a < 1.0 ? 2.0 / 3.0 - a * a * (1.0 - 0.5 * a) : b * b * b / 6.0;
}
double spline_slope(double x) {
  const double a = std::abs(x), b = 2.0 - a;
  if (a >= 2.0) return 0.0;
  return (x < 0.0 ? -1.0 : 1.0) * (a < 1.0 ? a * (1.5 * a - 2.0) : -0.5 * b * b);
}

std::vector<SplinePair> place_splines(double width_px, double reach_px, Detail detail) {
  const bool fine = detail == Detail::fine;
  std::vector<SplinePair> pairs;
  const double end =
      std::min(reach_px, fine ? std::clamp(6.0 * width_px, 16.0, 32.0) : std::clamp(4.0 * width_px, 8.0, 24.0));
  for (const bool odd : {true, false}) {
    double h = std::clamp(width_px / 8.0, 0.25, 1.5),
           zone_end = fine ? std::max(4.0, 2.0 * width_px) : std::max(2.5, 1.25 * width_px);
    double x = odd ? h : 0.0;
    while (x + 2.0 * h < end) {
      const double away = x / (1.0 + width_px);
      pairs.push_back({x, h, odd, 1.0 / (1.0 + away * away)});
      if (x + h > zone_end) {
        x += 0.5 * h;  // between the steps of both zones
        h *= 2.0;
        zone_end *= 2.0;
      }
      x += h;
    }
  }
  return pairs;
}

// Products of the splines with each other, the model's unknowns and the residuals.
struct SplineEquations {
  MatrixXd with_each_other, with_unknowns;
  VectorXd with_residual;
};

SplineEquations assemble_splines(const FitState& state, const EdgeModel& model, const std::vector<SplinePair>& pairs,
                                 const std::vector<int>& unknowns) {
  const auto count = static_cast<Eigen::Index>(pairs.size());
  const auto fixed = static_cast<Eigen::Index>(unknowns.size());
  SplineEquations equations{MatrixXd::Zero(count, count), MatrixXd::Zero(fixed, count), VectorXd::Zero(count)};
  const DistanceBins& bins = DistanceBins::get();
  struct Active {
    Eigen::Index column;
    double value;
  };
  std::vector<Active> active;
  const Basis basis(state.profile, model.contrast(), Unknowns().set());
  // Sums over a bin and its mirror image for even pairs, differences for odd ones.
  struct Sided {
    VectorXd column;
    double residual = 0.0;
  };
  Sided even{VectorXd(fixed)}, odd{VectorXd(fixed)};
  for (int side = 0; side < kSideBins; ++side) {
    const double d = bins.centre(kSideBins + side);
    active.clear();
    for (std::size_t j = 0; j < pairs.size(); ++j)
      if (std::abs(d - pairs[j].x_px) < 2.0 * pairs[j].h_px)
        if (const double value = pair_value(pairs[j], d); value != 0.0)
          active.push_back({static_cast<Eigen::Index>(j), model.contrast() * value});
    if (active.empty()) continue;
    const int bright = kSideBins + side, dark = kSideBins - 1 - side;
    const double weight_b = state.weight[static_cast<std::size_t>(bright)],
                 weight_d = state.weight[static_cast<std::size_t>(dark)];
    const double n_b = weight_b * state.sums.count(bright), n_d = weight_d * state.sums.count(dark);
    if (n_b == 0.0 && n_d == 0.0) continue;
    for (Eigen::Index k = 0; k < fixed; ++k) {
      const int unknown = unknowns[static_cast<std::size_t>(k)];
      const BinRow &row = basis.row(unknown), &moment = state.sums.moment(basis_power(unknown));
      const auto term = [&](int i, double weight) {
        const bool zero = is_bend(unknown) && !state.profile.shows_bends(i);
        return zero ? 0.0
                    : basis.scale(unknown) * weight * row[static_cast<std::size_t>(i)] *
                          moment[static_cast<std::size_t>(i)];
      };
      const double b = term(bright, weight_b), a = term(dark, weight_d);
      even.column[k] = b + a;
      odd.column[k] = b - a;
    }
    const double r_b = weight_b * state.sums.residual(0)[static_cast<std::size_t>(bright)],
                 r_d = weight_d * state.sums.residual(0)[static_cast<std::size_t>(dark)];
    even.residual = r_b + r_d;
    odd.residual = r_b - r_d;
    for (std::size_t j = 0; j < active.size(); ++j) {
      const auto [column, value] = active[j];
      const bool is_odd = pairs[static_cast<std::size_t>(column)].odd;
      const Sided& mine = is_odd ? odd : even;
      equations.with_residual[column] += value * mine.residual;
      equations.with_unknowns.col(column) += value * mine.column;
      for (std::size_t k = 0; k <= j; ++k) {
        const bool alike = pairs[static_cast<std::size_t>(active[k].column)].odd == is_odd;
        equations.with_each_other(column, active[k].column) +=
            (alike ? n_b + n_d : n_b - n_d) * value * active[k].value;
      }
    }
  }
  equations.with_each_other = equations.with_each_other.selfadjointView<Eigen::Lower>();
  return equations;
}

// The tau^2 of largest marginal likelihood, 0 where the data do not ask for any. With A = (information on the
// coefficients beside the model's unknowns), scaled to unit prior, and z the scores in its eigenvectors, of variance
// lambda + tau^2 lambda^2, twice the gain in log likelihood is sum of tau^2 z^2 / (1 + tau^2 lambda) - ln(1 + tau^2
// lambda).
double likeliest_variance(const MatrixXd& information, const VectorXd& score) {
  constexpr double kLeastGain = 3.0;
  if (information.rows() == 0 || !(score.squaredNorm() > information.trace())) return 0.0;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(information);
  const VectorXd z = eigen.eigenvectors().transpose() * score;
  const double largest = eigen.eigenvalues().maxCoeff();
  if (!(largest > 0.0)) return 0.0;
  const auto gain = [&](double log_variance) {
    const double t = std::exp(log_variance);
    double sum = 0.0, product = 1.0;  // one logarithm for many factors
    for (Eigen::Index i = 0; i < z.size(); ++i) {
      const double grown = 1.0 + t * std::max(0.0, eigen.eigenvalues()[i]);
      sum += t * z[i] * z[i] / grown;
      product *= grown;
      if (product < 1e150) continue;
      sum -= std::log(product);
      product = 1.0;
    }
    return sum - std::log(product);
  };
  double best = 0.0, best_gain = kLeastGain;
  const double first = std::log(1e-2 / largest), last = std::min(first + 60.0, std::log(100.0));
  for (double at = first; at <= last; at += 0.25)
    if (const double value = gain(at); value > best_gain) best = std::exp(at), best_gain = value;
  return best;
}

}  // namespace

double pair_value(const SplinePair& pair, double d_px) {
  const double near = spline((d_px - pair.x_px) / pair.h_px);
  if (pair.x_px == 0.0) return near;
  const double far = spline((d_px + pair.x_px) / pair.h_px);
  return pair.odd ? near - far : near + far;
}

double pair_slope(const SplinePair& pair, double d_px) {
  const double near = spline_slope((d_px - pair.x_px) / pair.h_px) / pair.h_px;
  if (pair.x_px == 0.0) return near;
  const double far = spline_slope((d_px + pair.x_px) / pair.h_px) / pair.h_px;
  return pair.odd ? near - far : near + far;
}

JointFit solve_jointly(const FitState& state, const EdgeModel& model, const Unknowns& unknowns, Detail detail,
                       double width_px, double reach_px) {
  JointFit joint;
  for (int a = 0; a < kUnknowns; ++a)
    if (unknowns[static_cast<std::size_t>(a)]) joint.unknowns.push_back(a);
  const std::vector<SplinePair> pairs =
      detail == Detail::none ? std::vector<SplinePair>() : place_splines(width_px, reach_px, detail);
  const SplineEquations splines = assemble_splines(state, model, pairs, joint.unknowns);

  NormalEquations normal = state.normal;
  add_prior(normal, model.shape, unknowns);
  const auto fixed = static_cast<Eigen::Index>(joint.unknowns.size());
  MatrixXd n(fixed, fixed);
  VectorXd r(fixed);
  for (Eigen::Index i = 0; i < fixed; ++i) {
    r[i] = normal.gradient[joint.unknowns[static_cast<std::size_t>(i)]];
    for (Eigen::Index j = 0; j < fixed; ++j)
      n(i, j) = normal.matrix(joint.unknowns[static_cast<std::size_t>(i)], joint.unknowns[static_cast<std::size_t>(j)]);
  }
  const VectorXd scale = n.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  n = scale.asDiagonal() * n * scale.asDiagonal();
  n.diagonal().array() += 1e-13;
  const Eigen::LDLT<MatrixXd> factor(n);

  // Each group's tau, the model's unknowns projected out.
  const MatrixXd cross = scale.asDiagonal() * splines.with_unknowns;
  const MatrixXd explained = factor.solve(cross);
  const VectorXd score = splines.with_residual - explained.transpose() * scale.cwiseProduct(r);
  std::vector<Eigen::Index> chosen;
  std::vector<double> precision;
  for (const bool odd : {true, false}) {
    std::vector<Eigen::Index> group;
    for (std::size_t j = 0; j < pairs.size(); ++j)
      if (pairs[j].odd == odd) group.push_back(static_cast<Eigen::Index>(j));
    const auto size = static_cast<Eigen::Index>(group.size());
    MatrixXd information(size, size);
    VectorXd scaled(size);
    for (Eigen::Index j = 0; j < size; ++j) {
      const Eigen::Index a = group[static_cast<std::size_t>(j)];
      scaled[j] = pairs[static_cast<std::size_t>(a)].prior_sd * score[a];
      for (Eigen::Index k = 0; k <= j; ++k) {
        const Eigen::Index b = group[static_cast<std::size_t>(k)];
        information(j, k) = pairs[static_cast<std::size_t>(a)].prior_sd * pairs[static_cast<std::size_t>(b)].prior_sd *
                            (splines.with_each_other(a, b) - cross.col(a).dot(explained.col(b)));
        information(k, j) = information(j, k);
      }
    }
    const double variance = likeliest_variance(information, scaled);
    (odd ? joint.tau_odd : joint.tau_even) = std::sqrt(variance);
    if (variance == 0.0) continue;
    for (const Eigen::Index a : group) {
      chosen.push_back(a);
      const double sd = pairs[static_cast<std::size_t>(a)].prior_sd;
      precision.push_back(1.0 / (variance * sd * sd));
      joint.splines.push_back(pairs[static_cast<std::size_t>(a)]);
    }
  }

  const auto total = fixed + static_cast<Eigen::Index>(chosen.size());
  MatrixXd all = MatrixXd::Zero(total, total);
  VectorXd right(total), penalty = VectorXd::Zero(total), full_scale(total);
  all.topLeftCorner(fixed, fixed) = n;
  right.head(fixed) = scale.cwiseProduct(r);
  full_scale.head(fixed) = scale;
  for (Eigen::Index j = 0; j < total - fixed; ++j) {
    const Eigen::Index a = chosen[static_cast<std::size_t>(j)];
    const double p = precision[static_cast<std::size_t>(j)];
    full_scale[fixed + j] = 1.0 / std::sqrt(splines.with_each_other(a, a) + p);
    penalty[fixed + j] = p * full_scale[fixed + j] * full_scale[fixed + j];
    right[fixed + j] = full_scale[fixed + j] * splines.with_residual[a];
    all.col(fixed + j).head(fixed) = cross.col(a) * full_scale[fixed + j];
    all.row(fixed + j).head(fixed) = all.col(fixed + j).head(fixed).transpose();
    for (Eigen::Index k = 0; k <= j; ++k) {
      const Eigen::Index b = chosen[static_cast<std::size_t>(k)];
      const double value = splines.with_each_other(a, b) * full_scale[fixed + j] * full_scale[fixed + k];
      all(fixed + j, fixed + k) = all(fixed + k, fixed + j) = value;
    }
  }
  MatrixXd penalised = all;
  penalised.diagonal() += penalty;
  const Eigen::LDLT<MatrixXd> whole(penalised);
  const VectorXd solution = whole.solve(right);
  const MatrixXd inverse = whole.solve(MatrixXd::Identity(total, total));
  joint.value = full_scale.cwiseProduct(solution);
  const double contrast = model.contrast() + joint.value[1] - joint.value[0];  // the levels are always unknowns
  if (contrast > 0.5 * model.contrast()) joint.contrast_ratio = std::min(2.0, model.contrast() / contrast);
  const double spent = static_cast<double>(total) - penalty.dot(inverse.diagonal());
  const double left = state.normal.chi2 - 2.0 * solution.dot(right) + solution.dot(all * solution);
  joint.chi2_per_dof = std::max(0.0, left) / std::max(1.0, state.normal.count - spent);
  // A model that stays further from the pixels than their noise is known no better than that.
  joint.covariance = std::max(1.0, joint.chi2_per_dof) * (full_scale.asDiagonal() * inverse * full_scale.asDiagonal());
  return joint;
}

}  // namespace calib
