// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/measure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "calib/measure/correction/edge_response.h"
#include "calib/measure/correction/esf_correction.h"
#include "calib/measure/edge_facts.h"
#include "calib/measure/edge_figures.h"
#include "calib/measure/edge_fit.h"
#include "calib/measure/edge_terms.h"
#include "calib/measure/region_fit.h"
#include "mtf/error.h"

namespace calib {
namespace {

// The pixels are evaluated again about the corrected edge spread function and at the moved geometry: residuals, noise
// and the line spread are taken there, so that a reference far from the truth (a blur with contrast reversal, a
// sharpened image) is not mistaken for noise and does not turn the edge.

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

/// The step by which a joint fit moves the model; `shift_px`: the location of its response (EdgeResponse).
Vector movement(const JointFit& joint, double shift_px) {
  Vector step = Vector::Zero();
  for (std::size_t i = 0; i < joint.unknowns.size(); ++i)
    step[joint.unknowns[i]] = joint.value[static_cast<Eigen::Index>(i)];
  step[kFirstShift] = shift_px;
  return step;
}

/// The reference step plus the joint fit's changes of shape and its splines, less what moving by `taken` does.
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

/// The state of the model moved by the joint fit, in plateaus, geometry and shape: residuals and noise are those about
/// the corrected step, the equations are about the reference of the new shape, so that solve_jointly() starts over
/// from it. `reference` is that of the model and becomes that of the moved one.
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

/// A fit with the correction of its edge spread function.
struct CorrectedFit {
  EdgeFit fit;
  JointFit joint{};
  /// Variance of the pixels about the model, half way up the step.
  double misfit() const { return joint.chi2_per_dof * fit.state.noise.at(0.5); }
};

/// Of the residuals about the corrected step.
NoiseCorrelation residual_correlation(const EdgePixels& pixels, const CorrectedFit& corrected,
                                      const FitSettings& settings) {
  EdgeModel model = corrected.fit.model;
  StepProfile reference = profile_of(model, settings);
  FitSettings all = settings;
  all.unknowns = with_shading(corrected.fit.unknowns).set(kFirstShape);
  const FitState state = refine(pixels, model, reference, corrected.joint, all);
  return noise_correlation(pixels, model, state, settings.rounding);
}

/// The joint solution, refined as long as that brings the model nearer to the pixels and either residuals and noise
/// disagree or the correction moved the edge.
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

// What the covariance of a fit leaves out: that another shape of the edge would have fitted the pixels as well.

/// Where few distances occur the pixels do not distinguish diffraction, a footprint and a Gaussian, which differ
/// between these distances. Adds the differences from what the result would be with a Gaussian alone, with the
/// footprint of a whole pixel, and with that and diffraction, if these fit, to the standard deviations.
void add_other_shapes(const EdgePixels& pixels, const EdgeFit& fit, const EdgeFacts& facts, FitSettings settings,
                      EdgeMeasurement& measurement) {
  constexpr double kWorse = 9.0;  // chi2
  settings.max_iterations = 8;
  settings.tolerance = 0.3;
  const double variance = fit.model.shape.blur_px2();
  for (const auto& [s_px, q_px2] : {std::array{0.0, 0.0}, {0.0, 1.0}, {0.5 * std::sqrt(variance), 1.0}}) {
    EdgeFit other = fit;
    const double rest_px2 = variance - q_px2 / 12.0 - 0.1 * s_px * s_px;
    other.model.shape = {.s_px = s_px, .v_px2 = std::max(2.0 * kLeastVariance_px2, rest_px2), .q_px2 = q_px2};
    other.unknowns.set(kFirstShape, s_px > 0.0).reset(kFirstShape + 2);
    settings.unknowns = other.unknowns;
    other.state = fit_reference(pixels, other.model, settings);
    if (chi2_of(other.state.sums, fit.state.weight) > fit.state.normal.chi2 + kWorse) continue;
    const JointFit joint = solve_jointly(other.state, other.model, without_bounds(other.unknowns, other.model),
                                         Detail::none, facts.width_px, 0.0);
    EdgeMeasurement described;
    describe(EdgeResponse(other.model, joint), described);
    add_difference(described, measurement);
  }
}

/// Much noise in few pixels leaves errors for which the response is not linear in its shape: an edge that comes out too
/// blurred has too small a standard deviation, as the MTF depends little on a wide blur. The standard deviations become
/// no smaller than those at the upper end of the interval of the MTF at Nyquist, the end being that from which the
/// result lies 1.96 of the deviations there away, and than 1 / 1.96 of the distance of that end.
void add_sharper_end(const EdgePixels& pixels, const CorrectedFit& corrected, const EdgeFacts& facts,
                     FitSettings settings, EdgeMeasurement& measurement) {
  constexpr double kNyquist_cy_px = 0.5;
  constexpr int kRounds = 2;
  const EdgeFit& own = corrected.fit;
  settings.unknowns = own.unknowns;
  const Vector at = movement(corrected.joint, 0.0);
  EdgeModel sharper = own.model;
  JointFit joint = corrected.joint;
  for (int round = 0; round < kRounds; ++round) {
    const std::array<double, kShapes> more = EdgeResponse(sharper, joint).towards_sharper(kNyquist_cy_px);
    Vector step = Vector::Zero();
    for (int k = 0; k < kShapes; ++k) step[kFirstShape + k] = at[kFirstShape + k] + more[static_cast<std::size_t>(k)];
    sharper = own.model;
    move(sharper, step);
    joint =
        solve_jointly(evaluate(pixels, sharper, settings), sharper, own.unknowns, Detail::none, facts.width_px, 0.0);
    joint.value.setZero();  // the response of the sharper model itself
    joint.contrast_ratio = 1.0;
    EdgeMeasurement described;
    describe(EdgeResponse(sharper, joint), described);
    widen_to_end(described, measurement);
  }
}

void check(mtf::ImageView<const float> image, const Roi& roi, const MeasureOptions& options) {
  if (roi.width < 1 || roi.height < 1)
    throw mtf::UsageError("edge: the region is empty: width and height must be at least 1");
  if (roi.x < 0 || roi.y < 0 || roi.width > image.width || roi.height > image.height ||
      roi.x > image.width - roi.width || roi.y > image.height - roi.height)
    throw mtf::UsageError("edge: the region extends beyond the image of " + std::to_string(image.width) + " x " +
                          std::to_string(image.height) + " pixels");
  if (options.order && (*options.order < 1 || *options.order > kHighestOrder))
    throw mtf::UsageError("edge: the order of the curve must be 1 to 5");
  if (options.order && options.circle) throw mtf::UsageError("edge: choose a circle or an order, not both");
  if (options.noise_sd && !(*options.noise_sd > 0.0 && std::isfinite(*options.noise_sd)))
    throw mtf::UsageError("edge: the noise must be above 0");
  if (!(options.quantum >= 0.0 && std::isfinite(options.quantum)))
    throw mtf::UsageError("edge: the step between values must not be negative");
  if (options.saturation && options.floor && !(*options.saturation > *options.floor))
    throw mtf::UsageError("edge: the saturation must be above the floor");
}

// Below the contrast / noise that the search for edges asks for, where few pixels leave an error of 8 %.
bool has_large_errors(const EdgeMeasurement& edge) {
  constexpr double kNoisyCnr = 8.0, kLarge = 0.08;
  return edge.cnr < kNoisyCnr && !(edge.mtf50 && edge.mtf50->sd < kLarge * edge.mtf50->value);
}

EdgeMeasurement refused(EdgeMeasurement known, const Outcome& outcome) {
  known.trouble = outcome.trouble;
  known.reason = outcome.reason;
  return known;
}

}  // namespace

std::string_view trouble_name(Trouble trouble) {
  constexpr std::array kNames{"none",      "no_data",    "no_edge", "several_edges",
                              "too_short", "off_region", "clipped", "contaminated"};
  static_assert(kNames.size() == static_cast<std::size_t>(Trouble::contaminated) + 1);
  return kNames[static_cast<std::size_t>(trouble)];
}

EdgeMeasurement measure_edge(mtf::ImageView<const float> image, const Roi& roi, const MeasureOptions& options) {
  check(image, roi, options);
  RegionFacts region = survey(image, roi, {options.saturation, options.floor});
  EdgeMeasurement known;  // what is known of the region, also without a result
  known.roi = roi;
  known.missing = roi.width * roi.height - region.finite;
  const auto clipped_share = [&region] {
    return region.finite > 0 ? static_cast<double>(region.clipped) / static_cast<double>(region.finite) : 0.0;
  };
  known.clipped_share = clipped_share();
  if (const std::string reason = region.finite == 0 ? why_infinite(image, roi) : ""; !reason.empty())
    return refused(known, {Trouble::no_data, reason});
  if (const Outcome outcome = judge_region(region, roi, options); outcome.refused()) return refused(known, outcome);

  std::optional<EdgeRegion> data = gather_edge(image, roi, region, options);
  if (!data)
    return refused(known, {Trouble::no_edge,
                           "no line divides the region into a dark and a bright side: move the region onto an edge"});
  known.clipped_share = clipped_share();  // with those at limits that the options do not state
  RegionFit fitted = fit_region(*std::move(data), options);
  describe_plateaus(fitted.fit.model, fitted.fit.state.noise, region, known);
  known.oversampling = fitted.facts.oversampling;
  known.ends_abruptly = fitted.facts.ends_abruptly;
  if (const Outcome outcome = judge_edge(fitted.facts); outcome.refused()) return refused(known, outcome);

  CorrectedFit corrected = correct(fitted.pixels, fitted.fit, fitted.facts, fitted.settings);
  const NoiseCorrelation shared = residual_correlation(fitted.pixels, corrected, fitted.settings);
  if (!shared.white()) {
    fit_again(fitted, shared, options);
    corrected = correct(fitted.pixels, fitted.fit, fitted.facts, fitted.settings);
  }
  const auto& [fit, joint] = corrected;
  fitted.facts.plateau_sd = std::sqrt(corrected.misfit());
  fitted.facts.far_light = joint.probability[kFarLight];
  for (const StepChange& change : joint.changes)
    if (change.wide()) fitted.facts.far_reach_px = std::max(fitted.facts.far_reach_px, change.h_px);
  fitted.facts.gradient = joint.probability[kGradient];
  fitted.facts.curvature = joint.probability[kCurvature];
  if (const Outcome outcome = judge_structure(fitted.facts); outcome.refused()) return refused(known, outcome);
  const EdgeResponse response(fit.model, joint);
  describe_plateaus(fit.model, fit.state.noise, region, known);
  EdgeMeasurement out = known;
  describe(response, out);
  fitted.facts.large_errors = has_large_errors(out);
  if (fitted.facts.large_errors) add_sharper_end(fitted.pixels, corrected, fitted.facts, fitted.settings, out);
  if (fitted.facts.few_distances()) add_other_shapes(fitted.pixels, fit, fitted.facts, fitted.settings, out);
  if (const Outcome outcome = judge_response(out); outcome.refused()) return refused(known, outcome);

  EdgeModel found = fit.model;
  move(found, movement(joint, response.shift_px()));
  describe_plateaus(found, fit.state.noise, region, out);
  describe_geometry(found, joint, region, out);
  out.location_sd_px = response.shift_sd_px();
  out.chi2_per_dof = joint.chi2_per_dof;
  fitted.facts.outliers += static_cast<std::size_t>(region.wild);
  out.warnings = warnings_of(fitted.facts, out, options.sparse);
  return out;
}

}  // namespace calib
