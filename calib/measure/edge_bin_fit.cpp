// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/edge_bin_fit.h"

#include <algorithm>
#include <cmath>

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

// Where the pixels of a bin lie on average, from its centre.
MTFKIT_CLONES void find_offsets(const EdgeSums& sums, BinRow& offset) {
  const BinRow &sum = sums.offset(), &count = sums.moment(0);
  for (std::size_t i = 0; i < kBins; ++i) offset[i] = sum[i] / std::max(count[i], 1.0);
}

// A step there: E, the line spread, half of its slope.
struct StepAt {
  BinRow esf, lsf, half_bend;
};
MTFKIT_CLONES void look(const StepProfile& profile, const BinRow& offset, StepAt& at) {
  const BinRow &c0 = profile.cubic(0), &c1 = profile.cubic(1), &c2 = profile.cubic(2), &c3 = profile.cubic(3);
  for (std::size_t i = 0; i < kBins; ++i) {
    const double x = offset[i];
    at.esf[i] = c0[i] + x * (c1[i] + x * (c2[i] + x * c3[i]));
    at.lsf[i] = c1[i] + x * (2.0 * c2[i] + x * 3.0 * c3[i]);
    at.half_bend[i] = c2[i] + x * 3.0 * c3[i];
  }
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
  BinRow offset;
  StepAt before, after;
  find_offsets(base.sums, offset);
  look(base.profile, offset, before);
  look(profile, offset, after);
  std::array<BinRow, kHighestOrder + 1> change{};  // of the model, by power of t
  add(from.contrast(), after.esf, change[0]);
  add(-from.contrast(), before.esf, change[0]);
  const Basis basis(profile, model.contrast(), rounds.unknowns);
  for (int a = 0; a < kLevels; ++a)
    if (step[a] != 0.0) add(step[a], basis.row(a), change[static_cast<std::size_t>(basis_power(a))]);
  const std::array<double, kHighestOrder + 1> square = square_of_shift(step);
  for (std::size_t k = 0; k < square.size(); ++k) {
    const double shift = step[kFirstShift + static_cast<int>(k)];
    if (shift != 0.0) add(-model.contrast() * shift, after.lsf, change[k]);
    if (square[k] != 0.0) add(model.contrast() * square[k], after.half_bend, change[k]);
  }
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

bool predicts_convergence(const EdgeModel& from, const FitState& near, const EdgeModel& model, double enough) {
  constexpr double kShort = 0.08;  // of the blur: unknowns are seldom off by a tenth of their standard deviations
  const Vector step = way(from, model);
  const double most_px = step.segment<kHighestOrder + 1>(kFirstShift).lpNorm<1>();
  double square_px2 = 0.0;  // of the shift, its mean over the edge
  for (int j = 0; j <= kHighestOrder; ++j)
    for (int k = j % 2; k <= kHighestOrder; k += 2)
      square_px2 += step[kFirstShift + j] * step[kFirstShift + k] / (j + k + 1.0);
  if (square_px2 > kShort * kShort * model.shape.blur_px2()) return false;
  double thirds = 0.0;
  for (std::size_t i = 0; i < kBins; ++i) {
    const double third = model.contrast() * near.profile.cubic(3)[i];
    thirds += near.weight[i] * near.sums.moment(0)[i] * third * third;
  }
  return thirds * square_px2 * std::pow(most_px, 4) < enough;
}

}  // namespace calib
