// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/measure.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/measure/edge_bin_fit.h"
#include "calib/measure/edge_figures.h"
#include "calib/measure/edge_outcome.h"
#include "calib/measure/edge_start.h"
#include "calib/measure/edge_terms.h"
#include "calib/measure/esf_refine.h"
#include "mtf/error.h"

namespace calib {
namespace {

void check(mtf::ImageView<const float> image, const Roi& roi, const MeasureOptions& options) {
  if (roi.width < 1 || roi.height < 1)
    throw mtf::UsageError("edge: the region is empty: width and height must be at least 1");
  if (roi.x < 0 || roi.y < 0 || roi.width > image.width || roi.height > image.height ||
      roi.x > image.width - roi.width || roi.y > image.height - roi.height)
    throw mtf::UsageError("edge: the region reaches outside the image of " + std::to_string(image.width) + " x " +
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

// The shape to start from: half of a Gaussian's variance is taken for a footprint, some of the rest for diffraction.
void split_blur(ReferenceShape& shape) {
  const double variance = shape.v_px2;
  shape.q_px2 = std::min(1.0, 6.0 * variance);
  shape.v_px2 = std::max(2.0 * kLeastVariance_px2, variance - shape.q_px2 / 12.0);
  shape.s_px = 0.3 * std::sqrt(variance);
}

// Blocks of a large region know the place of the edge to a fraction of a block: a Gaussian step, from a blur as wide as
// that, leads to the pixels.
constexpr std::int64_t kFineBlocks_px = 4;
void sharpen_start(const EdgePixels& pixels, EdgeModel& start, double block_px, FitRounds rounds) {
  constexpr std::size_t kSome = 6000;
  start.shape.v_px2 = std::min(0.1 * block_px * block_px, 200.0);
  rounds.unknowns = basic_unknowns();
  rounds.unknowns.reset(kFirstShape).reset(kFirstShape + 2);
  rounds.rounds = 40;
  rounds.enough = 3.0;
  rounds.step = step_for(pixels, kSome);
  rounds.least_variance = std::max(rounds.least_variance, 1e-4);
  fit_reference(pixels, start, rounds);
}

constexpr double kLeastReach_px = 8.0, kLeastWidths = 5.0;  // how near uneven light may bring the pixels' reach

struct Fit {
  EdgeModel model;
  FitState state;
  Unknowns unknowns;
};

// From the state of all pixels at a model near the best one to that at the best one. What is nearly linear is done on
// sums by distance; the pixels are looked at again only where these do not tell what would be seen.
void settle(const EdgePixels& pixels, Fit& fit, FitRounds rounds) {
  rounds.unknowns = fit.unknowns;
  rounds.rounds = 8;
  EdgeModel model = fit.model;
  const auto drop_diffraction = [&] {
    fit.unknowns.reset(kFirstShape);
    rounds.unknowns = fit.unknowns;
    model.shape.v_px2 += 0.1 * model.shape.s_px * model.shape.s_px;
    model.shape.s_px = 0.0;
  };
  const bool likely = shows_diffraction(fit.state, model, fit.unknowns);
  if (!likely) drop_diffraction();
  FitState near = fit_on_bins(fit.state, fit.model, model, rounds);
  if (likely && !shows_diffraction(near, model, fit.unknowns)) {
    drop_diffraction();
    near = fit_on_bins(fit.state, fit.model, model, rounds);
  }
  if (near.converged) {
    // By its own noise: that of a look from far off is too large, and ends a fit early.
    FitState there = near;
    there.noise = noise_of(near.sums, near.profile, rounds);
    assemble(there, model, rounds);
    FitRounds one = rounds;
    one.rounds = 1;
    EdgeModel next = model;
    there = fit_on_bins(there, model, next, one);
    if (there.converged && predicts_convergence(fit.model, there, model, rounds.enough)) {
      fit.model = model;
      fit.state = std::move(there);
      return;
    }
  }
  if (near.left > rounds.enough) rounds.enough += near.left;  // steps that come to nothing on bins need no other try
  rounds.rounds = 5;
  fit.model = model;
  fit.state = fit_reference(pixels, fit.model, rounds);
}

// From the start to the best reference: first on some of the pixels, then on all.
Fit fit_edge(const EdgePixels& pixels, EdgeModel start, FitRounds rounds, const MeasureOptions& options,
             double reach_px) {
  constexpr std::size_t kSome = 2000;
  const std::size_t step = step_for(pixels, kSome);
  Fit fit{.model = std::move(start), .state = {}, .unknowns = basic_unknowns()};
  split_blur(fit.model.shape);
  const auto refine = [&](std::size_t every, int most_rounds, double enough) {
    rounds.unknowns = fit.unknowns;
    rounds.step = every;
    rounds.rounds = most_rounds;
    rounds.enough = enough;
    return fit_reference(pixels, fit.model, rounds);
  };
  constexpr double kRough = 4.0;  // less than what other pixels change
  constexpr double kFar = 1.3;
  const auto bend_by = [&](int order) {
    fit.unknowns = with_order(fit.unknowns, order);
    set_order(fit.model.curve, order, options.circle);
    return refine(step, 12, kRough);
  };
  // A bend that some of the pixels show is taken out first, if it is most of what keeps them from the model.
  int order = 1;
  if (const FitState some = refine(step, 25, kRough);
      options.order != 1 && some.normal.chi2 > kFar * some.normal.count) {
    const Fit straight = fit;
    const FitState bent = bend_by(2);
    const double misfit = bent.normal.chi2 * bent.noise.at(0.5) / some.noise.at(0.5);
    order = misfit < 0.5 * some.normal.chi2 ? 2 : 1;
    if (order == 1) fit = straight;
  }

  rounds.step = 1;
  rounds.unknowns = with_gradients(with_order(fit.unknowns, kHighestOrder));
  fit.state = evaluate(pixels, fit.model, rounds);
  const Terms terms = choose_terms(fit.state, fit.model, reach_px, options, order);
  if (terms.gradients) fit.unknowns = with_gradients(fit.unknowns);
  if (terms.gradients || terms.order > order) {
    bend_by(terms.order);
    rounds.step = 1;
    rounds.unknowns = fit.unknowns;
    fit.state = evaluate(pixels, fit.model, rounds);
  }
  fit.state.sums = fit.state.sums.up_to(2 * order_of(fit.unknowns));
  rounds.enough = 0.3;
  settle(pixels, fit, rounds);
  return fit;
}

// The pixels within a distance of the curve.
EdgePixels within(const EdgePixels& pixels, const EdgeCurve& curve, double reach_px) {
  EdgePixels near(pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Point at{pixels.x()[i], pixels.y()[i]};
    if (std::abs(locate(curve, at).distance_px) <= reach_px) near.add(pixels.x()[i], pixels.y()[i], pixels.value()[i]);
  }
  return near;
}

// Where few distances occur the pixels do not tell diffraction, a footprint and a Gaussian from each other, and which
// of them it is decides between the distances: what the result would be with a Gaussian alone, with the footprint of a
// whole pixel, and with that and diffraction, if these fit, is part of its standard deviation.
void hold_shapes(const Fit& fit, const FitRounds& fitted, const EdgeFacts& facts, EdgeMeasurement& out) {
  constexpr double kWorse = 9.0;  // chi2
  const double variance = fit.model.shape.blur_px2();
  for (const auto& [s_px, q_px2] : {std::array{0.0, 0.0}, {0.0, 1.0}, {0.5 * std::sqrt(variance), 1.0}}) {
    Fit other = fit;
    const double rest_px2 = variance - q_px2 / 12.0 - 0.1 * s_px * s_px;
    other.model.shape = {.s_px = s_px, .v_px2 = std::max(2.0 * kLeastVariance_px2, rest_px2), .q_px2 = q_px2};
    other.unknowns.set(kFirstShape, s_px > 0.0).reset(kFirstShape + 2);
    FitRounds rounds = fitted;
    rounds.unknowns = other.unknowns;
    rounds.rounds = 12;
    rounds.enough = 0.1;
    other.state = fit_on_bins(fit.state, fit.model, other.model, rounds);
    if (other.state.normal.chi2 > fit.state.normal.chi2 + kWorse) continue;
    const JointFit joint = solve_jointly(other.state, other.model, without_bounds(other.unknowns, other.model),
                                         Detail::none, facts.width_px, kLeastReach_px);
    EdgeMeasurement described;
    describe(EdgeResponse(other.model, joint), described);
    hold_difference(described, out);
  }
}

// Variance of the pixels about the model at mid level.
double misfit(const JointFit& joint, const FitState& state) { return joint.chi2_per_dof * state.noise.at(0.5); }

double sagitta(const EdgeCurve& curve) {
  constexpr int kSteps = 64;
  const double half = curve.half_length_px;
  if (curve.shape == EdgeCurve::Shape::circle) {
    const double k = curve.curvature_per_px * half;
    return std::abs(k) >= 1.0 ? 1.0 / std::abs(curve.curvature_per_px)
                              : half * std::abs(k) / (1.0 + std::sqrt(1.0 - k * k));
  }
  const auto height = [&](double t) {
    double g = 0.0;
    for (auto k = curve.coefficient.size(); k-- > 0;) g = g * t + curve.coefficient[k];
    return g * t * t;
  };
  double most = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = 2.0 * i / kSteps - 1.0;
    most = std::max(most, std::abs(height(t) - 0.5 * (height(1.0) * (1.0 + t) + height(-1.0) * (1.0 - t))));
  }
  return most;
}

void geometry(const EdgeModel& model, const JointFit& joint, const RegionFacts& facts, EdgeMeasurement& out) {
  out.curve = model.curve;
  out.curve.origin.x += facts.middle.x;
  out.curve.origin.y += facts.middle.y;
  out.length_px = 2.0 * model.curve.half_length_px;
  out.sagitta_px = sagitta(model.curve);
  double angle_deg = std::remainder(model.curve.angle_rad * 180.0 / std::numbers::pi, 180.0);
  if (angle_deg <= -90.0) angle_deg += 180.0;
  out.angle_deg.value = angle_deg;
  for (std::size_t i = 0; i < joint.unknowns.size(); ++i) {
    if (joint.unknowns[i] != kFirstShift + 1) continue;
    const auto at = static_cast<Eigen::Index>(i);
    out.angle_deg.sd =
        std::sqrt(std::max(0.0, joint.covariance(at, at))) / model.curve.half_length_px * 180.0 / std::numbers::pi;
  }
}

void levels(const EdgeModel& model, const NoiseModel& noise, const RegionFacts& facts, EdgeMeasurement& out) {
  out.dark = facts.offset + facts.scale * model.level[0];
  out.bright = facts.offset + facts.scale * model.level[1];
  out.noise_sd = facts.scale * std::sqrt(noise.at(0.5));
  if (noise.bright != noise.dark)
    out.noise_gain = facts.scale * (noise.bright - noise.dark) / std::max(1e-300, model.contrast());
  out.cnr = (out.bright - out.dark) / out.noise_sd;
}

}  // namespace

std::string_view trouble_name(Trouble trouble) {
  switch (trouble) {
    case Trouble::none:
      return "none";
    case Trouble::no_data:
      return "no_data";
    case Trouble::no_edge:
      return "no_edge";
    case Trouble::several_edges:
      return "several_edges";
    case Trouble::too_short:
      return "too_short";
    case Trouble::off_region:
      return "off_region";
    case Trouble::clipped:
      return "clipped";
    case Trouble::contaminated:
      return "contaminated";
  }
  return "unknown";
}

EdgeMeasurement measure_edge(mtf::ImageView<const float> image, const Roi& roi, const MeasureOptions& options) {
  check(image, roi, options);
  EdgeMeasurement out;
  out.roi = roi;
  const auto stop = [&out](const Outcome& outcome) {
    out.trouble = outcome.trouble;
    out.reason = outcome.reason;
    return outcome.trouble != Trouble::none;
  };
  const ValueLimits limits{options.saturation, options.floor};
  const RegionFacts region = survey(image, roi, limits);
  out.missing = roi.width * roi.height - region.finite;
  if (region.finite > 0) out.clipped_share = static_cast<double>(region.clipped) / static_cast<double>(region.finite);
  if (stop(judge_region(region, roi, options))) return out;
  const auto wild = static_cast<std::size_t>(region.wild);

  const auto width = static_cast<double>(roi.width), height = static_cast<double>(roi.height);
  std::int64_t block_px = 1;
  const EdgePixels blocks = gather_blocks(image, roi, region, limits, block_px);
  EdgeModel start = start_edge(blocks, static_cast<double>(block_px), width, height);
  if (!(start.curve.half_length_px > 0.0)) {
    stop({Trouble::no_edge, "no line divides the region into a dark and a bright side: move the region onto an edge"});
    return out;
  }
  EdgePixels pixels = gather_pixels(image, roi, region, limits, start.curve, kReach_px);
  FitRounds rounds;
  const auto step_at = [&](double level) {
    const double at = region.offset + region.scale * level;
    const double step = options.quantum_at ? options.quantum_at(at) : options.quantum;
    return std::isfinite(step) ? std::max(0.0, step) / region.scale : 0.0;
  };
  rounds.rounding = {step_at(start.level[0]), step_at(start.level[1])};
  if (options.noise_sd) {
    const double sd = *options.noise_sd / region.scale;
    constexpr double kMost = 1e3;  // of the range of values: no edge is seen in it
    const double step = std::max(rounds.rounding.dark, rounds.rounding.bright);
    rounds.variance = std::max({rounds.least_variance, step * step / 12.0, std::min(sd, kMost) * std::min(sd, kMost)});
  }
  const double reach_px = 0.5 * static_cast<double>(pixels.size()) / (2.0 * start.curve.half_length_px);
  if (block_px > kFineBlocks_px) sharpen_start(pixels, start, static_cast<double>(block_px), rounds);
  const double local_noise_sd = local_noise(image, roi, region);
  Fit fit = fit_edge(pixels, start, rounds, options, reach_px);
  EdgeFacts facts = facts_of(pixels, fit.state, fit.model, local_noise_sd);
  if (suspects_outliers(facts)) {
    if (const std::size_t removed = remove_outliers(pixels, fit.model, fit.state.profile, facts); removed > 0) {
      fit = fit_edge(pixels, start, rounds, options, reach_px);
      facts = facts_of(pixels, fit.state, fit.model, local_noise_sd);
      facts.outliers = removed;
    }
  }
  // Where the levels bend, only pixels so near the edge that a straight line follows them are taken.
  const auto reach_of = [](const EdgeFacts& one) { return std::min(one.reach_dark_px, one.reach_bright_px); };
  const auto bends = [&] { return levels_bend(fit.state, fit.model, facts.width_px, reach_of(facts)); };
  double narrowed_px = reach_of(facts);
  for (facts.levels_bend = bends(); facts.levels_bend;) {
    narrowed_px *= 0.6;
    if (narrowed_px < std::max(kLeastReach_px, kLeastWidths * facts.width_px)) break;
    pixels = within(pixels, fit.model.curve, narrowed_px);
    fit = fit_edge(pixels, start, rounds, options, narrowed_px);
    const std::size_t outliers = facts.outliers;
    facts = facts_of(pixels, fit.state, fit.model, local_noise_sd);
    facts.outliers = outliers;
    facts.narrowed_px = narrowed_px;
    facts.levels_bend = bends();
  }
  levels(fit.model, fit.state.noise, region, out);
  out.oversampling = facts.oversampling;
  if (stop(judge_edge(facts))) return out;

  constexpr double kFewestDistances = 3.0;
  const auto solve = [&](Detail detail) {
    if (facts.oversampling < kFewestDistances) detail = Detail::none;
    return solve_jointly(fit.state, fit.model, without_bounds(fit.unknowns, fit.model), detail, facts.width_px,
                         std::min(facts.reach_dark_px, facts.reach_bright_px));
  };
  JointFit joint = solve(Detail::coarse);
  rounds.unknowns = fit.unknowns;
  rounds.step = 1;
  StepProfile reference = fit.state.profile;
  constexpr int kLooks = 4;
  constexpr double kFar_px = 0.1;
  const auto mistook = [](double chi2_per_dof) { return std::abs(chi2_per_dof - 1.0) > 0.2; };
  const auto moved_far = [&fit](const JointFit& one) {
    return one.tau_even > 0.0 && std::abs(EdgeResponse(fit.model, one).shift_px()) > kFar_px;
  };
  for (int look = 0; look < kLooks && joint.tau_odd + joint.tau_even > 0.0; ++look) {
    const bool fine = mistook(joint.chi2_per_dof);
    if (!fine && !moved_far(joint)) break;
    Fit before = fit;
    const JointFit earlier = joint;
    fit.state = refine(pixels, fit.model, reference, joint, rounds);
    joint = solve(fine ? Detail::fine : Detail::coarse);
    if (misfit(joint, fit.state) <= misfit(earlier, before.state)) continue;
    fit = std::move(before);
    joint = earlier;
    break;
  }
  const EdgeResponse response(fit.model, joint);
  describe(response, out);
  if (facts.oversampling < kFewestDistances) hold_shapes(fit, rounds, facts, out);
  if (const Outcome outcome = judge_response(out); outcome.trouble != Trouble::none) {
    EdgeMeasurement refused;
    refused.roi = roi;
    refused.clipped_share = out.clipped_share;
    refused.missing = out.missing;
    refused.oversampling = out.oversampling;
    levels(fit.model, fit.state.noise, region, refused);
    refused.trouble = outcome.trouble;
    refused.reason = outcome.reason;
    return refused;
  }
  move(fit.model, movement(joint, response.shift_px()));
  levels(fit.model, fit.state.noise, region, out);
  geometry(fit.model, joint, region, out);
  out.chi2_per_dof = joint.chi2_per_dof;
  facts.outliers += wild;
  facts.missing = options.sparse ? 0 : out.missing;
  warn(facts, out);
  return out;
}

}  // namespace calib
