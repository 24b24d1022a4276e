// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/measure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "calib/measure/correction/edge_response.h"
#include "calib/measure/correction/esf_correction.h"
#include "calib/measure/edge_figures.h"
#include "calib/measure/edge_outcome.h"
#include "calib/measure/edge_terms.h"
#include "calib/measure/esf_refine.h"
#include "calib/measure/region_fit.h"
#include "mtf/error.h"

namespace calib {
namespace {

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
