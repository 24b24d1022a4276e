// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/esf_refine.h"

#include <algorithm>
#include <cmath>

#include "calib/measure/correction/edge_response.h"
#include "calib/measure/edge_fit.h"
#include "calib/measure/edge_terms.h"

namespace calib {
namespace {

// Noise that neighbouring pixels share, as after demosaicing, denoising, resampling or JPEG. Its autocorrelation is
// that of the residuals of the flat sides, where the model has no structure of its own.

constexpr std::size_t kEnough = 1U << 18;  // pixels: their rows bound the memory of the grid

// Residuals of the flat sides in units of their standard deviation.
PixelGrid grid_of(const EdgePixels& pixels, const EdgeModel& model, const FitState& state) {
  const std::size_t size = std::min(pixels.size(), kEnough);
  const PixelResiduals all = residuals_of(pixels, model, state.profile);
  const auto [left, right] = std::minmax_element(pixels.x(), pixels.x() + size);
  const auto [top, bottom] = std::minmax_element(pixels.y(), pixels.y() + size);
  PixelGrid grid(static_cast<std::size_t>(std::lround(*right - *left)) + 1,
                 static_cast<std::size_t>(std::lround(*bottom - *top)) + 1);
  const double from_px = 2.0 / std::max(1e-3, state.profile.lsf()[kSideBins]);
  BinRow per_sd = variances(state.noise, state.profile);
  for (int b = 0; b < kBins; ++b) {
    double& one = per_sd[static_cast<std::size_t>(b)];
    one = std::abs(DistanceBins::get().centre(b)) < from_px ? 0.0 : 1.0 / std::sqrt(one);
  }
  for (std::size_t i = 0; i < size; ++i) {
    const auto column = static_cast<std::size_t>(pixels.x()[i] - *left + 0.5),
               row = static_cast<std::size_t>(pixels.y()[i] - *top + 0.5);
    const auto bin = static_cast<std::size_t>(all.bin[i]);
    if (bin < kBins && per_sd[bin] > 0.0)
      grid.set(column, row, all.residual[i] * per_sd[bin]);
    else
      grid.set(column, row);
  }
  return grid;
}

// The lags of whole columns and rows: at most kMost of each, evenly spaced, for all.
void add_lines(const PixelGrid& grid, int rings, NoiseCorrelation& noise) {
  constexpr int kMost = 64;
  for (const bool columns : {true, false}) {
    const double shared = columns ? noise.columns : noise.rows;
    if (shared == 0.0) continue;
    const auto length = static_cast<int>(columns ? grid.rows() : grid.columns()), step = 1 + (length - 1) / kMost;
    for (int k = rings + (step + 1) / 2; k < length; k += step)
      noise.lags.push_back({.x = columns ? 0 : k,
                            .y = columns ? k : 0,
                            .correlation = shared * step,
                            .share = 1.0 - static_cast<double>(k) / length});
  }
}

/// The correlation of the residuals of a fitted model; without lags for independent pixels, or rounding.
NoiseCorrelation noise_correlation(const EdgePixels& pixels, const EdgeModel& model, const FitState& state,
                                   const Rounding& rounding) {
  const bool rounded = state.noise.dark < kRoundsAlike_steps2 * rounding.dark * rounding.dark ||
                       state.noise.bright < kRoundsAlike_steps2 * rounding.bright * rounding.bright;
  if (pixels.size() == 0 || rounded) return {};
  const PixelGrid grid = grid_of(pixels, model, state);
  const Point normal = model.curve.normal();
  const PixelCorrelation near = correlation_of(grid, normal);
  NoiseCorrelation noise = noise_correlation(near, grid.count(), static_cast<double>(pixels.size()));
  for (PixelLag& lag : noise.lags)
    lag.share = grid.pixel_pairs(lag.x, lag.y) / static_cast<double>(std::min(pixels.size(), kEnough));
  noise.columns = shared_in_lines(grid, normal, true, near.rings);
  noise.rows = shared_in_lines(grid, normal, false, near.rings);
  add_lines(grid, near.rings, noise);
  return noise;
}

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
  CorrectedFit best{.fit = std::move(fit)};
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
