// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/correction/esf_correction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "calib/dense.h"
#include "calib/measure/defects/score_covariance.h"
#include "mtf/math/clones.h"

namespace calib {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = StepChange::Kind;

constexpr double kPi = std::numbers::pi;

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

// A pair: of the splines at x and at -x, the second with the sign of its kind. At 0 they are one.
template <class Function>
double pair_of(const StepChange& pair, double d_px, const Function& function) {
  const double own = function((d_px - pair.x_px) / pair.h_px);
  if (pair.x_px == 0.0) return own;
  const double mirrored = function((d_px + pair.x_px) / pair.h_px);
  return pair.kind == Kind::odd ? own - mirrored : own + mirrored;
}

double phi(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }
double density(double x) { return std::exp(-0.5 * x * x) / std::sqrt(2.0 * kPi); }

/// `width_px`: equivalent width of the line spread; `extent_px`: how far there are pixels on both sides; odd splines,
/// then wide steps, then even splines.
std::vector<StepChange> place_changes(double width_px, double extent_px, Detail detail) {
  const bool fine = detail == Detail::fine;
  std::vector<StepChange> changes;
  const double end =
      std::min(extent_px, fine ? std::clamp(6.0 * width_px, 16.0, 32.0) : std::clamp(4.0 * width_px, 8.0, 24.0));
  const auto place_splines = [&](Kind kind) {
    double h = std::clamp(width_px / 8.0, 0.25, 1.5),
           zone_end = fine ? std::max(4.0, 2.0 * width_px) : std::max(2.5, 1.25 * width_px);
    double x = kind == Kind::odd ? h : 0.0;
    while (detail != Detail::none && x + 2.0 * h < end) {
      const double away = x / (1.0 + width_px);
      changes.push_back({kind, x, h, 1.0 / (1.0 + away * away)});
      if (x + h > zone_end) {
        x += 0.5 * h;  // the mean of the steps of both zones
        h *= 2.0;
        zone_end *= 2.0;
      }
      x += h;
    }
  };
  place_splines(Kind::odd);
  // Of a Gaussian blur the width is 2.5 standard deviations. Light scattered further than the pixels extend can hardly
  // be told from their plateaus.
  constexpr double kNarrow = 0.4, kGaussians = 1.5, kLorentzians = 5.0, kBeyond = 2.5;
  const double narrow_px = kNarrow * width_px;
  for (const double px : {2.0, 4.0, 8.0, 16.0, 32.0})
    if (px >= kGaussians * narrow_px && px < extent_px) changes.push_back({Kind::gaussian, narrow_px, px});
  for (const double px : {6.0, 12.0, 24.0, 48.0, 96.0})
    if (px >= kLorentzians * narrow_px && px < kBeyond * extent_px)
      changes.push_back({Kind::lorentzian, narrow_px, px});
  place_splines(Kind::even);
  return changes;
}

using SideRow = std::array<double, kSideBins>;

// A change's values in the bins of the bright side where it is not zero. Even splines are the same on the dark side,
// all others the negative.
struct Spread {
  bool even = false;
  int first = 0, end = kSideBins;
  SideRow value;
};

Spread spread_of(const StepChange& change, double contrast) {
  const double* centre = DistanceBins::get().centres().data() + kSideBins;
  Spread spread;
  spread.even = change.kind == Kind::even;
  if (!change.wide()) {
    const double reach = 2.0 * change.h_px;
    while (spread.first < kSideBins && centre[spread.first] <= change.x_px - reach) ++spread.first;
    while (spread.end > spread.first && centre[spread.end - 1] >= change.x_px + reach) --spread.end;
  }
  for (int i = spread.first; i < spread.end; ++i)
    spread.value[static_cast<std::size_t>(i)] = contrast * change_value(change, centre[i]);
  return spread;
}

// Sums over a bin and its mirror image, as even changes take them, and differences.
struct Folded {
  SideRow even, odd;
  const SideRow& of(bool is_even) const { return is_even ? even : odd; }
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

// The equations of all: the unknowns of the model, then the step's changes.
struct Equations {
  MatrixXd information;
  VectorXd score;
};

Equations assemble_all(const FitState& state, const EdgeModel& model, const std::vector<int>& unknowns,
                       const std::vector<Spread>& spreads) {
  const auto own = static_cast<Index>(unknowns.size()), all = own + static_cast<Index>(spreads.size());
  Equations equations{MatrixXd::Zero(all, all), VectorXd::Zero(all)};
  NormalEquations normal = state.normal;
  add_prior(normal, model.shape, Unknowns().set());
  equations.information.topLeftCorner(own, own) = normal.matrix(unknowns, unknowns);
  equations.score.head(own) = normal.gradient(unknowns);
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
    const bool part = is_bend(unknowns[k]);
    folded(basis.row(unknowns[k]), state.sums.moment(basis_power(unknowns[k])), part ? state.profile.bend_first : 0,
           part ? state.profile.bend_end : kBins, columns[k]);
  }
  SideRow counted;
  for (std::size_t j = 0; j < spreads.size(); ++j) {
    const auto& [even, first, end, value] = spreads[j];
    const Index column = own + static_cast<Index>(j);
    equations.score[column] = sum_of_products(value, residuals.of(even), first, end);
    for (std::size_t k = 0; k < unknowns.size(); ++k)
      equations.information(column, static_cast<Index>(k)) =
          basis.scale(unknowns[k]) * sum_of_products(value, columns[k].of(even), first, end);
    for (const bool alike : {true, false}) {
      for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(end); ++i)
        counted[i] = value[i] * counts.of(alike)[i];
      for (std::size_t k = 0; k <= j; ++k) {
        if ((spreads[k].even == even) != alike) continue;
        const int from = std::max(first, spreads[k].first), to = std::min(end, spreads[k].end);
        if (from < to)
          equations.information(column, own + static_cast<Index>(k)) =
              sum_of_products(counted, spreads[k].value, from, to);
      }
    }
  }
  equations.information = MatrixXd(equations.information.selfadjointView<Eigen::Lower>());
  return equations;
}

// Where neighbouring pixels share their noise the scores have the covariance S in place of N, the information of
// independent pixels. Scores N x + noise of that covariance know of x what equations with N S^-1 N and N S^-1 b do.
void allow_for_shared_noise(const FitState& state, const EdgeModel& model, const std::vector<int>& unknowns,
                            const std::vector<Spread>& spreads, Equations& equations) {
  const Basis basis(state.profile, model.contrast(), Unknowns().set());
  std::vector<ScoreColumn> columns;
  columns.reserve(unknowns.size() + spreads.size());
  for (const int unknown : unknowns) columns.push_back(score_column(basis, state.profile, unknown));
  for (const auto& [even, first, end, value] : spreads) {
    BinRow& row = columns.emplace_back().row;
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(end); ++i) {
      row[kSideBins + i] = value[i];
      row[kSideBins - 1 - i] = even ? value[i] : -value[i];
    }
  }
  const VectorXd scale = equations.information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd information = scale.asDiagonal() * equations.information * scale.asDiagonal();
  const MatrixXd scores = no_less_than(
      information, MatrixXd(scale.asDiagonal() * score_covariance(state, model, columns) * scale.asDiagonal()));
  MatrixXd ridged = scores;
  ridged.diagonal().array() += 1e-11;
  const SymmetricFactor factor(ridged);
  const VectorXd per_scale = scale.cwiseInverse();
  const MatrixXd weighed = information * factor.solve(information);
  equations.score =
      per_scale.asDiagonal() * (information * factor.solve(VectorXd(scale.cwiseProduct(equations.score))));
  equations.information = per_scale.asDiagonal() * (0.5 * (weighed + weighed.transpose())) * per_scale.asDiagonal();
}

// The part of an unknown of the model, none for those that are always there.
std::optional<Part> part_of(int unknown) {
  if (unknown == kFirstShape) return kDiffraction;
  if (unknown < 2 || unknown >= kPlateauTerms) return std::nullopt;
  return unknown < kFirstCurvature ? kGradient : kCurvature;
}

Part part_of(const StepChange& change) {
  if (change.wide()) return change.h_px < kFar_px ? kNearLight : kFarLight;
  return change.kind == Kind::odd ? kReal : kImaginary;
}

// Prior standard deviations of a part of size 1: uneven light changes a side by the contrast over the pixels; an
// aberration-free pupil alone has S = 2.2 standard deviations of the blur.
double unit_sd(int unknown, const EdgeModel& model, double extent_px) {
  constexpr double kPupil = 2.2;
  if (unknown == kFirstShape) return kPupil * std::sqrt(model.shape.blur_px2());
  return model.contrast() / std::pow(extent_px, plateau_powers(unknown).d);
}

}  // namespace

double change_value(const StepChange& change, double d_px) {
  if (!change.wide()) return pair_of(change, d_px, spline);
  const double x = d_px / change.h_px, narrow = phi(d_px / change.x_px);
  return (change.kind == Kind::lorentzian ? 0.5 + std::atan(x) / kPi : phi(x)) - narrow;
}

double change_slope(const StepChange& change, double d_px) {
  if (!change.wide()) return pair_of(change, d_px, spline_slope) / change.h_px;
  const double x = d_px / change.h_px, narrow = density(d_px / change.x_px) / change.x_px;
  return (change.kind == Kind::lorentzian ? 1.0 / (kPi * (1.0 + x * x)) : density(x)) / change.h_px - narrow;
}

double wide_otf(const StepChange& change, double f_cy_px) {
  const double turn = 2.0 * kPi * f_cy_px, wide = turn * change.h_px, narrow = turn * change.x_px;
  return std::exp(change.kind == Kind::lorentzian ? -wide : -0.5 * wide * wide) - std::exp(-0.5 * narrow * narrow);
}

JointFit solve_jointly(const FitState& state, const EdgeModel& model, const Unknowns& unknowns, Detail detail,
                       double width_px, double extent_px) {
  const double reach_px = std::max(1.0, extent_px);
  LinearModel linear;
  std::vector<int> fixed, parts;
  for (int a = 0; a < kUnknowns; ++a) {
    if (!unknowns[static_cast<std::size_t>(a)] || !(state.normal.matrix(a, a) > 0.0)) continue;
    (part_of(a) ? parts : fixed).push_back(a);
  }
  JointFit joint;
  joint.unknowns = fixed;
  joint.unknowns.insert(joint.unknowns.end(), parts.begin(), parts.end());
  const std::vector<StepChange> changes = place_changes(width_px, extent_px, detail);
  std::vector<Spread> spreads;
  spreads.reserve(changes.size());
  for (const StepChange& change : changes) spreads.push_back(spread_of(change, model.contrast()));
  const Equations independent = assemble_all(state, model, joint.unknowns, spreads);
  Equations equations = independent;
  if (!state.correlation.white()) allow_for_shared_noise(state, model, joint.unknowns, spreads, equations);

  // The parts' unknowns are zero without them: totals, not changes.
  const auto own = static_cast<Index>(joint.unknowns.size()), all = own + static_cast<Index>(changes.size());
  VectorXd already = VectorXd::Zero(all);
  linear.fixed = static_cast<Index>(fixed.size());
  linear.unit_sd.resize(all - linear.fixed);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Index at = linear.fixed + static_cast<Index>(i);
    already[at] = parts[i] == kFirstShape ? model.shape.s_px : model.plateau[static_cast<std::size_t>(parts[i])];
    linear.part.push_back(*part_of(parts[i]));
    linear.unit_sd[static_cast<Index>(i)] = unit_sd(parts[i], model, reach_px);
  }
  for (std::size_t j = 0; j < changes.size(); ++j) {
    linear.part.push_back(part_of(changes[j]));
    linear.unit_sd[static_cast<Index>(parts.size() + j)] = changes[j].prior_sd;
  }
  // Double precision ends where the contrast is known to a part in 10^7.
  constexpr double kMostKnown = 1e14;
  const double known =
      (equations.information(0, 0) + equations.information(1, 1)) * model.contrast() * model.contrast();
  const double part = std::min(1.0, kMostKnown / std::max(1e-300, known));
  linear.information = part * equations.information;
  linear.score = part * equations.score + linear.information * already;
  constexpr double kWide_px = 1.65;  // that of a Gaussian of MTF50 0.285
  linear.wide = width_px > kWide_px;
  constexpr double kSurroundingsKnown = 2.5e9;  // the contrast to a part in 5 x 10^4
  linear.share = std::min(1.0, kSurroundingsKnown / std::max(1e-300, known));
  const ModelAverage average = average_over_parts(linear);
  joint.probability = average.probability;

  const VectorXd change = average.mean - already;
  const double contrast = model.contrast() + change[1] - change[0];  // dark and bright value are always unknowns
  if (contrast > 0.5 * model.contrast()) joint.contrast_ratio = std::min(2.0, model.contrast() / contrast);
  const double spent =
      std::clamp(independent.information.cwiseProduct(average.covariance).sum(), 0.0, static_cast<double>(all));
  const double left =
      state.normal.chi2 - 2.0 * change.dot(independent.score) + change.dot(independent.information * change);
  joint.chi2_per_dof = std::max(0.0, left) / std::max(1.0, state.normal.count - spent);
  // Where the pixels lie further from the model than their noise, the misfit counts as noise.
  const double misfit = std::max(1.0, joint.chi2_per_dof);
  std::vector<Index> kept;
  for (Index i = 0; i < own; ++i) kept.push_back(i);
  for (std::size_t j = 0; j < changes.size(); ++j) {
    if (joint.probability[part_of(changes[j])] == 0.0) continue;
    kept.push_back(own + static_cast<Index>(j));
    joint.changes.push_back(changes[j]);
  }
  joint.value = change(kept);
  joint.covariance = misfit * average.covariance(kept, kept);
  return joint;
}

}  // namespace calib
