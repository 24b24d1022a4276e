// SPDX-License-Identifier: Apache-2.0

// `mtf simulate SENSOR SCENE -o OUT`: read, compile, run, write, report.

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "apps/options.h"
#include "apps/output.h"
#include "apps/run_report.h"
#include "apps/sensor_file.h"
#include "apps/sensor_image.h"
#include "apps/text_table.h"
#include "mtf/bad_pixels.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/curve_csv.h"
#include "mtf/statistics.h"

namespace apps {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kLargestWisdom = std::size_t{16} << 20;

class StopWatch {
 public:
  explicit StopWatch(Progress progress) : progress_(progress) {}

  // A run of one image is over before a bar would help: progress is a line a stage, for those who ask for it.
  void lap(const char* name, std::vector<std::pair<std::string, double>>& laps) {
    const Clock::time_point now = Clock::now();
    laps.emplace_back(name, std::chrono::duration<double, std::milli>(now - last_).count());
    last_ = now;
    const std::string ms = fixed(laps.back().second, 1);
    if (progress_ == Progress::plain) complain(std::string(name) + " " + ms + " ms");
    if (progress_ == Progress::json) complain("{\"stage\":\"" + std::string(name) + "\",\"ms\":" + ms + "}");
  }

 private:
  Progress progress_;
  Clock::time_point last_ = Clock::now();
};

// What can be seen to fail is said before any work is done.
void check_paths(const SimulateOptions& options, const std::vector<std::string>& inputs) {
  if (options.out.empty()) throw mtf::UsageError("-o, --out is missing: name the output image (.exr, .png, .tif)");
  mtf::io::format_from_extension(options.out);
  std::vector<std::string> outputs{options.out};
  if (options.wisdom == "-") throw mtf::UsageError("--wisdom: name a file; \"-\" is for --report only");
  for (const std::string& more : {options.report, options.wisdom})
    if (!more.empty() && more != "-") outputs.push_back(more);
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (const std::string& input : inputs) require_different(input, outputs[i]);
    for (std::size_t j = 0; j < i; ++j)
      if (std::filesystem::path(outputs[i]).lexically_normal() == std::filesystem::path(outputs[j]).lexically_normal())
        throw mtf::UsageError(one_line(outputs[i]) + " is named for two outputs; give each its own name");
    const std::filesystem::path folder = std::filesystem::path(outputs[i]).parent_path();
    std::error_code error;
    if (!folder.empty() && !std::filesystem::is_directory(folder, error))
      throw mtf::RuntimeError("cannot write " + one_line(outputs[i]) + ": there is no folder " +
                              one_line(folder.string()) + "; create it first");
  }
}

// FFT plans measured before, from a file that is made when it is missing. Anything else than wisdom is left alone.
void read_wisdom(const SimulateOptions& options, const Global& global) {
  std::error_code error;
  if (options.wisdom.empty()) return;
  if (!std::filesystem::exists(options.wisdom, error)) {
    note(global, "note: " + one_line(options.wisdom) + " is made and will hold the FFT plans measured now");
    return;
  }
  if (!std::filesystem::is_regular_file(options.wisdom, error) ||
      !mtf::fft::import_wisdom(mtf::io::read_text_file(options.wisdom, kLargestWisdom)))
    throw mtf::UsageError("--wisdom: " + one_line(options.wisdom) +
                          " is not FFTW wisdom of this machine; name another file");
}

// The plan for the tolerance asked for; without one, for the default or, where that is out of reach, for what can be
// kept.
mtf::SensorPlan compile_plan(const mtf::System<double>& system, const mtf::SampleGrid& grid, bool asked,
                             mtf::PlanOptions& plan_options, RunReport& report) {
  try {
    return mtf::compile_sensor(system, grid, plan_options);
  } catch (const mtf::UnreachableTolerance& e) {
    if (asked || !(e.reachable() < 1.0)) throw;
    report.warnings.push_back("the default tolerance " + mtf::format_double(plan_options.tolerance) +
                              " cannot be kept for this scene; " + significant(e.reachable(), 2) + " is used");
    plan_options.tolerance = e.reachable();
  }
  return mtf::compile_sensor(system, grid, plan_options);
}

// Masks of bad pixels per channel (empty where there are none), the planes filled.
std::vector<mtf::Image> treat_bad_pixels(mtf::io::Scene& scene, NanPolicy policy, std::string& summary) {
  std::vector<mtf::Image> masks(scene.planes.size());
  std::int64_t total = 0;
  for (std::size_t c = 0; c < scene.planes.size(); ++c) {
    const mtf::Statistics s = mtf::statistics(scene.planes[c].view());
    if (s.not_finite == 0) continue;
    if (policy == NanPolicy::refuse)
      throw mtf::RuntimeError("channel " + scene.names[c] + ": " + std::to_string(s.not_finite) +
                              " pixels are NaN or infinite, the first at column " + std::to_string(s.first_x) +
                              ", row " + std::to_string(s.first_y) +
                              "; use --nan fill (from neighbours) or --nan propagate");
    if (policy == NanPolicy::propagate) masks[c] = mtf::bad_pixel_mask(scene.planes[c].view());
    total += mtf::fill_bad_pixels(scene.planes[c].view());
  }
  if (total > 0)
    summary = std::to_string(total) + " NaN or infinite pixels were filled from their neighbours" +
              (policy == NanPolicy::propagate ? "; output pixels that depend on them are NaN" : "");
  return masks;
}

// One summary for all channels: the parts that make the promise hardest to keep, on the scale of one of them.
std::optional<mtf::SceneSummary> summarise_all(const mtf::io::Scene& scene, const mtf::io::SceneDefaults& defaults) {
  std::optional<mtf::SceneSummary> worst;
  for (const mtf::Image& plane : scene.planes) {
    const auto s = mtf::summarise(plane.view(), defaults.border, defaults.border_value);
    if (!s) continue;
    if (!worst) worst = s;
    worst->largest = std::max(worst->largest, s->largest / s->std * worst->std);
    worst->canvas_norm = std::max(worst->canvas_norm, s->canvas_norm / s->std * worst->std);
  }
  return worst;
}

void print_summary(const RunReport& report, const std::vector<mtf::Image>& images,
                   const std::vector<std::string>& names) {
  const mtf::SampleGrid& out = report.plan->out();
  std::string text = one_line(report.out_path) + "  " + std::to_string(out.width) + "x" + std::to_string(out.height) +
                     "  " + std::string(mtf::io::quantity_name(report.scene->quantity)) + " [" +
                     std::string(mtf::io::quantity_unit(report.scene->quantity)) + "]\n";
  TextTable table({"channel", "min", "mean", "max", "std"});
  for (std::size_t c = 0; c < images.size(); ++c) {
    const mtf::Statistics s = mtf::statistics(images[c].view());
    table.add({one_line(names[c]), significant(s.min, 6), significant(s.mean, 6), significant(s.max, 6),
               significant(s.std, 6)});
  }
  text += table.aligned({Align::left, Align::right, Align::right, Align::right, Align::right});
  double total = 0.0;
  std::string times;
  for (const auto& [name, ms] : report.timing_ms) {
    times += (times.empty() ? "" : ", ") + name + " " + fixed(ms, 1);
    total += ms;
  }
  text += "predicted error " + significant(report.plan->predicted_error, 2) + " of the scene's std (tolerance " +
          mtf::format_double(report.tolerance) + ")\n";
  text += "time " + fixed(total, 1) + " ms (" + times + ")\n";
  print(text);
}

}  // namespace

int run_simulate(const SimulateOptions& options, const Global& global) {
  RunReport report;
  StopWatch watch(global.progress);
  const mtf::io::SensorConfig config = load_sensor(options.sensor, global);
  std::vector<std::string> inputs = files_of(config);
  inputs.push_back(options.scene);
  check_paths(options, inputs);
  mtf::io::Scene scene = mtf::io::load_scene(config, options.scene, {options.channel, options.layer, options.part});
  report.warnings = scene.warnings;
  for (std::string& warning : mtf::io::sampling_warnings(config.system, scene.grid))
    report.warnings.push_back(std::move(warning));
  std::vector<mtf::Image> masks = treat_bad_pixels(scene, options.nan, report.bad_pixels);
  if (!report.bad_pixels.empty()) note(global, "note: " + report.bad_pixels);
  watch.lap("read", report.timing_ms);

  mtf::PlanOptions plan_options;
  plan_options.tolerance = options.tolerance.value_or(plan_options.tolerance);
  plan_options.border = config.scene.border;
  plan_options.rigor = options.measure ? mtf::fft::Rigor::measure : mtf::fft::Rigor::estimate;
  plan_options.aperture = mtf::io::scene_aperture(config.scene, scene.grid);
  plan_options.scene = summarise_all(scene, config.scene);
  plan_options.threads = global.threads;
  read_wisdom(options, global);
  const mtf::SensorPlan plan =
      compile_plan(config.system, scene.grid, options.tolerance.has_value(), plan_options, report);
  for (const std::string& text : plan.presample.report().notes) report.warnings.push_back(text);
  for (const std::string& warning : report.warnings) note(global, "warning: " + one_line(warning));
  if (options.measure)
    note(global, "note: --rigor measure chose FFT plans by timing; the last bits may differ between runs");
  watch.lap("plan", report.timing_ms);

  std::vector<mtf::Image> images = plan.run(std::move(scene.planes), config.scene.border_value, global.threads);
  for (std::size_t c = 0; c < masks.size(); ++c)
    if (masks[c].size() > 0)
      mtf::propagate_bad_pixels(plan, masks[c], plan_options.tolerance, global.threads, images[c].view());
  watch.lap("run", report.timing_ms);

  const std::vector<std::string> names = output_names(scene.names);
  const Written written =
      write_sensor_image(options.out, names, images, provenance(config, scene, plan, plan_options.tolerance),
                         options.range_low, options.range_high);
  if (!options.wisdom.empty()) mtf::io::write_text_file(options.wisdom, mtf::fft::export_wisdom());
  watch.lap("write", report.timing_ms);

  report.config = &config;
  report.scene = &scene;
  report.plan = &plan;
  report.scene_path = options.scene;
  report.out_path = options.out;
  report.tolerance = plan_options.tolerance;
  if (written.scaling) {
    report.gain = written.scaling->gain;
    report.offset = written.scaling->offset;
    report.clamped = written.clamped;
    report.integer_scaling = "value = gain x file + offset, in " + std::string(mtf::io::quantity_unit(scene.quantity));
    note(global, "note: 16-bit output, value = " + mtf::format_double(report.gain) + " x file + " +
                     mtf::format_double(report.offset) +
                     (report.clamped > 0 ? ", " + std::to_string(report.clamped) + " samples clamped" : ""));
  }
  if (!options.report.empty()) emit(options.report, to_json(report));
  if (options.report == "-") return 0;  // standard output is the report
  if (options.explain) {
    std::string text = plan.presample.explain();
    if (plan.post) text += "after sampling\n" + plan.post->explain();
    print(text);
  }
  print_summary(report, images, names);
  return 0;
}

}  // namespace apps
