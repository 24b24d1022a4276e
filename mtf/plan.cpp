// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan.h"

#include <algorithm>
#include <cmath>

#include "mtf/engines/kernels.h"
#include "mtf/error.h"
#include "mtf/padding.h"
#include "mtf/parallel.h"
#include "mtf/plan_impl.h"
#include "mtf/statistics.h"

namespace mtf {
namespace {

// How the tolerance is shared out; what is left over is for arithmetic.
constexpr double kDropShare = 0.05, kTableShare = 0.02, kCutShare = 0.01, kWrapShare = 0.25;
constexpr double kFloatUnit = 5.9604644775390625e-8;  // 2^-24
constexpr double kWholeEpsilon = 1e-9;                // a count of pitches is whole within this
constexpr std::int64_t kLargestSide = std::int64_t{1} << 29;
constexpr double kLargestBytes = 1.0e12;

void check_grid(const SampleGrid& grid, const char* name) {
  const auto fail = [&](const std::string& what) { throw UsageError(std::string(name) + " grid: " + what); };
  if (grid.width < 1 || grid.height < 1) fail("empty");
  if (grid.width > kLargestSide || grid.height > kLargestSide) fail("a side above 2^29 samples; cut the scene");
  for (const double step : {grid.step_x_um, grid.step_y_um})
    if (!(step > 0.0 && step < 1e12)) fail("sample step " + format_double(step) + " um is outside (0, 1e12)");
}

double whole_pitches(std::int64_t n, double step, double pitch) {
  return std::floor(static_cast<double>(n) * step / pitch + kWholeEpsilon);
}

bool is_whole(double x) { return x > 0.5 && std::abs(x - std::round(x)) <= kWholeEpsilon; }

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

// Frequencies that alias onto one detector frequency, at most.
double aliases(const AxisJob& job) {
  const double detector_band = job.frequency.period_um() / job.pitch_um;
  const double kept = 2.0 * static_cast<double>(job.keep) - 1.0;
  return std::max(1.0, std::ceil(kept / std::max(detector_band, 1.0)));
}

// rms rounding of float32: a transform pair errs by about 0.4 units per doubling of its length (measured in tests), the
// chirp passes through twice as many; then OTF rounding, and storage of values that stand on a mean.
double arithmetic_error(const AxisJob& x, const AxisJob& y, const PlanOptions& options) {
  double units = 2.0;
  for (const AxisJob* job : {&x, &y}) {
    const double stages = std::log2(1.0 + static_cast<double>(job->frequency.length));
    units += 0.5 * stages * (job->resampling == Resampling::chirp ? 4.0 : 1.0);
  }
  const double storage = options.scene ? options.scene->largest / options.scene->std : 1.0;
  return kFloatUnit * (units + storage);
}

void fill_otf(const OtfSampler& sampler, const SpectralEngine& engine, int threads, OtfBlocks& otf) {
  const std::int64_t per_block = engine.columns_per_block(), keep = engine.x().keep;
  const auto& terms = engine.y_terms();
  otf.complex = !sampler.is_real();
  otf.blocks = engine.blocks();
  otf.rows = static_cast<std::int64_t>(terms.size());
  otf.data = AlignedBuffer<float>(static_cast<std::size_t>(otf.blocks * otf.rows * kRowFloats));
  std::vector<double> fx(static_cast<std::size_t>(otf.blocks * per_block)), fy(terms.size());
  for (std::size_t i = 0; i < fx.size(); ++i) fx[i] = engine.x().frequency.cy_mm(static_cast<std::int64_t>(i));
  for (std::size_t j = 0; j < fy.size(); ++j) fy[j] = engine.y().frequency.cy_mm(terms[j].k);
  const OtfSampler::Grid grid(sampler, fx, fy);
  const auto scale = static_cast<float>(engine.otf_scale());
  const bool paired = per_block == kRowFloats;

  parallel_for(otf.rows, 8, threads, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> real(fx.size());
    std::vector<Complex<float>> values(otf.complex ? fx.size() : 0);
    for (std::int64_t j = begin; j < end; ++j) {
      if (otf.complex) {
        grid.complex_row(static_cast<std::size_t>(j), 0, values);
        std::fill(values.begin() + keep, values.end(), Complex<float>{});
      } else {
        grid.real_row(static_cast<std::size_t>(j), 0, real);
        std::fill(real.begin() + keep, real.end(), 0.0F);
      }
      for (std::int64_t b = 0; b < otf.blocks; ++b) {
        float* row = otf.row(b, j);
        const auto first = static_cast<std::size_t>(b * per_block);
        if (otf.complex)
          for (std::size_t l = 0; l < kLanes; ++l) {
            row[2 * l] = values[first + l].re * scale;
            row[2 * l + 1] = values[first + l].im * scale;
          }
        else if (paired)
          for (std::size_t l = 0; l < kRowFloats; ++l) row[l] = real[first + l] * scale;
        else
          for (std::size_t l = 0; l < kLanes; ++l) row[2 * l] = row[2 * l + 1] = real[first + l] * scale;
      }
    }
  });
}

// Leaves out the frequencies from the far end that no component lets through.
void cut_frequencies(const OtfSampler& sampler, double allowed, AxisJob& x, AxisJob& y) {
  const OtfSampler::Grid half(sampler, x.frequency.half_frequencies(), y.frequency.half_frequencies());
  while (x.keep > 1 && half.column_bound(static_cast<std::size_t>(x.keep - 1)) <= allowed) --x.keep;
  while (y.keep > 1 && half.row_bound(static_cast<std::size_t>(y.keep - 1)) <= allowed) --y.keep;
}

bool same_job(const AxisJob& a, const AxisJob& b) {
  return a.frequency.basis == b.frequency.basis && a.frequency.length == b.frequency.length &&
         a.frequency.step_um == b.frequency.step_um && a.border == b.border && a.samples == b.samples &&
         a.outputs == b.outputs && a.pitch_um == b.pitch_um && a.resampling == b.resampling &&
         a.out_length == b.out_length && a.keep == b.keep;
}

std::string axis_text(const AxisJob& job) {
  const bool cosine = job.frequency.basis == Basis::cosine;
  std::string text = (cosine ? "cosine " : "fourier ") + std::to_string(job.frequency.length);
  if (job.resampling == Resampling::chirp) return text + ", chirp to " + std::to_string(job.outputs);
  if (job.out_length == job.frequency.length) return text;
  return text + ", fold to " + std::to_string(job.out_length);
}

void refuse_unreachable(const PredictedError& predicted, double tolerance, const PlanOptions& options) {
  if (predicted.total() <= tolerance) return;
  // What the shares leave over scales with the tolerance; only arithmetic is fixed.
  const double reachable = predicted.arithmetic / (1.0 - kDropShare - kTableShare - kCutShare - kWrapShare);
  if (!options.scene && predicted.arithmetic <= tolerance) return;
  throw UsageError("tolerance " + format_double(tolerance) + " is below what float32 reaches for this scene; use " +
                   format_double(std::max(reachable, predicted.total()) * 1.01) + " or more");
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
  return SceneSummary{s.std, std::max(std::abs(s.min), std::abs(s.max)),
                      canvas_norm(scene, border, border_value, s.mean)};
}

Plan compile_stages(const System<double>& system, std::span<const Stage> stages, const SampleGrid& in,
                    const SampleGrid& out, const PlanOptions& options, const Plan::Impl* relative) {
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
  const double ratio = std::max(1.0, std::ceil(out.step_x_um / in.step_x_um) * std::ceil(out.step_y_um / in.step_y_um));
  const double alias = std::sqrt(std::min(ratio, 1e6));
  const double tolerance = options.tolerance;
  const OtfSampler sampler(system, stages, options.aperture, fx, fy, kDropShare * tolerance / (2.0 * alias),
                           std::clamp(kTableShare * tolerance / alias, 1e-7, 1e-6));
  impl->dc = sampler.dc();
  report.dropped = sampler.dropped();
  report.merged = sampler.merged();
  report.wavelengths = sampler.wavelengths();
  if (sampler.aperture_limited())
    report.notes.push_back("scene aperture: the correction is limited to " +
                           format_double(options.aperture.gain_limit) + "; beyond, part of the scene's own blur stays");

  const bool same_grid = in.step_x_um == out.step_x_um && in.step_y_um == out.step_y_um;
  if (sampler.is_identity() && same_grid) {
    report.method = "identity";
    report.predicted.dropped =
        sampler.error() * (options.scene ? options.scene->canvas_norm / options.scene->std : 2.0);
    return [&] {
      Plan plan;
      plan.impl_ = impl;
      return plan;
    }();
  }

  report.method = "spectral";
  const bool mirror = options.border == Border::reflect && sampler.is_real();
  // A half-sample mirror passes unchanged through an OTF that is even along that axis: no padding at all.
  const bool y_cosine = mirror ? sampler.is_even_y() : options.border == Border::reflect && sampler.is_even_y();
  const bool x_cosine = mirror && sampler.is_even_x() && y_cosine;
  const double norm = options.scene ? options.scene->canvas_norm / options.scene->std : 2.0;
  CanvasRequest request{Axis::x, options.border, in.width, in.step_x_um,
                        fy,      out.step_x_um,  norm,     0.5 * kWrapShare * tolerance};
  double wrap = 0.0;
  AxisJob x = make_axis(sampler, request, x_cosine ? Basis::cosine : Basis::fourier, out.width, wrap);
  request = {Axis::y, options.border, in.height, in.step_y_um, fx, out.step_y_um, norm, 0.5 * kWrapShare * tolerance};
  AxisJob y = make_axis(sampler, request, y_cosine ? Basis::cosine : Basis::fourier, out.height, wrap);
  // Along a cosine axis error and canvas have the same mirror symmetry: nothing of the canvas's energy can gather
  // inside.
  const double gathering = norm / std::sqrt((x_cosine ? 2.0 : 1.0) * (y_cosine ? 2.0 : 1.0));
  const double allowed = kCutShare * tolerance / (alias * gathering);
  cut_frequencies(sampler, allowed, x, y);

  const double spread = gathering * std::sqrt(aliases(x) * aliases(y));
  double dropped = 0.0;
  for (const Dropped& d : sampler.dropped()) dropped += d.bound;
  const bool cut = x.keep < x.frequency.half_count() || y.keep < y.frequency.half_count();
  report.predicted = {dropped * spread, (sampler.error() - dropped) * spread, cut ? allowed * spread : 0.0, wrap,
                      arithmetic_error(x, y, options)};
  refuse_unreachable(report.predicted, tolerance, options);

  const double samples = static_cast<double>(x.frequency.length) * static_cast<double>(y.frequency.length);
  if (8.0 * samples > kLargestBytes)
    throw UsageError("the transforms would need " + format_double(8.0 * samples) +
                     " bytes; cut the scene or choose border = \"periodic\"");
  if (relative != nullptr && relative->engine && same_job(relative->engine->x(), x) &&
      same_job(relative->engine->y(), y))
    impl->engine = relative->engine;
  else
    impl->engine = std::make_shared<SpectralEngine>(x, y, options.rigor);
  fill_otf(sampler, *impl->engine, options.threads, impl->otf);

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
  return compile_stages(system, stages, scene, detector, options, nullptr);
}

Plan compile_post(const System<double>& system, const SampleGrid& detector, std::span<const Stage> stages,
                  const PlanOptions& options) {
  return compile_stages(system, stages, detector, detector, options, nullptr);
}

}  // namespace mtf
