// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/padding.h"
#include "mtf/plan_impl.h"
#include "mtf/plan_parts.h"
#include "mtf/statistics.h"

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

AxisJob make_axis(const OtfSampler& sampler, CanvasRequest request, Basis basis, std::int64_t outputs, double& wrap) {
  AxisJob job;
  job.border = request.border;
  job.samples = request.samples;
  job.outputs = outputs;
  job.pitch_um = request.pitch_um;
  CanvasLength canvas{request.samples, 0.0};
  if (basis == Basis::fourier) canvas = choose_canvas(sampler, request);
  wrap += canvas.bound;
  job.frequency = {basis, canvas.length, request.step_um};
  const double pitches = static_cast<double>(canvas.length) * request.step_um / request.pitch_um;
  job.resampling = is_whole(pitches) ? Resampling::fold : Resampling::chirp;
  if (job.resampling == Resampling::fold) job.out_length = std::llround(pitches);
  job.keep = job.frequency.half_count();
  return job;
}

// Leaves out the frequencies from the far end that no component lets through.
void cut_frequencies(const OtfSampler& sampler, Axis axis, double allowed, AxisJob& job) {
  while (job.keep > 1 && sampler.axis_bound(axis, job.frequency.cy_mm(job.keep - 1)) <= allowed) --job.keep;
}

std::string axis_text(const AxisJob& job) {
  const bool cosine = job.frequency.basis == Basis::cosine;
  std::string text = (cosine ? "cosine " : "fourier ") + std::to_string(job.frequency.length);
  if (job.resampling == Resampling::chirp) return text + ", chirp to " + std::to_string(job.outputs);
  if (job.out_length == job.frequency.length) return text;
  return text + ", fold to " + std::to_string(job.out_length);
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

std::optional<SceneSummary> summarise(ImageView<const float> scene, Border border, double border_value) {
  const Statistics s = statistics(scene);
  if (s.std == 0.0) return std::nullopt;
  const double level = border == Border::constant ? std::abs(border_value) : 0.0;  // shines into the image
  return SceneSummary{s.std, std::max({std::abs(s.min), std::abs(s.max), level}),
                      canvas_norm(scene, border, border_value, s.mean)};
}

// `tables` false: radial factors are evaluated at every frequency, for tolerances that leave no room for a table.
Plan compile_stages(const System<double>& system, std::span<const Stage> stages, const SampleGrid& in,
                    const SampleGrid& out, const PlanOptions& options, const Plan::Impl* relative, bool tables) {
  require_valid(system);
  check_grid(in, "scene");
  check_grid(out, "detector");
  if (!(options.tolerance > 0.0 && options.tolerance < 1.0))
    throw UsageError("tolerance " + format_double(options.tolerance) + " is outside (0, 1)");
  auto impl = std::make_shared<Plan::Impl>();
  impl->system = system;
  impl->stages.assign(stages.begin(), stages.end());
  impl->options = options;
  PlanReport& report = impl->report;
  report.in = in;
  report.out = out;
  report.tolerance = options.tolerance;
  report.whole_pitches_x = static_cast<std::int64_t>(whole_pitches(in.width, in.step_x_um, out.step_x_um));
  report.whole_pitches_y = static_cast<std::int64_t>(whole_pitches(in.height, in.step_y_um, out.step_y_um));

  const double fx = 500.0 / in.step_x_um, fy = 500.0 / in.step_y_um;
  const double alias = std::sqrt(samples_per_pixel(in, out));
  const double tolerance = options.tolerance;
  if (out.width > report.whole_pitches_x || out.height > report.whole_pitches_y)
    throw UsageError("the detector grid of " + std::to_string(out.width) + "x" + std::to_string(out.height) +
                     " is larger than the scene, which holds " + std::to_string(report.whole_pitches_x) + "x" +
                     std::to_string(report.whole_pitches_y) + " whole pixels; use detector_grid()");
  // Without a scene: that of a canvas whose parts are as contrasty as the image.
  const double parts = std::sqrt(static_cast<double>(canvas_length(options.border, in.width) / in.width) *
                                 static_cast<double>(canvas_length(options.border, in.height) / in.height));
  const double canvas_norm = options.scene ? options.scene->canvas_norm / options.scene->std : parts;
  // The error of the whole scene may gather in the part of it that the detector sees.
  const double norm = canvas_norm * std::sqrt(std::max(1.0, in.area_um2() / out.area_um2()));
  const OtfSampler sampler(system, stages, options.aperture,
                           {.fx_max = fx,
                            .fy_max = fy,
                            .drop_budget = kDropShare * tolerance / (alias * norm),
                            .table_share = tables ? kTableShare * tolerance / (alias * norm) : 0.0,
                            .samples = in.width * in.height / 2,
                            .threads = options.threads,
                            .split = options.split});
  impl->dc = sampler.dc();
  report.dropped = sampler.dropped();
  report.merged = sampler.merged();
  report.wavelengths = sampler.wavelengths();
  if (sampler.aperture_limited())
    report.notes.push_back("scene aperture: the correction is limited to " +
                           format_double(options.aperture.gain_limit) + "; beyond, part of the scene's own blur stays");

  const bool same_grid = in.step_x_um == out.step_x_um && in.step_y_um == out.step_y_um;
  const bool unit_mean = std::abs(impl->dc - 1.0) < 1e-12;  // a gain may be dropped for the contrast, not for the mean
  if (sampler.is_identity() && same_grid && unit_mean) {
    report.method = "identity";
    report.predicted.dropped = sampler.error() * norm;
    report.size = {in.width, in.height};
    report.axes = {"as it is", "as it is"};
    Plan plan;
    plan.impl_ = std::move(impl);
    return plan;
  }

  report.method = "spectral";
  // A half-sample mirror passes unchanged through an OTF that is even along that axis: no padding at all. Cosines along
  // x are pairs of real columns, which a complex OTF would mix.
  const bool y_cosine = options.border == Border::reflect && sampler.is_even_y();
  const bool x_cosine = y_cosine && sampler.is_real() && sampler.is_even_x();
  const double density = std::sqrt(std::max(1.0, out.step_x_um / in.step_x_um * (out.step_y_um / in.step_y_um)));
  CanvasRequest request{Axis::x, options.border, in.width,       in.step_x_um,
                        fy,      out.step_x_um,  norm * density, 0.5 * kWrapShare * tolerance};
  double wrap = 0.0;
  AxisJob x = make_axis(sampler, request, x_cosine ? Basis::cosine : Basis::fourier, out.width, wrap);
  request = {Axis::y, options.border, in.height, in.step_y_um, fx, out.step_y_um, norm * density, request.budget};
  AxisJob y = make_axis(sampler, request, y_cosine ? Basis::cosine : Basis::fourier, out.height, wrap);
  // Along a cosine axis error and canvas have the same mirror symmetry: nothing of the canvas's energy can gather
  // inside.
  const double gathering = norm / std::sqrt((x_cosine ? 2.0 : 1.0) * (y_cosine ? 2.0 : 1.0));
  const double allowed = kCutShare * tolerance / (alias * gathering);
  const double samples = static_cast<double>(x.frequency.length) * static_cast<double>(y.frequency.length);
  cut_frequencies(sampler, Axis::x, allowed, x);
  cut_frequencies(sampler, Axis::y, allowed, y);

  const double spread = gathering * std::sqrt(aliases(x) * aliases(y));
  double dropped = 0.0;
  for (const Dropped& d : sampler.dropped()) dropped += d.bound;
  const bool cut = x.keep < x.frequency.half_count() || y.keep < y.frequency.half_count();
  dropped *= sampler.gain();
  const double canvas_area = samples * (x_cosine ? 2.0 : 1.0) * (y_cosine ? 2.0 : 1.0);
  const double image_area = static_cast<double>(in.width) * static_cast<double>(in.height);
  const double canvas_rms = canvas_norm * std::sqrt(image_area / canvas_area);
  const double shortest_rms = canvas_norm / std::sqrt((x_cosine ? 2.0 : 1.0) * (y_cosine ? 2.0 : 1.0));
  const double quadrature = sampler.quadrature_error() * spread;
  report.predicted = {dropped * spread,
                      (sampler.error() - dropped) * spread - quadrature,
                      quadrature,
                      cut ? allowed * spread : 0.0,
                      wrap,
                      arithmetic_error(x, y, canvas_rms, sampler.gain(), options)};
  if (report.predicted.total() > tolerance && report.predicted.table > 0.0 && tables)
    return compile_stages(system, stages, in, out, options, relative, false);
  refuse_unreachable(report.predicted, arithmetic_error(x, y, shortest_rms, sampler.gain(), options), tolerance,
                     options);

  require_memory(x, y, sampler.is_real(), out);
  if (relative != nullptr && relative->engine && relative->engine->x() == x && relative->engine->y() == y)
    impl->engine = relative->engine;
  else
    impl->engine = std::make_shared<SpectralEngine>(x, y, options.rigor);
  impl->otf = make_otf(sampler, *impl->engine, options.threads);

  if (sampler.has_gain()) report.largest_gain = largest_gain(impl->otf, impl->engine->otf_scale());
  report.size = {x.frequency.length, y.frequency.length};
  report.axes = {axis_text(x), axis_text(y)};
  report.kept = {x.keep, y.keep};
  report.available = {x.frequency.half_count(), y.frequency.half_count()};
  report.otf_bytes = static_cast<std::int64_t>(impl->otf.data.size()) * 4;
  report.run_bytes = impl->engine->run_bytes(1, options.threads);
  Plan plan;
  plan.impl_ = std::move(impl);
  return plan;
}

Plan compile(const System<double>& system, const SampleGrid& scene, const SampleGrid& detector,
             const PlanOptions& options) {
  constexpr std::array stages{Stage::presample};
  return compile_stages(system, stages, scene, detector, options, nullptr, true);
}

Plan compile_post(const System<double>& system, const SampleGrid& detector, std::span<const Stage> stages,
                  const PlanOptions& options) {
  return compile_stages(system, stages, detector, detector, options, nullptr, true);
}

}  // namespace mtf
