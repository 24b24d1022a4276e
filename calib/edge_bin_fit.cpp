// SPDX-License-Identifier: Apache-2.0
#include "calib/edge_bin_fit.h"

#include <algorithm>

#include "mtf/engines/clones.h"

namespace calib {
namespace {

// The coefficients of t^k in the square of the shift, as far as there may be sums of them.
std::array<double, kHighestOrder + 1> square_of_shift(const Vector& step) {
  std::array<double, kHighestOrder + 1> square{};
  for (int j = 0; j <= kHighestOrder; ++j)
    for (int k = 0; j + k <= kHighestOrder; ++k)
      square[static_cast<std::size_t>(j + k)] += step[kFirstShift + j] * step[kFirstShift + k];
  return square;
}

MTFKIT_CLONES void add(double factor, const BinRow& __restrict row, BinRow& __restrict sum) {
  for (std::size_t i = 0; i < kBins; ++i) sum[i] += factor * row[i];
}

// The state of a model near the one of `base`; its shape may be any.
FitState predict(const FitState& base, const EdgeModel& from, const EdgeModel& model, const FitRounds& rounds) {
  const Vector step = way(from, model);
  FitState state;
  state.noise = base.noise;
  state.sums = base.sums.up_to(2 * order_of(rounds.unknowns));
  StepProfile& profile = state.profile = StepProfile(tabulate(model.shape, model.curve.angle_rad));
  profile.bend_first = std::max(profile.bend_first, base.profile.bend_first);  // where there are sums of high powers
  profile.bend_end = std::max(profile.bend_first, std::min(profile.bend_end, base.profile.bend_end));
  const Basis basis(profile, model.contrast(), rounds.unknowns);
  std::array<BinRow, kHighestOrder + 1> change{};  // of the model, by power of t
  add(from.contrast(), profile.esf(), change[0]);
  add(-from.contrast(), base.profile.esf(), change[0]);
  for (int a = 0; a < kFirstShape; ++a)
    if (step[a] != 0.0) add(step[a] * basis.scale(a), basis.row(a), change[static_cast<std::size_t>(basis_power(a))]);
  const std::array<double, kHighestOrder + 1> square = square_of_shift(step);
  for (std::size_t k = 0; k < square.size(); ++k)
    if (square[k] != 0.0) add(model.contrast() * square[k], profile.cubic(2), change[k]);
  state.sums.take_from_residual(change, profile);
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
    const double width = DistanceBins::get().width(i), change = near.profile.lsf()[bin] - state.profile.lsf()[bin];
    const double bend = 2.0 * near.profile.cubic(2)[bin], third = near.profile.cubic(3)[bin] * most_px * most_px;
    const double square =
        third * third * square_px2 + (bend * bend * square_px2 + change * change) * width * width / 12.0;
    chi2 += near.weight[bin] * near.sums.count(i) * square;
  }
  return chi2 * model.contrast() * model.contrast() < enough;
}

}  // namespace calib
