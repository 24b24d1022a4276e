// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan/plan.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <mutex>
#include <vector>

#include "mtf/device/device_image.h"
#include "mtf/engines/kept_plane.h"
#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/field/sample_ranges.h"
#include "mtf/parallel.h"
#include "mtf/plan/plan_impl.h"
#include "mtf/words.h"

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

void check_size(std::int64_t width, std::int64_t height, const SampleGrid& grid, const char* name) {
  if (width == grid.width && height == grid.height) return;
  throw UsageError(std::string(name) + " image is " + size_text(width, height) + ", the plan was made for " +
                   size_text(grid.width, grid.height));
}

void fill(ImageView<float> out, float value) {
  for (std::int64_t y = 0; y < out.height; ++y) std::fill_n(out.row(y), out.width, value);
}

std::string short_number(double value) { return significant(value, 2); }

}  // namespace

PlanOptions on_processor(PlanOptions options) {
  options.device = {};
  if (options.method == Method::fft_device) options.method.reset();
  return options;
}

void require_spectrum_of(const SampleGrid& in, const PlanOptions& options) {
  if (options.spectrum && !options.spectrum->is_of(in.width, in.height, options.border))
    throw UsageError("PlanOptions::spectrum is of a scene of another size or border; make it from this one");
}

double canvas_norm_of(const PlanOptions& options, const SampleGrid& in) {
  if (options.scene) return options.scene->canvas_norm / options.scene->std;
  return std::sqrt(static_cast<double>(canvas_length(options.border, in.width) / in.width) *
                   static_cast<double>(canvas_length(options.border, in.height) / in.height));
}

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
  const std::vector<RowMoments> rows = row_moments(scene);
  const Statistics s = statistics_of(rows, scene.width);
  if (s.std == 0.0) return std::nullopt;
  const double beyond = border == Border::constant ? std::abs(border_value) : 0.0;  // its light enters the image
  const auto flat = std::count_if(rows.begin(), rows.end(), [](const RowMoments& row) { return row.min == row.max; });
  return SceneSummary{.std = s.std,
                      .largest = std::max({std::abs(s.min), std::abs(s.max), beyond}),
                      .canvas_norm = canvas_norm_of(rows, scene.width, border, border_value, s.mean),
                      .flat_rows = static_cast<double>(flat) / static_cast<double>(scene.height),
                      .flat_columns = flat_columns(scene),
                      .deviation = std::max(s.max - s.mean, s.mean - s.min)};
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
    throw UsageError("the detector grid of " + size_text(out.width, out.height) +
                     " is larger than the scene, which holds " +
                     size_text(report.whole_pitches_x, report.whole_pitches_y) + " whole pixels; use detector_grid()");

  require_spectrum_of(in, options);
  const Norms norms(in, out, options);
  const double ratio_x = out.step_x_um / in.step_x_um, ratio_y = out.step_y_um / in.step_y_um;
  std::optional<SceneCost> scene_cost;
  if (options.spectrum)
    scene_cost = SceneCost{options.spectrum.get(), ratio_x, ratio_y, norms.spectrum_gain / norms.of_any()};
  const auto made = std::make_shared<FactoredOtf>(
      system, stages, options.aperture,
      SamplerOptions{.fx_max = 500.0 / in.step_x_um,
                     .fy_max = 500.0 / in.step_y_um,
                     .drop_budget = kDropShare * tolerance / norms.of_any(),
                     .table_share = how.tables ? kTableShare * tolerance / norms.of_any() : 0.0,
                     .samples = in.width * in.height / 2,
                     .threads = options.threads,
                     .scene = scene_cost,
                     .split = how.split,
                     .given = how.mode,
                     .progress = options.progress},
      how.earlier != nullptr ? how.earlier->sampler.get() : nullptr);
  impl->sampler = made;
  const FactoredOtf& sampler = *made;
  impl->dc = how.mode ? how.dc : sampler.dc();
  report.dropped = sampler.dropped();
  report.merged = sampler.merged();
  report.wavelengths = sampler.wavelengths();
  if (sampler.aperture_limited())
    report.notes.push_back("scene aperture: the correction is limited to " +
                           format_double(options.aperture.gain_limit) + "; beyond, part of the scene's own blur stays");

  const PlanTask task{sampler, in, out, options, how.split, norms.canvas, norms.norm, norms.alias, norms.spectrum_gain};
  Family wanted = Family::all;
  if (how.mode) wanted = Family::fft;
  if (options.method) wanted = family(name_of(*options.method));
  if (how.keep_family) wanted = family(how.earlier->report.method);
  std::vector<MethodCandidate> candidates = all_candidates(task, wanted);
  MethodCandidate* chosen = choose(candidates, task, options.rigor == Rigor::measure && !how.keep_family);
  if (chosen == nullptr) {
    const bool room_for_tables = std::any_of(candidates.begin(), candidates.end(),
                                             [](const MethodCandidate& d) { return d.report.predicted.table > 0.0; });
    if (how.tables && room_for_tables)
      return compile_stages(system, stages, in, out, options,
                            {how.earlier, how.keep_family, false, how.split, how.mode, how.dc});
    refuse(candidates, options);
  }
  if (chosen->make) try {
      impl->engine = chosen->make(how.earlier != nullptr ? how.earlier->engine.get() : nullptr);
    } catch (const DeviceError& error) {
      if (options.device.insisted) throw;
      Plan plan = compile_stages(system, stages, in, out, on_processor(options), how);
      auto other = std::make_shared<Plan::Impl>(*plan.impl_);
      other->report.notes.push_back(options.device.device->info().name +
                                    " failed, and the processor does the work: " + error.what());
      plan.impl_ = std::move(other);
      return plan;
    }
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
  const bool by_range = entry_by_range(system).has_value();
  if (by_range || !system.is_isoplanatic()) {
    require_valid(system);
    check_grid(scene, "scene");
    check_grid(detector, "detector");
    return (by_range ? compile_over_range : compile_over_field)(system, scene, detector, options);
  }
  return compile_stages(system, stages, scene, detector, options, {});
}

Plan compile_part(const System<double>& system, const SampleGrid& scene, const SampleGrid& detector,
                  const PlanOptions& options, const ScaleSplit& split) {
  constexpr std::array stages{Stage::presample};
  require_isoplanatic(system, "a part of an image (--roi, --memory)");
  refuse_range(system, "a part of an image (--roi, --memory)");
  return compile_stages(system, stages, scene, detector, options, {.split = split});
}

// A frame of a sequence is not worth judging every method anew: the chosen one stays while it keeps the tolerance and
// has not become clearly dearer.
Plan Plan::with(const System<double>& system) const {
  const bool of_image = impl_->split.is_whole() && impl_->stages == std::vector<Stage>{Stage::presample};
  if (of_image && (impl_->field || impl_->options.range_m || entry_by_range(system) || !system.is_isoplanatic() ||
                   impl_->report.field.points > 0))
    return compile(system, in(), out(), impl_->options);
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

const PlanReport& Plan::report() const { return impl_->report; }
double Plan::dc() const { return impl_->dc; }

void Plan::run(ImageView<const float> in, ImageView<float> out, double border_value, int threads) const {
  run(std::span(&in, 1), std::span(&out, 1), border_value, threads);
}

void Plan::run(std::span<const ImageView<const float>> in, std::span<const ImageView<float>> out, double border_value,
               int threads) const {
  run_planes(in, out, border_value, threads, {});
}

void Plan::run(KeptScene& scene, std::span<const ImageView<float>> out, double border_value, int threads) const {
  std::vector<ImageView<const float>> in;
  for (const Image& plane : scene.planes()) in.push_back(plane.view());
  run_planes(in, out, border_value, threads, scene.kept());
}

void Plan::run_planes(std::span<const ImageView<const float>> in, std::span<const ImageView<float>> out,
                      double border_value, int threads, std::span<KeptPlane> kept, const Take& take,
                      std::unique_ptr<DeviceImage>* stays) const {
  if (in.size() != out.size()) throw UsageError("as many output as input planes are needed");
  if (impl_->weights) {
    for (std::size_t c = 0; c < in.size(); ++c) {
      check_size(in[c].width, in[c].height, impl_->report.in, "input");
      check_size(out[c].width, out[c].height, impl_->report.out, "output");
      run_samples(in[c], out[c], threads);
    }
    return;
  }
  if (impl_->field) return run_modes(in, out, border_value, threads, kept);
  const bool constant = impl_->options.border == Border::constant;
  if (constant && !(std::abs(border_value) <= std::numeric_limits<float>::max()))
    throw UsageError("the border value has to be a finite float");
  std::vector<Channel> channels;
  std::vector<Image> copies;
  std::vector<KeptPlane> own(kept.empty() ? in.size() : 0);  // for this run alone
  // FFT engines read all of an input before they write, and check by themselves that it is finite.
  const bool transforms = impl_->report.method.starts_with("fft");
  for (std::size_t c = 0; c < in.size(); ++c) {
    check_size(in[c].width, in[c].height, impl_->report.in, "input");
    check_size(out[c].width, out[c].height, impl_->report.out, "output");
    const std::optional<MeanAndDeviation> sampled = transforms ? sampled_mean_and_deviation(in[c]) : std::nullopt;
    KeptPlane& plane = kept.empty() ? own[c] : kept[c];
    if (!sampled && !plane.all) plane.all = mean_and_deviation(in[c], threads, plane.flat);
    const MeanAndDeviation about = sampled ? *sampled : *plane.all;
    const double deviation = canvas_deviation(about, impl_->options.border, border_value);
    if (deviation == 0.0) {
      if (!take) fill(out[c], static_cast<float>(impl_->dc * about.mean));
    } else if (!impl_->engine) {
      for (std::int64_t y = 0; y < out[c].height; ++y)
        std::memmove(out[c].row(y), in[c].row(y), static_cast<std::size_t>(out[c].width) * sizeof(float));
    } else {
      ImageView<const float> from = in[c];
      if (!transforms && share_memory(in[c], out[c])) from = copies.emplace_back(copy_of(in[c])).view();
      channels.push_back({from, out[c], about.mean, scale_for(deviation), sampled.has_value(), impl_->dc, border_value,
                          &plane.flat, impl_->report.predicted.flat, kept.empty() ? nullptr : &plane});
      channels.back().stays = stays;
      if (take)
        channels.back().take = [&take, c](std::int64_t y, std::int64_t x, std::span<const float> samples) {
          take(c, y, x, samples);
        };
    }
  }
  if (!channels.empty()) run_engine(channels, threads);
}

std::unique_ptr<DeviceImage> Plan::run_on_device(ImageView<const float> in, ImageView<float> out, double border_value,
                                                 int threads) const {
  std::unique_ptr<DeviceImage> image;
  run_planes(std::span(&in, 1), std::span(&out, 1), border_value, threads, {}, {}, &image);
  return image;
}

std::unique_ptr<DeviceImage> Plan::run_on_device(KeptScene& scene, ImageView<float> out, double border_value,
                                                 int threads) const {
  std::unique_ptr<DeviceImage> image;
  const ImageView<const float> in = scene.planes().front().view();
  run_planes(std::span(&in, 1), std::span(&out, 1), border_value, threads, scene.kept(), {}, &image);
  return image;
}

// The engine of a device has written nothing where it fails.
void Plan::run_engine(const std::vector<Channel>& channels, int threads) const {
  try {
    return impl_->engine->run(channels, threads);
  } catch (const DeviceError&) {
    if (impl_->options.device.insisted) throw;
  }
  ProcessorPlan& other = *impl_->otherwise;
  {
    const std::scoped_lock lock(other.lock);
    if (!other.plan) {
      System<double> system = impl_->system;
      if (!system.is_isoplanatic()) system = with_field_radius(system, out()).at({});
      other.plan = compile_stages(system, impl_->stages, in(), out(), on_processor(impl_->options),
                                  {.earlier = impl_.get(), .keep_family = true, .split = impl_->split});
    }
  }
  other.plan->impl_->engine->run(channels, threads);
}

std::string Plan::explain() const {
  const PlanReport& r = impl_->report;
  std::string text = "plan      " + r.method + ", " + size_text(r.in.width, r.in.height) + " samples of " +
                     format_double(r.in.step_x_um) + " x " + format_double(r.in.step_y_um) + " um -> " +
                     size_text(r.out.width, r.out.height) + " pixels of " + format_double(r.out.step_x_um) + " x " +
                     format_double(r.out.step_y_um) + " um\n";
  if (r.out.width < r.whole_pitches_x || r.out.height < r.whole_pitches_y)
    text += "format    the scene holds " + size_text(r.whole_pitches_x, r.whole_pitches_y) + " whole pixels\n";
  if (r.method.starts_with("fft")) {
    text += "axes      x: " + r.axes[0] + "; y: " + r.axes[1] + "\n";
    text += "kept      " + size_text(r.kept[0], r.kept[1]) + " of " + size_text(r.available[0], r.available[1]) +
            " frequencies\n";
  }
  for (const std::string& line : r.merged) text += "merged    " + line + "\n";
  if (r.wavelengths > 1) text += "band      " + std::to_string(r.wavelengths) + " wavelengths\n";
  if (const auto& ranges = r.field.ranges)
    text += "range     from " + short_number(ranges->nearest_m) + " to " + short_number(ranges->farthest_m) + " m: " +
            (r.field.modes == 0
                 ? std::string("one defocus, that of the mean, serves all samples")
                 : "the mean OTF and " + plural(static_cast<std::int64_t>(r.field.modes), "mode") + ", from OTFs at " +
                       std::to_string(r.field.points) + " ranges; least sum of the weights that reach a pixel " +
                       short_number(ranges->least_weight)) +
            "; the mean defocus alone would err by at most " + short_number(r.field.one_otf_error) + "\n";
  else if (r.field.points > 0)
    text += "field     " +
            (r.field.modes == 0 ? std::string("one OTF serves all pixels")
                                : "the mean OTF and " + (r.field.tiles > 0 ? std::string("at most ") : std::string()) +
                                      plural(static_cast<std::int64_t>(r.field.modes), "mode") +
                                      (r.field.tiles > 0 ? " a tile" : "")) +
            ", from OTFs at " + std::to_string(r.field.points) +
            " places; that of the axis alone would err by at most " + short_number(r.field.one_otf_error) + "\n";
  for (const Omission& o : r.omitted)
    text += "left out  " + o.what + " (error at most " + short_number(o.bound) + ", saves about " +
            short_number(o.saved_ms) + " ms)\n";
  for (const std::string& note : r.notes) text += "note      " + note + "\n";
  for (const Candidate& c : r.candidates) {
    text += (c.reason.empty() ? "chosen    " : "other     ") + std::string(name_of(c));
    if (!c.detail.empty()) text += ": " + c.detail;
    if (c.cost_ms > 0.0)
      text += "; predicted error " + short_number(c.predicted.total()) + ", " + short_number(c.cost_ms) +
              (c.measured ? " ms measured" : " ms");
    text += (c.reason.empty() ? "" : "; " + c.reason) + "\n";
  }
  if (impl_->options.spectrum) text += "for       this very scene: errors are weighed by its spectrum\n";
  const PredictedError& e = r.predicted;
  text += "error     predicted <= " + short_number(e.total()) + " of the scene's std, tolerance " +
          short_number(r.tolerance) + " (dropped " + short_number(e.dropped) + ", table " + short_number(e.table) +
          ", band " + short_number(e.band) + ", cut " + short_number(e.cut) + ", wrap " + short_number(e.wrap) +
          ", kernel " + short_number(e.kernel) + (r.field.points > 0 ? ", field " + short_number(e.modes) : "") +
          ", flat lines " + short_number(e.flat) + ", float32 " + short_number(e.arithmetic) + ")\n";
  const double mib = 1.0 / (1024.0 * 1024.0);
  text += "memory    OTF " + short_number(static_cast<double>(r.otf_bytes) * mib) + " MiB, buffers " +
          short_number(static_cast<double>(r.run_bytes) * mib) + " MiB\n";
  return text;
}

SampleGrid grid_of(const SceneView& scene, const Frame<double>& frame) {
  if (!scene.step.given()) throw UsageError("the scene has no sample step; give one, such as 3.75_um or 0.25_px");
  return {scene.samples.width, scene.samples.height, scene.step.x_um(frame), scene.step.y_um(frame)};
}

Plan compile(const System<double>& system, const SceneView& scene, PlanOptions options) {
  const SampleGrid grid = grid_of(scene, system.frame);
  const SampleGrid detector = detector_grid(system, grid);
  options.scene = summarise(scene.samples, options.border, scene.border_value);
  return compile(system, grid, detector, options);
}

}  // namespace mtf
