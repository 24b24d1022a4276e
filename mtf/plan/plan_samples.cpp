// SPDX-License-Identifier: Apache-2.0

// Plans of an OTF that each sample of a scene has its own of, as defocus by its range (mtf/field/sample_ranges.h),
// along the line of one number c: with H(f; c) ~ P_0(f) + sum of w_k(c) P_k(f) (mtf/field/field_modes.h) and m the mean
// of the scene,
//   out = m + N / D,    N = P_0 * (s - m) + sum of P_k * (w_k (s - m)),    D = 1 + sum of P_k * w_k.
// D is that of the ranges alone, made once. The promise: modes that are left out, or any other error, change N by dN
// and D by dD, and with both as they were used
//   N/D - exact = (dN - (exact - m) dD) / D,    rms <= (rms dN + max |exact - m| rms dD) / min D.
// rms dN and rms dD have the bound of FieldModes, for scenes of s - m and of 1. An exact image leaves the values of its
// scene where the OTF, cut off by the scene's samples, rings: by no more than kOvershoot allows, or the run says so.

#include <algorithm>
#include <cmath>
#include <limits>

#include "mtf/components/field_access.h"
#include "mtf/engines/mean_and_deviation.h"
#include "mtf/error.h"
#include "mtf/field/chebyshev.h"
#include "mtf/field/sample_ranges.h"
#include "mtf/parallel.h"
#include "mtf/plan/plan_impl.h"
#include "mtf/words.h"

namespace mtf {
namespace {

constexpr double kOvershoot = 2.0;      // of the largest deviation of a scene, that its image may have
constexpr double kFirstWeight = 0.3;    // of the sums of weights, before they are known
constexpr double kLeastWeight = 1e-3;   // of these; below, a pixel sees next to nothing that the scene has
constexpr int kMostTurns = 12;          // until the least sum of weights is known
constexpr double kRounded = 0x1.8p-24;  // of a weight and of its product with a sample
constexpr std::int64_t kRowsAtOnce = 16;

void add_to(Image& sum, const Image& part, int threads) {
  parallel_for_each(sum.height(), kRowsAtOnce, threads, [&](std::int64_t y) {
    for (std::int64_t x = 0; x < sum.width(); ++x) sum.at(x, y) += part.at(x, y);
  });
}

/// Of a mode, at each sample.
Image weights_of(const std::vector<double>& series, const std::vector<double>& place, const SampleGrid& in,
                 int threads) {
  Image weights(in.width, in.height);
  parallel_for_each(in.height, kRowsAtOnce, threads, [&](std::int64_t y) {
    for (std::int64_t x = 0; x < in.width; ++x) {
      const double t = place[static_cast<std::size_t>(y * in.width + x)];
      double b1 = 0.0, b2 = 0.0;  // Clenshaw's recurrence
      for (std::size_t i = series.size(); i-- > 1;) b2 = std::exchange(b1, series[i] + 2.0 * t * b1 - b2);
      weights.at(x, y) = static_cast<float>(series[0] + t * b1 - b2);
    }
  });
  return weights;
}

/// What the plan goes by, relative to the scene's std.
struct Budget {
  Budget(const SampleGrid& in, const SampleGrid& out, const PlanOptions& options) : norms(in, out, options) {
    PlanOptions unknown = options;
    unknown.scene.reset();
    const Norms of_ones(in, out, unknown);
    SceneSummary given = options.scene.value_or(SceneSummary{});
    if (!options.scene) given.canvas_norm = of_ones.canvas;
    deviation = given.deviation > 0.0 ? given.deviation : 2.0 * given.largest;
    const double image = kOvershoot * deviation;  // largest |out - m|
    share_of_sums = image / given.std;
    unit = norms.of_any() + share_of_sums * of_ones.of_any();
    scene = {.std = given.std, .largest = deviation, .canvas_norm = given.canvas_norm};
    both = {.std = given.std, .largest = deviation + image, .canvas_norm = given.canvas_norm + image * of_ones.canvas};
    storage = storage_error(options);
  }
  /// Of sums of floats, and of the weights of modes.
  double rounding(const FieldModes& field, std::size_t modes) const {
    double error = (static_cast<double>(modes) + 2.0) * storage;
    for (std::size_t k = 1; k <= modes; ++k) error += kRounded * (field.factor(k)->largest * unit + share_of_sums);
    return error;
  }

  Norms norms;
  double deviation = 1.0, share_of_sums = 1.0, unit = 1.0, storage = 0.0;
  SceneSummary scene, both;  ///< of s - m; of errors of N and of D together
};

/// The modes with which a plan goes, and what they are on the weights alone.
struct Chosen {
  std::shared_ptr<const FieldModes> field{};
  std::vector<Plan> modes{};     ///< without the mean
  std::vector<Image> weights{};  ///< of these, then the sums of weights of the pixels
  double least_weight = 1.0;
};

}  // namespace

System<double> along_line(System<double> mean, std::size_t entry, std::string_view field, double first, double last) {
  const auto fields = mean.list(Stage::presample).at(entry).component.fields();
  std::size_t row = 0;
  while (fields.at(row).info->name != field) ++row;
  const double value = *detail::number_of(fields[row], 0), span = last - first;
  // Two pixels, whose middle is that of the line, and R half the diagonal of both.
  mean.frame.columns = mean.frame.rows = 0;
  mean.field.axis_x_px = (value - 0.5 * (first + last)) / span;
  mean.field.axis_y_px = 0.0;
  FieldNumber<double>& number = mean.field.numbers.emplace_back(FieldNumber<double>{.entry = entry, .field = row});
  number.coefficient[3] = 0.5 * std::sqrt(5.0) * span;
  static_assert(kFieldTerms[3] == "x");
  return mean;
}

Plan compile_over_samples(const SamplesOtf& otf, const SampleGrid& in, const SampleGrid& out,
                          const PlanOptions& options) {
  constexpr std::array stages{Stage::presample};
  const double tolerance = options.tolerance;
  const System<double> mean = otf.line.at({});
  if (!(tolerance > 0.0 && tolerance < 1.0)) return compile_stages(mean, stages, in, out, options, {});  // refused
  if (options.method == Method::field_tiles ||
      (options.method && !is_over_field(options.method) && family(name_of(*options.method)) != Family::fft))
    throw UsageError("method " + std::string(name_of(*options.method)) +
                     " takes one OTF for all samples of a tile; here each has its own: leave --method out");
  const Budget budget(in, out, options);
  const SampleGrid line{2, 1, otf.line.frame.pitch_x_um, otf.line.frame.pitch_x_um};
  const auto field_for = [&](double weight) {
    return std::make_shared<const FieldModes>(
        otf.line, in, line,
        FieldModesOptions{.aperture = options.aperture,
                          .table_error = std::clamp(0.1 * kTableShare * tolerance * weight / budget.unit, 2e-9, 1e-6),
                          .band_error = kBandShare * tolerance * weight / budget.unit,
                          .worst_unit = budget.unit,
                          .part_gain = options.border == Border::reflect ? 0.5 : 1.0,
                          .enough = kEnoughShare * tolerance * weight,
                          .line = true,
                          .threads = options.threads,
                          .progress = options.progress});
  };
  Chosen chosen{.field = field_for(kFirstWeight)};
  FieldReport report{.points = chosen.field->points(), .one_otf_error = chosen.field->error_of_axis()};
  if (report.one_otf_error < tolerance && !is_over_field(options.method)) try {
      Plan plan = compile_stages(mean, stages, in, out, options, {});
      if (plan.report().predicted.total() + report.one_otf_error <= tolerance) {
        auto impl = std::make_shared<Plan::Impl>(*plan.impl_);
        impl->report.field = report;
        impl->report.predicted.modes = report.one_otf_error;
        plan.impl_ = std::move(impl);
        return plan;
      }
    } catch (const UnreachableTolerance&) {  // said below
    }

  PlanOptions own = on_processor(options);
  own.spectrum = nullptr;  // of the scene, not of what its samples weigh
  if (is_over_field(own.method)) own.method.reset();
  const auto refuse = [&](double reachable, const char* why) {
    throw UnreachableTolerance("tolerance " + format_double(tolerance) + " cannot be kept: " + why +
                                   (reachable < 1.0 ? "; use " + significant(reachable, 3) + " or more" : ""),
                               reachable < 1.0 ? reachable : std::numeric_limits<double>::infinity());
  };
  const auto error = [&](std::size_t k) { return chosen.field->error(k) + budget.rounding(*chosen.field, k); };
  const auto reachable = [&](double weight) {  // by modes; other ranges of tolerance may have other weights
    return 1.3 * error(chosen.field->count()) / ((kModesShare - kEnoughShare) * weight);
  };
  const auto compiled = [&](std::size_t k, double share, const SceneSummary& scene, double weight,
                            const Plan::Impl* earlier) {
    own.tolerance = share * tolerance * weight;
    own.scene = scene;
    try {
      return compile_stages(mean, stages, in, out, own,
                            {.earlier = earlier, .mode = chosen.field->factor(k), .dc = k == 0 ? 1.0 : 0.0});
    } catch (const UnreachableTolerance& e) {
      const double by_arithmetic = 1.3 * e.reachable() / own.tolerance * tolerance;
      if (k > 0 && !(std::max(by_arithmetic, reachable(weight)) < 1.0))
        refuse(1.0,
               "the OTF changes by too much from sample to sample for modes in float32; use ranges that change less or "
               "are nearer the focus, or a smaller aperture");
      throw unreachable_tolerance(tolerance, std::min(1.0, std::max(by_arithmetic, reachable(weight))), options.scene);
    }
  };
  // As many modes as are enough where the least sum of weights is `weight`; false where it is less, and then that.
  const auto choose = [&](double& weight) {
    const FieldModes& field = *chosen.field;
    double moduli = 0.0;  // what each mode may err by is shared out by them
    for (std::size_t k = 1; k <= field.count(); ++k) moduli += field.factor(k)->largest;
    Image sums(out.width, out.height), part(out.width, out.height);
    std::fill_n(sums.data(), sums.size(), 1.0F);
    chosen.modes.clear();
    chosen.weights.clear();
    const auto least = [&] { return static_cast<double>(*std::min_element(sums.data(), sums.data() + sums.size())); };
    for (std::size_t k = 0; error(k) > kModesShare * tolerance * weight;) {
      if (k++ == field.count()) {
        if (0.9 * least() > 1.1 * weight) {  // there is more room than was thought
          weight = 0.9 * least();
          return false;
        }
        refuse(reachable(weight), "the OTF changes more sharply from sample to sample than its modes can follow");
      }
      require_memory(4.0 * static_cast<double>(in.width * in.height), out);
      const Image& weights = chosen.weights.emplace_back(weights_of(field.series(k), otf.place, in, options.threads));
      chosen.modes.push_back(compiled(k, (1.0 - kModesShare - kMeanShare) * field.factor(k)->largest / moduli,
                                      budget.both, weight, k == 1 ? nullptr : chosen.modes.back().impl_.get()));
      chosen.modes.back().run(weights.view(), part.view(), 0.0, options.threads);
      add_to(sums, part, options.threads);
    }
    chosen.least_weight = least();
    chosen.weights.push_back(std::move(sums));
    if (chosen.least_weight >= weight) return true;
    weight = std::max(0.8 * chosen.least_weight, 0.1 * weight);  // a sum of few modes may be off
    return false;
  };
  int turns = 0;
  for (double weight = kFirstWeight; !choose(weight);) {
    if (++turns == kMostTurns)
      refuse(reachable(weight), "the least sum of weights differs from one number of modes to the next");
    if (!(weight > kLeastWeight))
      refuse(std::numeric_limits<double>::infinity(),
             "some pixels receive less than a thousandth of the light that they would in a scene of one range, as "
             "what they should show is spread widely and light of what it hides is not in the scene; use ranges "
             "nearer the focus or a smaller aperture");
    chosen.field = field_for(weight);
  }

  const FieldModes& field = *chosen.field;
  const std::size_t count = chosen.modes.size();
  auto impl = std::make_shared<Plan::Impl>();
  impl->system = mean;
  impl->stages.assign(stages.begin(), stages.end());
  impl->options = options;
  impl->options.progress = {};
  impl->field = chosen.field;
  impl->modes.push_back(compiled(0, kMeanShare, budget.scene, chosen.least_weight,
                                 count > 0 ? chosen.modes.back().impl_.get() : nullptr));
  PlanReport total = impl->modes.front().report();
  PredictedError errors;
  add(errors, total.predicted);
  for (Plan& mode : chosen.modes) {
    add(errors, mode.report().predicted);
    total.otf_bytes += mode.report().otf_bytes;
    total.run_bytes = std::max(total.run_bytes, mode.report().run_bytes);
    impl->cost_ms += mode.impl_->cost_ms;
    impl->modes.push_back(std::move(mode));
  }
  errors.modes = field.error(count);
  errors.arithmetic += budget.rounding(field, count);
  total.predicted = {};
  add(total.predicted, errors, 1.0 / chosen.least_weight);
  total.run_bytes += 4 * (in.width * in.height * static_cast<std::int64_t>(count + 2) + 2 * out.width * out.height);
  impl->cost_ms += impl->modes.front().impl_->cost_ms;
  total.method = name_of(Method::field_modes);
  for (Candidate& candidate : total.candidates) candidate.reason = "one OTF does not keep the tolerance";
  total.candidates.push_back({.method = Method::field_modes,
                              .detail = "the mean OTF and " + plural(static_cast<std::int64_t>(count), "mode"),
                              .predicted = total.predicted,
                              .cost_ms = impl->cost_ms,
                              .bytes = total.otf_bytes + total.run_bytes,
                              .possible = true,
                              .reason = {}});
  total.tolerance = tolerance;
  report.points = field.points();
  report.modes = count;
  report.ranges = FieldReport::Ranges{.least_weight = chosen.least_weight};
  total.field = report;
  impl->report = std::move(total);
  impl->weights = std::make_shared<const std::vector<Image>>(std::move(chosen.weights));
  Plan plan;
  plan.impl_ = std::move(impl);
  return plan;
}

Plan compile_over_range(const System<double>& system, const SampleGrid& in, const SampleGrid& out,
                        const PlanOptions& options) {
  const std::size_t entry = *entry_by_range(system);
  const std::string key = "presample[" + std::to_string(entry) + "].focus";
  if (!options.range_m)
    throw UsageError(key +
                     ": the defocus is that of the range of each sample of a scene, which mtf simulate of one "
                     "image takes from the channel Z of its file; here there is none: give waves or distance in "
                     "its place");
  require_isoplanatic(system, key + ": defocus by range");
  if (options.border == Border::constant)
    throw UsageError(key + ": a constant border has no range; use border = \"reflect\"");
  require_memory(8.0 * static_cast<double>(in.width * in.height), out);
  SampleRanges ranges = sample_ranges(system, in, out, options.range_m->view());
  const double first = distance_at_um(system, ranges.least), last = distance_at_um(system, ranges.most);
  constexpr double kMost_um = 1e6;  // of the key distance
  const bool near = std::abs(last) >= std::abs(first);
  if (!(std::abs(near ? last : first) <= kMost_um))
    throw UsageError(key + ": at a range of " + significant(1.0 / (near ? ranges.most : ranges.least), 3) +
                     " m the image lies " + significant(1e-6 * std::abs(near ? last : first), 3) + " m " +
                     (near ? "behind" : "before") +
                     " the image plane, where 1 m is the most; check focus and channel Z");
  const System<double> mean = with_distance(system, distance_at_um(system, ranges.mean));
  const bool one = !(first < last);
  Plan plan;
  if (one) {
    PlanOptions plain = options;
    plain.range_m.reset();
    plan = compile(mean, in, out, plain);
  } else {
    SamplesOtf otf{along_line(mean, entry, "distance", first, last)};
    otf.place = std::move(ranges.per_m);
    for (double& place : otf.place)
      place = std::clamp((2.0 * place - ranges.least - ranges.most) / (ranges.most - ranges.least), -1.0, 1.0);
    plan = compile_over_samples(otf, in, out, options);
  }
  auto impl = std::make_shared<Plan::Impl>(*plan.impl_);
  impl->options = options;
  impl->options.progress = {};
  FieldReport& report = impl->report.field;
  report.points = std::max<std::size_t>(report.points, 1);
  if (!report.ranges) report.ranges = FieldReport::Ranges{};
  report.ranges->nearest_m = 1.0 / ranges.most, report.ranges->farthest_m = 1.0 / ranges.least;
  plan.impl_ = std::move(impl);
  return plan;
}

void Plan::run_samples(ImageView<const float> in, ImageView<float> out, int threads) const {
  UniformRuns flat;
  const MeanAndDeviation about = mean_and_deviation(in, threads, flat);
  const auto filled = [&](const auto& value) {
    parallel_for_each(out.height, kRowsAtOnce, threads, [&](std::int64_t y) {
      for (std::int64_t x = 0; x < out.width; ++x) out.at(x, y) = static_cast<float>(value(x, y));
    });
  };
  if (about.deviation == 0.0) return filled([&](std::int64_t, std::int64_t) { return about.mean; });
  const double scale = scale_for(about.deviation);
  Image scene(in.width, in.height), weighted(in.width, in.height), sum(out.width, out.height),
      part(out.width, out.height);
  parallel_for_each(in.height, kRowsAtOnce, threads, [&](std::int64_t y) {
    for (std::int64_t x = 0; x < in.width; ++x)
      scene.at(x, y) = static_cast<float>(scale * (static_cast<double>(in.at(x, y)) - about.mean));
  });
  const std::vector<Image>& weights = *impl_->weights;
  const Image& sums = weights.back();
  impl_->modes.front().run(scene.view(), sum.view(), 0.0, threads);
  for (std::size_t k = 1; k < impl_->modes.size(); ++k) {
    parallel_for_each(in.height, kRowsAtOnce, threads, [&](std::int64_t y) {
      for (std::int64_t x = 0; x < in.width; ++x) weighted.at(x, y) = weights[k - 1].at(x, y) * scene.at(x, y);
    });
    impl_->modes[k].run(weighted.view(), part.view(), 0.0, threads);
    add_to(sum, part, threads);
  }
  const double most = kOvershoot * scale * about.deviation;
  for (std::int64_t i = 0; i < sum.size(); ++i) {
    sum.data()[i] /= sums.data()[i];
    if (!(std::abs(static_cast<double>(sum.data()[i])) <= most))
      throw UsageError("the image rings beyond " + format_double(kOvershoot) +
                       " times the contrast of the scene where little light arrives from its own range, and the "
                       "promised error is not kept; give the scene more samples a pitch");
  }
  filled([&](std::int64_t x, std::int64_t y) { return about.mean + static_cast<double>(sum.at(x, y)) / scale; });
}

}  // namespace mtf
