// SPDX-License-Identifier: Apache-2.0
#include "calib/edge_bin_fit.h"

#include <algorithm>

namespace calib {
namespace {

// The coefficients of t^k in the square of the shift, as far as there are sums of them.
std::array<double, kHighestOrder + 1> square_of_shift(const Vector& step) {
  std::array<double, kHighestOrder + 1> square{};
  for (int j = 0; j <= kHighestOrder; ++j)
    for (int k = 0; j + k <= kHighestOrder; ++k)
      square[static_cast<std::size_t>(j + k)] += step[kFirstShift + j] * step[kFirstShift + k];
  return square;
}

// The state of a model near the one of `base`; its shape may be any.
FitState predict(const FitState& base, const EdgeModel& from, const EdgeModel& model, const FitRounds& rounds) {
  const Vector step = way(from, model);
  FitState state;
  state.noise = base.noise;
  state.sums = base.sums;
  StepProfile& profile = state.profile = make_profile(tabulate(model.shape, model.curve.angle_rad));
  profile.bend_first = std::max(profile.bend_first, base.profile.bend_first);  // where there are sums of high powers
  profile.bend_end = std::max(profile.bend_first, std::min(profile.bend_end, base.profile.bend_end));
  std::array<Eigen::ArrayXd, kHighestOrder + 1> change;  // of the model, by power of t
  change[0] = from.contrast() * (Eigen::Map<const Eigen::ArrayXd>(profile.esf.data(), kBins) -
                                 Eigen::Map<const Eigen::ArrayXd>(base.profile.esf.data(), kBins));
  int highest = 1;
  for (int a = 0; a < kFirstShape; ++a) {
    if (step[a] == 0.0) continue;
    const int power = basis_power(a);
    Eigen::ArrayXd& sum = change[static_cast<std::size_t>(power)];
    if (sum.size() == 0) sum = Eigen::ArrayXd::Zero(kBins);
    sum += step[a] * basis_values(a, profile, model.contrast());
    highest = std::max(highest, power);
  }
  const std::array<double, kHighestOrder + 1> square = square_of_shift(step);
  if (state.sums.bends())
    for (int k = 2; k <= kHighestOrder; ++k)
      if (square[static_cast<std::size_t>(k)] != 0.0) highest = std::max(highest, k);
  for (int i = 0; i < kBins; ++i) {
    if (state.sums.count(i) == 0.0) continue;
    const double bend = model.contrast() * profile.cubic[static_cast<std::size_t>(i)][2];
    std::array<double, kHighestOrder + 1> taken{};
    for (std::size_t k = 0; k < change.size(); ++k)
      taken[k] = (change[k].size() > 0 ? change[k][i] : 0.0) + bend * square[k];
    state.sums.take_from_residual(i, taken, state.sums.bends() && highest > 1 && profile.shows_bends(i));
  }
  assemble(state, model, rounds);
  return state;
}

bool same(const ReferenceShape& a, const ReferenceShape& b) {
  return a.s_px == b.s_px && a.v_px2 == b.v_px2 && a.q_px2 == b.q_px2;
}

}  // namespace

FitState fit_on_bins(const FitState& state, const EdgeModel& from, EdgeModel& model, const FitRounds& rounds) {
  const bool there = same(from.shape, model.shape) && way(from, model).isZero(0.0);
  return descend(model, rounds, there ? state : predict(state, from, model, rounds),
                 [&](const EdgeModel& next) { return predict(state, from, next, rounds); });
}

bool foretold(const FitState& state, const EdgeModel& from, const FitState& near, const EdgeModel& model,
              double enough) {
  constexpr double kShort = 0.15;  // of the blur: unknowns are off by less than a fifth of their standard deviations
  const Vector step = way(from, model);
  const double most_px = step.segment<kHighestOrder + 1>(kFirstShift).lpNorm<1>();
  double square_px2 = 0.0;  // of the shift, its mean over the edge
  for (int j = 0; j <= kHighestOrder; ++j)
    for (int k = j % 2; k <= kHighestOrder; k += 2)
      square_px2 += step[kFirstShift + j] * step[kFirstShift + k] / (j + k + 1.0);
  if (square_px2 > kShort * kShort * model.shape.blur_px2()) return false;
  double chi2 = 0.0;
  for (int i = 0; i < kBins; ++i) {
    const auto bin = static_cast<std::size_t>(i);
    const double width = DistanceBins::get().width(i), change = near.profile.lsf[bin] - state.profile.lsf[bin];
    const double bend = 2.0 * near.profile.cubic[bin][2], third = near.profile.cubic[bin][3] * most_px * most_px;
    const double square =
        third * third * square_px2 + (bend * bend * square_px2 + change * change) * width * width / 12.0;
    chi2 += near.weight[bin] * near.sums.count(i) * square;
  }
  return chi2 * model.contrast() * model.contrast() < enough;
}

}  // namespace calib
