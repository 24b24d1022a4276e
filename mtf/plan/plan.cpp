// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan/plan.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mtf/engines/row_moments.h"
#include "mtf/error.h"
#include "mtf/plan/plan_impl.h"
#include "mtf/plan/plan_parts.h"

namespace mtf {
namespace {

constexpr std::int64_t kLargestSide = std::int64_t{1} << 29;
constexpr double kLargestImage = 2147483648.0;  // samples

void check_grid(const SampleGrid& grid, const char* name) {
  const auto fail = [&](const std::string& what) { throw UsageError(std::string(name) + " grid: " + what); };
  if (grid.width < 1 || grid.height < 1) fail("empty");
  if (grid.width > kLargestSide || grid.height > kLargestSide) fail("a side above 2^29 samples; cut the scene");
  for (const double step : {grid.step_x_um, grid.step_y_um})
    if (!(step > 0.0 && step < 1e12)) fail("sample step " + format_double(step) + " um is outside (0, 1e12)");
  const double samples = static_cast<double>(grid.width) * static_cast<double>(grid.height);
  if (samples > kLargestImage)
    fail(format_double(samples) +
         " samples, above 2^31; check scene.sample and frame.pitch, set frame.format, or cut the scene");
}

double whole_pitches(std::int64_t n, double step, double pitch) {
  return std::floor(static_cast<double>(n) * step / pitch + kWholeEpsilon);
}

}  // namespace

SampleGrid detector_grid(const System<double>& system, const SampleGrid& scene) {
  check_grid(scene, "scene");
  const auto side = [](std::int64_t n, double step, double pitch, int format, const char* name) {
    const double whole = whole_pitches(n, step, pitch);
    if (whole < 1.0)
      throw UsageError(std::string("the scene is smaller than one detector pixel along ") + name + ": " +
                       std::to_string(n) + " samples of " + format_double(step) + " um, pitch " + format_double(pitch) +
                       " um; check scene.sample and frame.pitch");
    if (whole > static_cast<double>(kLargestSide))
      throw UsageError("the scene holds " + format_double(whole) + " pitches along " + name +
                       "; check scene.sample and frame.pitch, or set frame.format");
    const auto count = static_cast<std::int64_t>(whole);
    return format > 0 ? std::min<std::int64_t>(count, format) : count;
  };
  const Frame<double>& frame = system.frame;
  return {side(scene.width, scene.step_x_um, frame.pitch_x_um, frame.columns, "x"),
          side(scene.height, scene.step_y_um, frame.pitch_y_um, frame.rows, "y"), frame.pitch_x_um, frame.pitch_y_um};
}

namespace {

// The share of the columns that lie in groups whose columns are all uniform.
double flat_columns(ImageView<const float> scene) {
  constexpr std::int64_t kGroup = UniformRuns::kGroup;
  const float* first = scene.row(0);
  std::vector<std::int64_t> groups;  // that are flat so far
  for (std::int64_t x = 0; x + kGroup <= scene.width; x += kGroup) groups.push_back(x);
  for (std::int64_t y = 0; y < scene.height && !groups.empty(); ++y)
    std::erase_if(groups, [row = scene.row(y), first](std::int64_t x) {
      return !std::all_of(row + x, row + x + kGroup, [value = first[x]](float v) { return v == value; });
    });
  return static_cast<double>(groups.size()) * static_cast<double>(kGroup) / static_cast<double>(scene.width);
}

}  // namespace

std::optional<SceneSummary> summarise(ImageView<const float> scene, Border border, double border_value) {
  const std::vector<RowMoments> rows = row_moments(scene);
  const Statistics s = statistics_of(rows, scene.width);
  if (s.std == 0.0) return std::nullopt;
  const double beyond = border == Border::constant ? std::abs(border_value) : 0.0;  // its light enters the image
  const auto flat = std::count_if(rows.begin(), rows.end(), [](const RowMoments& row) { return row.min == row.max; });
  return SceneSummary{s.std, std::max({std::abs(s.min), std::abs(s.max), beyond}),
                      canvas_norm_of(rows, scene.width, border, border_value, s.mean),
                      static_cast<double>(flat) / static_cast<double>(scene.height), flat_columns(scene)};
}

Plan compile_stages(const System<double>& system, std::span<const Stage> stages, const SampleGrid& in,
                    const SampleGrid& out, const PlanOptions& options, const Plan::Recompile& how) {
  require_valid(system);
  check_grid(in, "scene");
  check_grid(out, "detector");
  const double tolerance = options.tolerance;
  if (!(tolerance > 0.0 && tolerance < 1.0))
    throw UsageError("tolerance " + format_double(tolerance) + " is outside (0, 1)");
  auto impl = std::make_shared<Plan::Impl>();
  impl->system = system;
  impl->stages.assign(stages.begin(), stages.end());
  impl->options = options;
  impl->split = how.split;
  impl->options.progress = {};  // whoever asked for it may be gone when the plan is changed
  PlanReport& report = impl->report;
  report.in = in;
  report.out = out;
  report.tolerance = tolerance;
  report.whole_pitches_x = static_cast<std::int64_t>(whole_pitches(in.width, in.step_x_um, out.step_x_um));
  report.whole_pitches_y = static_cast<std::int64_t>(whole_pitches(in.height, in.step_y_um, out.step_y_um));
  if (out.width > report.whole_pitches_x || out.height > report.whole_pitches_y)
    throw UsageError("the detector grid of " + std::to_string(out.width) + "x" + std::to_string(out.height) +
                     " is larger than the scene, which holds " + std::to_string(report.whole_pitches_x) + "x" +
                     std::to_string(report.whole_pitches_y) + " whole pixels; use detector_grid()");

  if (options.spectrum && !options.spectrum->is_of(in.width, in.height, options.border))
    throw UsageError("PlanOptions::spectrum is of a scene of another size or border; make it from this one");
  // Without a scene: that of a canvas whose parts are as contrasty as the image.
  const double parts = std::sqrt(static_cast<double>(canvas_length(options.border, in.width) / in.width) *
                                 static_cast<double>(canvas_length(options.border, in.height) / in.height));
  const double canvas_norm = options.scene ? options.scene->canvas_norm / options.scene->std : parts;
  // The error of the whole scene may concentrate in the part of it that the detector sees.
  const double norm = canvas_norm * std::sqrt(std::max(1.0, in.area_um2() / out.area_um2()));
  const double alias = std::sqrt(samples_per_pixel(in, out));
  const double ratio_x = out.step_x_um / in.step_x_um, ratio_y = out.step_y_um / in.step_y_um;
  // A mirrored canvas is four images; an error that is not mirrored may concentrate in one of them.
  const double spectrum_gain = norm / canvas_norm * (options.border == Border::reflect ? 2.0 : 1.0);
  std::optional<SceneCost> scene_cost;
  if (options.spectrum)
    scene_cost = SceneCost{options.spectrum.get(), ratio_x, ratio_y, spectrum_gain / (alias * norm)};
  const auto made = std::make_shared<FactoredOtf>(
      system, stages, options.aperture,
      SamplerOptions{.fx_max = 500.0 / in.step_x_um,
                     .fy_max = 500.0 / in.step_y_um,
                     .drop_budget = kDropShare * tolerance / (alias * norm),
                     .table_share = how.tables ? kTableShare * tolerance / (alias * norm) : 0.0,
                     .samples = in.width * in.height / 2,
                     .threads = options.threads,
                     .scene = scene_cost,
                     .split = how.split,
                     .progress = options.progress},
      how.earlier != nullptr ? how.earlier->sampler.get() : nullptr);
  impl->sampler = made;
  const FactoredOtf& sampler = *made;
  impl->dc = sampler.dc();
  report.dropped = sampler.dropped();
  report.merged = sampler.merged();
  report.wavelengths = sampler.wavelengths();
  if (sampler.aperture_limited())
    report.notes.push_back("scene aperture: the correction is limited to " +
                           format_double(options.aperture.gain_limit) + "; beyond, part of the scene's own blur stays");

  const PlanTask task{sampler, in, out, options, how.split, canvas_norm, norm, alias, spectrum_gain};
  Family wanted = Family::all;
  if (options.method) wanted = family(kMethodNames[static_cast<std::size_t>(*options.method)]);
  if (how.keep_family) wanted = family(how.earlier->report.method);
  std::vector<MethodCandidate> candidates = all_candidates(task, wanted);
  MethodCandidate* chosen = choose(candidates, task, options.rigor == Rigor::measure && !how.keep_family);
  if (chosen == nullptr) {
    const bool room_for_tables = std::any_of(candidates.begin(), candidates.end(),
                                             [](const MethodCandidate& d) { return d.report.predicted.table > 0.0; });
    if (how.tables && room_for_tables)
      return compile_stages(system, stages, in, out, options, {how.earlier, how.keep_family, false, how.split});
    refuse(candidates, options);
  }
  if (chosen->make) impl->engine = chosen->make(how.earlier != nullptr ? how.earlier->engine.get() : nullptr);
  impl->cost_ms = chosen->predicted_ms;
  impl->family_choice_ms = how.keep_family ? how.earlier->family_choice_ms : impl->cost_ms;
  describe(*chosen, candidates, impl->engine.get(), task, report);
  for (MethodCandidate& candidate : candidates) report.candidates.push_back(std::move(candidate.report));
  Plan plan;
  plan.impl_ = std::move(impl);
  return plan;
}

Plan compile(const System<double>& system, const SampleGrid& scene, const SampleGrid& detector,
             const PlanOptions& options) {
  constexpr std::array stages{Stage::presample};
  return compile_stages(system, stages, scene, detector, options, {});
}

Plan compile_part(const System<double>& system, const SampleGrid& scene, const SampleGrid& detector,
                  const PlanOptions& options, const ScaleSplit& split) {
  constexpr std::array stages{Stage::presample};
  return compile_stages(system, stages, scene, detector, options, {.split = split});
}

// A frame of a sequence is not worth judging every method anew: the chosen one stays while it keeps the tolerance and
// has not become clearly dearer.
Plan Plan::with(const System<double>& system) const {
  constexpr double kDearer = 1.5;
  const auto compiled = [&](bool keep_family) {
    return compile_stages(system, impl_->stages, in(), out(), impl_->options,
                          {impl_.get(), keep_family, true, impl_->split});
  };
  if (impl_->options.method) return compiled(false);
  try {
    Plan plan = compiled(true);
    if (plan.impl_->cost_ms <= kDearer * impl_->family_choice_ms) return plan;
  } catch (const UnreachableTolerance&) {  // another method may keep it
  }
  return compiled(false);
}

Plan compile_post(const System<double>& system, const SampleGrid& detector, std::span<const Stage> stages,
                  const PlanOptions& options) {
  return compile_stages(system, stages, detector, detector, options, {});
}

}  // namespace mtf
