// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/esf_refine.h"

#include <algorithm>
#include <cmath>

#include "calib/measure/correction/edge_response.h"
#include "calib/measure/defects/correlated_noise.h"
#include "calib/measure/edge_terms.h"

namespace calib {
namespace {

// Changes of E and of its slope, the line spread, at the middle of each bin.
struct Change {
  BinRow esf{}, lsf{};
};

// `taken` is the part of the changes by which the model moves; the rest stays with the step.
Change change_of(const StepProfile& reference, const JointFit& joint, const Vector& taken) {
  const DistanceBins& bins = DistanceBins::get();
  Change change;
  for (std::size_t i = 0; i < joint.unknowns.size(); ++i) {
    const int a = joint.unknowns[i];
    if (a < kFirstShape && a != kFirstShift) continue;
    const double left = joint.contrast_ratio * joint.value[static_cast<Eigen::Index>(i)] - taken[a];
    const bool offset = a == kFirstShift;
    const auto& slope = offset ? reference.lsf() : reference.slope(static_cast<std::size_t>(a - kFirstShape));
    const double value = offset ? -left : left;
    for (int b = 0; b < kBins; ++b) {
      const auto at = static_cast<std::size_t>(b), before = at - (b > 0), after = at + (b + 1 < kBins);
      change.esf[at] += value * slope[at];
      change.lsf[at] += value * (slope[after] - slope[before]) /
                        (bins.centre(static_cast<int>(after)) - bins.centre(static_cast<int>(before)));
    }
  }
  for (std::size_t j = 0; j < joint.changes.size(); ++j) {
    const double value = joint.contrast_ratio * joint.value[static_cast<Eigen::Index>(joint.unknowns.size() + j)];
    for (std::size_t b = 0; b < kBins; ++b) {
      const double d = bins.centre(static_cast<int>(b));
      change.esf[b] += value * change_value(joint.changes[j], d);
      change.lsf[b] += value * change_slope(joint.changes[j], d);
    }
  }
  return change;
}

// The splines and the changes of the shape can stand for each other, so that the latter may be far larger than the
// range in which they are linear. A move is therefore at most a factor of two in the Gaussian, half a blur in the
// others.
double trusted_part(const ReferenceShape& shape, const Eigen::Vector3d& step) {
  const double blur_px2 = shape.blur_px2();
  const double most = std::max({std::abs(step[0]) / std::sqrt(blur_px2), 2.0 * std::abs(step[1]) / blur_px2,
                                std::abs(step[2]) / (6.0 * blur_px2)});
  return most > 1.0 ? 1.0 / most : 1.0;
}

}  // namespace

Vector movement(const JointFit& joint, double shift_px) {
  Vector step = Vector::Zero();
  for (std::size_t i = 0; i < joint.unknowns.size(); ++i)
    step[joint.unknowns[i]] = joint.value[static_cast<Eigen::Index>(i)];
  step[kFirstShift] = shift_px;
  return step;
}

StepProfile corrected_profile(const StepProfile& reference, const JointFit& joint, const Vector& taken) {
  const Change change = change_of(reference, joint, taken);
  const DistanceBins& bins = DistanceBins::get();
  StepProfile profile = reference;
  BinRow c2;
  for (std::size_t i = 0; i < kBins; ++i) {
    const std::size_t before = i - (i > 0), after = i + (i + 1 < kBins);
    const double apart = bins.centre(static_cast<int>(after)) - bins.centre(static_cast<int>(before));
    c2[i] = 0.5 * (change.lsf[after] - change.lsf[before]) / apart;
  }
  profile.correct(change.esf, change.lsf, c2);
  return profile;
}

FitState refine(const EdgePixels& pixels, EdgeModel& model, StepProfile& reference, const JointFit& joint,
                const FitSettings& settings) {
  Vector step = movement(joint, EdgeResponse(model, joint).shift_px());
  step.tail<kShapes>() *= trusted_part(model.shape, step.tail<kShapes>());
  const ReferenceShape before = model.shape;
  move(model, step);  // stays within the bounds of the shape
  step.tail<kShapes>() << model.shape.s_px - before.s_px, model.shape.v_px2 - before.v_px2,
      model.shape.q_px2 - before.q_px2;
  FitState next;
  next.profile = corrected_profile(reference, joint, step);
  next.profile.bend_everywhere();
  next.sums = accumulate(pixels, model, next.profile, order_of(settings.unknowns));
  next.noise = noise_of(next.sums, next.profile, settings);
  reference = profile_of(model, settings);
  BinRow change;
  for (std::size_t i = 0; i < kBins; ++i) change[i] = model.contrast() * (reference.esf()[i] - next.profile.esf()[i]);
  next.sums.take_from_residual(change, next.profile);
  next.profile.set_reference(reference);
  assemble(next, model, settings);
  return next;
}

NoiseCorrelation residual_correlation(const EdgePixels& pixels, const CorrectedFit& corrected,
                                      const FitSettings& settings) {
  EdgeModel model = corrected.fit.model;
  StepProfile reference = profile_of(model, settings);
  FitSettings all = settings;
  all.unknowns = with_shading(corrected.fit.unknowns).set(kFirstShape);
  const FitState state = refine(pixels, model, reference, corrected.joint, all);
  return noise_correlation(pixels, model, state, settings.rounding);
}

CorrectedFit correct(const EdgePixels& pixels, EdgeFit fit, const EdgeFacts& facts, FitSettings settings) {
  constexpr int kMostRefinements = 4, kAlways = 2;
  constexpr double kMoved_px = 0.1, kMisfit = 0.2, kLikely = 0.5;
  settings.unknowns = with_shading(fit.unknowns).set(kFirstShape);
  const double extent_px = std::min(facts.extent_dark_px, facts.extent_bright_px);
  const auto solve = [&](const EdgeFit& at, Detail detail) {
    const Unknowns free = without_bounds(settings.unknowns, at.model).set(kFirstShape);
    return solve_jointly(at.state, at.model, free, facts.few_distances() ? Detail::none : detail, facts.width_px,
                         extent_px);
  };
  CorrectedFit best{.fit = std::move(fit), .joint = {}};
  best.fit.state = evaluate(pixels, best.fit.model, settings);
  best.joint = solve(best.fit, Detail::coarse);
  StepProfile reference = best.fit.state.profile;
  for (int i = 0; i < kMostRefinements; ++i) {
    const auto& probability = best.joint.probability;
    const double most = std::max({probability[kReal], probability[kFarLight], probability[kGradient]});
    const bool noise_is_off = probability[kReal] > kLikely && std::abs(best.joint.chi2_per_dof - 1.0) > kMisfit;
    const bool edge_moved =
        probability[kImaginary] > kLikely && std::abs(EdgeResponse(best.fit.model, best.joint).shift_px()) > kMoved_px;
    if (!noise_is_off && !edge_moved && !(most > kLikely && i < kAlways)) break;
    CorrectedFit next = best;
    next.fit.state = refine(pixels, next.fit.model, reference, best.joint, settings);
    next.joint = solve(next.fit, noise_is_off ? Detail::fine : Detail::coarse);
    if (next.misfit() > best.misfit()) break;
    best = std::move(next);
  }
  return best;
}

}  // namespace calib
