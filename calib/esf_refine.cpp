// SPDX-License-Identifier: Apache-2.0
#include "calib/esf_refine.h"

#include <cmath>

namespace calib {
namespace {

// Changes of E and of its slope, the line spread, at the middle of each bin.
struct Change {
  std::vector<double> esf, lsf;
};

Change change_of(const StepProfile& reference, const JointFit& joint) {
  const DistanceBins& bins = DistanceBins::get();
  Change change{std::vector<double>(kBins), std::vector<double>(kBins)};
  for (std::size_t i = 0; i < joint.unknowns.size(); ++i) {
    if (joint.unknowns[i] < kFirstShape) continue;
    const auto& slope = reference.slope[static_cast<std::size_t>(joint.unknowns[i] - kFirstShape)];
    const double value = joint.value[static_cast<Eigen::Index>(i)];
    for (int b = 0; b < kBins; ++b) {
      const auto at = static_cast<std::size_t>(b), before = at - (b > 0), after = at + (b + 1 < kBins);
      change.esf[at] += value * slope[at];
      change.lsf[at] += value * (slope[after] - slope[before]) /
                        (bins.centre(static_cast<int>(after)) - bins.centre(static_cast<int>(before)));
    }
  }
  for (std::size_t j = 0; j < joint.splines.size(); ++j) {
    const SplinePair& pair = joint.splines[j];
    const double value = joint.value[static_cast<Eigen::Index>(joint.unknowns.size() + j)];
    for (int b = 0; b < kBins; ++b) {
      const double d = bins.centre(b), sign = d < 0.0 ? -1.0 : 1.0;
      const double e = pair_value(pair, std::abs(d)), slope = pair_slope(pair, std::abs(d));
      change.esf[static_cast<std::size_t>(b)] += value * (pair.odd ? sign * e : e);
      change.lsf[static_cast<std::size_t>(b)] += value * (pair.odd ? slope : sign * slope);
    }
  }
  return change;
}

}  // namespace

Vector movement(const JointFit& joint) {
  Vector step = Vector::Zero();
  for (std::size_t i = 0; i < joint.unknowns.size(); ++i)
    step[joint.unknowns[i]] = joint.value[static_cast<Eigen::Index>(i)];
  return step;
}

StepProfile corrected_profile(const StepProfile& reference, const JointFit& joint) {
  const Change change = change_of(reference, joint);
  const DistanceBins& bins = DistanceBins::get();
  StepProfile profile = reference;
  for (std::size_t i = 0; i < kBins; ++i) {
    const std::size_t before = i - (i > 0), after = i + (i + 1 < kBins);
    const double apart = bins.centre(static_cast<int>(after)) - bins.centre(static_cast<int>(before));
    profile.esf[i] += change.esf[i];
    profile.lsf[i] += change.lsf[i];
    profile.cubic[i][0] += change.esf[i];
    profile.cubic[i][1] += change.lsf[i];
    profile.cubic[i][2] += 0.5 * (change.lsf[after] - change.lsf[before]) / apart;
  }
  return profile;
}

FitState refine(const EdgePixels& pixels, EdgeModel& model, StepProfile& reference, const JointFit& joint,
                const FitRounds& rounds) {
  move(model, movement(joint));
  FitState next;
  next.profile = corrected_profile(reference, joint);
  next.sums = accumulate(pixels, model, next.profile, highest_power(rounds.unknowns));
  next.noise = noise_of(next.sums, next.profile, rounds);
  reference = make_profile(tabulate(model.shape, model.curve.angle_rad));
  for (std::size_t i = 0; i < kBins; ++i)
    next.sums.add_to_residual(static_cast<int>(i), model.contrast() * (next.profile.esf[i] - reference.esf[i]));
  next.profile.slope = reference.slope;
  next.normal = assemble(next.sums, model, next.profile, next.noise, rounds.unknowns);
  next.converged = true;
  return next;
}

}  // namespace calib
