// SPDX-License-Identifier: Apache-2.0
#include "calib/edge_bin_fit.h"

#include <algorithm>

namespace calib {
namespace {

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
  for (int i = 0; i < kBins; ++i) {
    if (state.sums.count(i) == 0.0) continue;
    std::array<double, kHighestOrder + 1> taken{};
    for (std::size_t k = 0; k < change.size(); ++k)
      if (change[k].size() > 0) taken[k] = change[k][i];
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

}  // namespace calib
