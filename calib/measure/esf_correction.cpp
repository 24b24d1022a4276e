// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/esf_correction.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "calib/measure/defects/score_covariance.h"
#include "mtf/engines/clones.h"

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

std::vector<SplinePair> place_splines(double width_px, double extent_px, Detail detail) {
  const bool fine = detail == Detail::fine;
  std::vector<SplinePair> pairs;
  const double end =
      std::min(extent_px, fine ? std::clamp(6.0 * width_px, 16.0, 32.0) : std::clamp(4.0 * width_px, 8.0, 24.0));
  for (const bool odd : {true, false}) {
    double h = std::clamp(width_px / 8.0, 0.25, 1.5),
           zone_end = fine ? std::max(4.0, 2.0 * width_px) : std::max(2.5, 1.25 * width_px);
    double x = odd ? h : 0.0;
    while (x + 2.0 * h < end) {
      const double away = x / (1.0 + width_px);
      pairs.push_back({x, h, odd, 1.0 / (1.0 + away * away)});
      if (x + h > zone_end) {
        x += 0.5 * h;  // the mean of the steps of both zones
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

using SideRow = std::array<double, kSideBins>;

// A pair's values in the bins of a side where it is not zero.
struct Spread {
  int first = 0, end = 0;
  SideRow value;
};

Spread spread_of(const SplinePair& pair, double contrast) {
  const double* centre = DistanceBins::get().centres().data() + kSideBins;
  Spread spread;
  while (spread.first < kSideBins && centre[spread.first] <= pair.x_px - 2.0 * pair.h_px) ++spread.first;
  for (spread.end = spread.first; spread.end < kSideBins && centre[spread.end] < pair.x_px + 2.0 * pair.h_px;
       ++spread.end)
    spread.value[static_cast<std::size_t>(spread.end)] = contrast * pair_value(pair, centre[spread.end]);
  return spread;
}

// Sums over a bin and its mirror image, as even pairs take them, and differences, as odd ones do.
struct Folded {
  SideRow even, odd;
  const SideRow& of(bool is_odd) const { return is_odd ? odd : even; }
};
void fold(const BinRow& row, Folded& folded) {
  for (std::size_t i = 0; i < kSideBins; ++i) {
    const double bright = row[kSideBins + i], dark = row[kSideBins - 1 - i];
    folded.even[i] = bright + dark;
    folded.odd[i] = bright - dark;
  }
}

MTFKIT_CLONES double sum_of_products(const SideRow& a, const SideRow& b, int first, int end) {
  constexpr int kLanes = 8;
  std::array<double, kLanes> sum{};
  int i = first;
  for (; i + kLanes <= end; i += kLanes)
    for (int k = 0; k < kLanes; ++k)
      sum[static_cast<std::size_t>(k)] += a[static_cast<std::size_t>(i + k)] * b[static_cast<std::size_t>(i + k)];
  double total = 0.0;
  for (; i < end; ++i) total += a[static_cast<std::size_t>(i)] * b[static_cast<std::size_t>(i)];
  return total + ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

SplineEquations assemble_splines(const FitState& state, const EdgeModel& model, const std::vector<SplinePair>& pairs,
                                 const std::vector<int>& unknowns) {
  const auto count = static_cast<Eigen::Index>(pairs.size());
  const auto fixed = static_cast<Eigen::Index>(unknowns.size());
  SplineEquations equations{MatrixXd::Zero(count, count), MatrixXd::Zero(fixed, count), VectorXd::Zero(count)};
  if (pairs.empty()) return equations;
  const Basis basis(state.profile, model.contrast(), Unknowns().set());
  BinRow row;
  const auto folded = [&](const BinRow& a, const BinRow& b, int first, int end, Folded& out) {
    row.fill(0.0);
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(end); ++i)
      row[i] = state.weight[i] * a[i] * b[i];
    fold(row, out);
  };
  BinRow ones;
  ones.fill(1.0);
  Folded counts, residuals;
  folded(state.sums.moment(0), ones, 0, kBins, counts);
  folded(state.sums.residual(0), ones, 0, kBins, residuals);
  std::vector<Folded> columns(unknowns.size());
  for (std::size_t k = 0; k < unknowns.size(); ++k) {
    const int a = unknowns[k];
    const bool part = is_bend(a);
    folded(basis.row(a), state.sums.moment(basis_power(a)), part ? state.profile.bend_first : 0,
           part ? state.profile.bend_end : kBins, columns[k]);
  }
  std::vector<Spread> spreads;
  spreads.reserve(pairs.size());
  SideRow counted;
  for (std::size_t j = 0; j < pairs.size(); ++j) {
    const bool odd = pairs[j].odd;
    spreads.push_back(spread_of(pairs[j], model.contrast()));
    const auto& [first, end, value] = spreads.back();
    const auto column = static_cast<Eigen::Index>(j);
    equations.with_residual[column] = sum_of_products(value, residuals.of(odd), first, end);
    for (std::size_t k = 0; k < unknowns.size(); ++k)
      equations.with_unknowns(static_cast<Eigen::Index>(k), column) =
          basis.scale(unknowns[k]) * sum_of_products(value, columns[k].of(odd), first, end);
    for (const bool alike : {true, false}) {
      for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(end); ++i)
        counted[i] = value[i] * counts.of(!alike)[i];
      for (std::size_t k = 0; k <= j; ++k) {
        if ((pairs[k].odd == odd) != alike) continue;
        const int from = std::max(first, spreads[k].first), to = std::min(end, spreads[k].end);
        if (from < to)
          equations.with_each_other(column, static_cast<Eigen::Index>(k)) =
              sum_of_products(counted, spreads[k].value, from, to);
      }
    }
  }
  equations.with_each_other = equations.with_each_other.selfadjointView<Eigen::Lower>();
  return equations;
}

// The covariance of the scores of the unknowns, scaled, and of the splines where neighbouring pixels share their noise,
// given that of independent pixels.
MatrixXd correlated_scores(const FitState& state, const EdgeModel& model, const std::vector<int>& unknowns,
                           const VectorXd& scale, const std::vector<SplinePair>& pairs, const MatrixXd& independent) {
  const Basis basis(state.profile, model.contrast(), Unknowns().set());
  std::vector<ScoreColumn> columns;
  columns.reserve(unknowns.size() + pairs.size());
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    columns.push_back(score_column(basis, state.profile, unknowns[i]));
    for (double& value : columns.back().row) value *= scale[static_cast<Eigen::Index>(i)];
  }
  for (const SplinePair& pair : pairs) {
    const auto& [first, end, value] = spread_of(pair, model.contrast());
    BinRow& row = columns.emplace_back().row;
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(end); ++i) {
      row[kSideBins + i] = value[i];
      row[kSideBins - 1 - i] = pair.odd ? -value[i] : value[i];
    }
  }
  return no_less_than(independent, score_covariance(state, model, columns));
}

// Whether scores are larger than those of noise with this covariance are on average.
bool exceeds_noise(const VectorXd& score, const MatrixXd& covariance) {
  return score.squaredNorm() > covariance.trace();
}

// Whether scores differ from zero by more than one standard deviation in the direction that the pixels know best, the
// first eigenvector of the information. Of what a lens out of focus, a footprint of two pixels or spherical aberration
// add to the reference, three quarters of the chi-square lie there, so that it shows them where a sum over all
// directions is noise.
bool shape_differs(const MatrixXd& information, const VectorXd& score, const MatrixXd& covariance) {
  constexpr int kRounds = 12;  // of the power method; the first two eigenvalues are 1 : 0.73
  Eigen::Index largest = 0;
  information.diagonal().maxCoeff(&largest);
  VectorXd direction = information.col(largest);
  for (int round = 0; round < kRounds; ++round) direction = (information * direction).normalized();
  const double z = direction.dot(score);
  return z * z > direction.dot(covariance * direction);
}

// The tau^2 of largest marginal likelihood, 0 where the data do not ask for any. With A = (information on the
// coefficients beside the model's unknowns), scaled to unit prior, and z the scores in its eigenvectors, of variance
// lambda + tau^2 lambda^2, twice the gain in log likelihood is sum of tau^2 z^2 / (1 + tau^2 lambda) - ln(1 + tau^2
// lambda). Scores of correlated noise have the variance s in place of lambda, and both z and lambda count times
// lambda / s.
// `largest_likely`: the upper end of the 95 % interval instead.
double likeliest_variance(const MatrixXd& information, const VectorXd& score, const MatrixXd* noise,
                          bool largest_likely) {
  constexpr double kLeastGain = 3.0, kChi2Of95 = 3.84;
  if (information.rows() == 0) return 0.0;
  if (!largest_likely && !exceeds_noise(score, noise != nullptr ? *noise : information)) return 0.0;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(information);
  VectorXd z = eigen.eigenvectors().transpose() * score, lambda = eigen.eigenvalues();
  if (noise != nullptr) {
    const VectorXd s =
        (eigen.eigenvectors().transpose() * *noise).cwiseProduct(eigen.eigenvectors().transpose()).rowwise().sum();
    const VectorXd part = lambda.cwiseMax(0.0).cwiseQuotient(s.cwiseMax(lambda.cwiseAbs()).cwiseMax(1e-300));
    z = z.cwiseProduct(part);
    lambda = lambda.cwiseProduct(part);
  }
  const double largest = lambda.maxCoeff();
  if (!(largest > 0.0)) return 0.0;
  const auto gain = [&](double log_variance) {
    const double t = std::exp(log_variance);
    double sum = 0.0, product = 1.0;  // one logarithm for many factors
    for (Eigen::Index i = 0; i < z.size(); ++i) {
      const double grown = 1.0 + t * std::max(0.0, lambda[i]);
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
  if (!largest_likely) return best;
  if (best == 0.0) best_gain = 0.0;
  for (double at = last; at >= first; at -= 0.25)
    if (gain(at) > best_gain - kChi2Of95) return std::max(best, std::exp(at));
  return best;
}

}  // namespace

double pair_value(const SplinePair& pair, double d_px) {
  const double own = spline((d_px - pair.x_px) / pair.h_px);
  if (pair.x_px == 0.0) return own;
  const double mirrored = spline((d_px + pair.x_px) / pair.h_px);
  return pair.odd ? own - mirrored : own + mirrored;
}

double pair_slope(const SplinePair& pair, double d_px) {
  const double own = spline_slope((d_px - pair.x_px) / pair.h_px) / pair.h_px;
  if (pair.x_px == 0.0) return own;
  const double mirrored = spline_slope((d_px + pair.x_px) / pair.h_px) / pair.h_px;
  return pair.odd ? own - mirrored : own + mirrored;
}

JointFit solve_jointly(const FitState& state, const EdgeModel& model, const Unknowns& unknowns, Detail detail,
                       double width_px, double extent_px, Smoothing smoothing) {
  JointFit joint;
  for (int a = 0; a < kUnknowns; ++a)
    if (unknowns[static_cast<std::size_t>(a)]) joint.unknowns.push_back(a);
  const std::vector<SplinePair> pairs =
      detail == Detail::none ? std::vector<SplinePair>() : place_splines(width_px, extent_px, detail);
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
  MatrixXd explained(fixed, cross.cols());
  if (cross.cols() > 0) explained = factor.solve(cross);  // Eigen takes the address of the first element
  const VectorXd score = splines.with_residual - explained.transpose() * scale.cwiseProduct(r);
  const auto every = fixed + cross.cols();
  MatrixXd scores, of_splines;  // covariances of all scores and of `score` where neighbouring pixels share their noise
  if (!state.correlation.white()) {
    MatrixXd independent(every, every);
    independent << n, cross, cross.transpose(), splines.with_each_other;
    scores = correlated_scores(state, model, joint.unknowns, scale, pairs, independent);
    MatrixXd projection = MatrixXd::Identity(every, every).bottomRows(cross.cols());
    projection.leftCols(fixed) = -explained.transpose();
    of_splines = projection * scores * projection.transpose();
  }
  std::vector<Eigen::Index> chosen;
  std::vector<double> precision;
  for (const bool odd : {true, false}) {
    std::vector<Eigen::Index> group;
    for (std::size_t j = 0; j < pairs.size(); ++j)
      if (pairs[j].odd == odd) group.push_back(static_cast<Eigen::Index>(j));
    const auto size = static_cast<Eigen::Index>(group.size());
    MatrixXd information(size, size), noise(size, size);
    VectorXd scaled(size);
    for (Eigen::Index j = 0; j < size; ++j) {
      const Eigen::Index a = group[static_cast<std::size_t>(j)];
      scaled[j] = pairs[static_cast<std::size_t>(a)].prior_sd * score[a];
      for (Eigen::Index k = 0; k <= j; ++k) {
        const Eigen::Index b = group[static_cast<std::size_t>(k)];
        information(j, k) = pairs[static_cast<std::size_t>(a)].prior_sd * pairs[static_cast<std::size_t>(b)].prior_sd *
                            (splines.with_each_other(a, b) - cross.col(a).dot(explained.col(b)));
        information(k, j) = information(j, k);
        if (of_splines.size() == 0) continue;
        noise(j, k) = noise(k, j) = pairs[static_cast<std::size_t>(a)].prior_sd *
                                    pairs[static_cast<std::size_t>(b)].prior_sd * of_splines(a, b);
      }
    }
    if (odd && size > 0)
      joint.shape_in_doubt = shape_differs(information, scaled, of_splines.size() == 0 ? information : noise);
    const double variance = likeliest_variance(information, scaled, of_splines.size() == 0 ? nullptr : &noise,
                                               smoothing == Smoothing::least);
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
  const double contrast =
      model.contrast() + joint.value[1] - joint.value[0];  // dark and bright value are always unknowns
  if (contrast > 0.5 * model.contrast()) joint.contrast_ratio = std::min(2.0, model.contrast() / contrast);
  const double spent = static_cast<double>(total) - penalty.dot(inverse.diagonal());
  const double left = state.normal.chi2 - 2.0 * solution.dot(right) + solution.dot(all * solution);
  joint.chi2_per_dof = std::max(0.0, left) / std::max(1.0, state.normal.count - spent);
  // Where the pixels lie further from the model than their noise, the misfit counts as noise.
  MatrixXd unit = inverse;
  if (scores.size() > 0) {
    std::vector<Eigen::Index> kept(static_cast<std::size_t>(fixed));
    std::iota(kept.begin(), kept.end(), Eigen::Index{0});
    for (const Eigen::Index a : chosen) kept.push_back(fixed + a);
    VectorXd rescale = VectorXd::Ones(total);
    rescale.tail(total - fixed) = full_scale.tail(total - fixed);
    MatrixXd sum = rescale.asDiagonal() * scores(kept, kept) * rescale.asDiagonal();
    sum.diagonal() += penalty;
    unit = inverse * sum * inverse;
  }
  joint.covariance = std::max(1.0, joint.chi2_per_dof) * (full_scale.asDiagonal() * unit * full_scale.asDiagonal());
  return joint;
}

}  // namespace calib
