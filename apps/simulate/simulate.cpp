// SPDX-License-Identifier: Apache-2.0

// `mtf simulate SENSOR SCENE -o OUT`: read, compile, run, write, report.

#include <algorithm>
#include <chrono>

#include "apps/measured_file.h"
#include "apps/options.h"
#include "apps/sensor/sensor_file.h"
#include "apps/sensor/sensor_place.h"
#include "apps/simulate/radiometric_chain.h"
#include "apps/simulate/run_report.h"
#include "apps/simulate/run_summary.h"
#include "apps/simulate/sensor_image.h"
#include "apps/simulate/sequence.h"
#include "apps/simulate/simulate_parts.h"
#include "apps/simulate/simulate_tiles.h"
#include "apps/terminal/output.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/survey/bad_pixels.h"
#include "mtf/survey/statistics.h"

namespace apps {
namespace {

using Clock = std::chrono::steady_clock;

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

void print_summary(const RunReport& report, const std::vector<std::string>& names,
                   const std::vector<mtf::Statistics>& statistics) {
  const mtf::SampleGrid& out = report.tiles ? report.tiles->out : report.plan->out();
  std::string text = summary_head(report, out);
  const mtf::PlanReport& plan = report.plan->presample.report();
  if (out.width < plan.whole_pitches_x || out.height < plan.whole_pitches_y)
    text += "the scene holds " + std::to_string(plan.whole_pitches_x) + "x" + std::to_string(plan.whole_pitches_y) +
            " whole pixels; frame.format takes the first of them\n";
  print(text + summary_channels(names, statistics) + summary_costs(report) + "\n");
}

std::vector<mtf::Image> run_chain(const RadiometricChain& radiometric, const mtf::SensorPlan& plan, mtf::Image radiance,
                                  double border_value, RunReport& report, int threads) {
  const radiometry::Sensor& sensor = radiometric.loaded.sensor;
  const radiometry::Chain chain(plan, radiometric.system, sensor, {}, threads);
  radiometry::ChainFrame frame = chain.run(std::move(radiance), 0, radiometric.stage, border_value, threads);
  report.chain = report_of(radiometric);
  report.chain->timing_ms.assign(frame.timing_ms.begin(), frame.timing_ms.end());
  report.chain->add(frame);
  std::vector<mtf::Image> images;
  images.push_back(std::move(frame.image));
  return images;
}

}  // namespace

int run_simulate(const SimulateOptions& options, const Global& global) {
  if (is_sequence(options)) {
    if (options.memory || options.region)
      throw mtf::UsageError("--memory and --roi are for one image; leave them out of a sequence");
    return run_sequence(options, global);
  }
  RunReport report;
  StopWatch watch(global.progress);
  const mtf::io::SensorConfig config = read_sensor(options.sensor, global);
  std::vector<std::string> inputs = files_of(config);
  inputs.push_back(options.scene);
  const std::vector<std::string> outputs = outputs_of(options);
  require_writable(outputs, inputs);
  const std::shared_ptr<const RadiometricChain> radiometric = radiometric_chain_of(config, options);
  const bool in_tiles = !radiometric && wants_tiles(options);
  if (radiometric && options.memory)
    throw mtf::UsageError(
        "--memory: tiles hold the filtered scene; a sensor with [detector] takes the whole image. "
        "Remove --memory, or [detector] and what belongs to it");
  if (in_tiles)
    for (const char* suffix : {".part", ".part.tiles"}) {  // where finished tiles are kept
      for (const std::string& input : inputs) require_different(input, options.out + suffix);
      for (const std::string& output : outputs)
        if (is_same_file(output, options.out + suffix))
          throw mtf::UsageError(one_line(output) + ": is where finished tiles of " + one_line(options.out) +
                                " are kept; give it another name");
    }
  if (in_tiles) return simulate_tiles(options, global, config);
  mtf::io::Scene scene = mtf::io::load_scene(config, options.scene, {options.channel, options.layer, options.part});
  report.warnings = scene.warnings;
  for (std::string& warning : mtf::io::sampling_warnings(config.system, scene.grid))
    report.warnings.push_back(std::move(warning));
  std::vector<mtf::Image> masks = treat_bad_pixels(scene, options.nan, report.bad_pixels);
  if (!report.bad_pixels.empty()) note(global, "note: " + report.bad_pixels);
  watch.lap("read", report.timing_ms);
  mtf::io::SceneDefaults defaults = config.scene;
  if (radiometric) {
    defaults.border_value = to_light(config, *radiometric, scene, masks, options.scene, global.threads);
    watch.lap("light", report.timing_ms);
  }
  const mtf::System<double>& system = radiometric ? radiometric->system : config.system;

  mtf::PlanOptions plan_options;
  plan_options.tolerance = options.tolerance.value_or(plan_options.tolerance);
  plan_options.border = config.scene.border;
  plan_options.rigor = options.measure ? mtf::Rigor::measure : mtf::Rigor::estimate;
  plan_options.aperture = mtf::io::scene_aperture(config.scene, scene.grid);
  plan_options.scene = summarise_all(scene, defaults);
  plan_options.separate_readout = radiometric != nullptr;
  if (radiometric && !options.tolerance && plan_options.scene)
    plan_options.tolerance = radiometric->tolerance(plan_options.tolerance, plan_options.scene->std);
  plan_options.threads = global.threads;
  plan_options.progress = planning_progress(global);
  read_measured(options, global);
  const std::optional<mtf::TiledSensorPlan> tiles =
      radiometric ? std::nullopt : flat_tiles(config, scene, masks, plan_options, report);
  // What a bad pixel reaches is asked of the plan: it has to hold for more than this scene.
  const bool spreads = std::any_of(masks.begin(), masks.end(), [](const mtf::Image& mask) { return mask.size() > 0; });
  if (!tiles && !spreads) plan_options.spectrum = spectrum_of_all(scene, config.scene.border, global.threads);
  const mtf::SensorPlan plan =
      tiles ? tiles->inner() : compile_reachable(options.tolerance.has_value(), plan_options, report.warnings, [&] {
        return mtf::compile_sensor(system, scene.grid, plan_options, radiometric ? radiometric->samples_a_pitch() : 1);
      });
  plan_options.progress = {};
  for (const std::string& text : plan.presample.report().notes) report.warnings.push_back(text);
  for (const std::string& warning : report.warnings) note(global, "warning: " + one_line(warning));
  if (options.measure)
    note(global, "note: --rigor measure chose the method (" + plan.presample.report().method +
                     ") and its FFT plans by timing; results may differ between runs, within the tolerance");
  watch.lap("plan", report.timing_ms);

  std::vector<mtf::Image> images =
      radiometric ? at_its_place(config,
                                 [&] {
                                   return run_chain(*radiometric, plan, std::move(scene.planes.front()),
                                                    defaults.border_value, report, global.threads);
                                 })
      : tiles     ? run_flat_tiles(*tiles, scene, config.scene.border_value, report)
                  : plan.run(std::move(scene.planes), config.scene.border_value, global.threads);
  if (radiometric && report.chain->held.any()) {
    report.warnings.push_back(words(report.chain->held));
    note(global, "warning: " + report.warnings.back());
  }
  for (std::size_t c = 0; c < masks.size(); ++c)
    if (masks[c].size() > 0)
      mtf::propagate_bad_pixels(plan, masks[c], plan_options.tolerance, global.threads, images[c].view());
  std::vector<mtf::Statistics> statistics;
  for (std::size_t c = 0; c < images.size(); ++c) {
    statistics.push_back(mtf::statistics(images[c].view()));
    if (masks[c].size() == 0 && statistics.back().not_finite > 0) refuse_overflow(scene.names[c]);
  }
  watch.lap("run", report.timing_ms);

  const std::vector<std::string> names = output_names(scene.names);
  if (radiometric && options.region)
    for (mtf::Image& image : images) image = cropped(image, *options.region);
  report.config = &config;
  report.scene = &scene;
  report.plan = &plan;
  mtf::io::Metadata metadata = provenance(config, scene, plan, plan_options.tolerance);
  if (radiometric) add_chain(metadata, *radiometric, 0);
  const Written written =
      write_sensor_image(options.out, names, images, metadata, integer_range(radiometric.get(), options));
  write_measured(options, global);
  watch.lap("write", report.timing_ms);

  report.scene_path = options.scene;
  report.out_path = options.out;
  report.tolerance = plan_options.tolerance;
  if (written.scaling) {
    report.scaling = *written.scaling;
    report.clamped = written.clamped;
    report.integer_scaling = "value = gain x file + offset, in " + report.unit();
    note(global, "note: " + std::to_string(report.scaling.bits) +
                     "-bit output, value = " + mtf::format_double(report.scaling.gain) + " x file + " +
                     mtf::format_double(report.scaling.offset) +
                     (report.clamped > 0 ? ", " + std::to_string(report.clamped) + " samples clamped" : ""));
  }
  if (!options.report.empty()) emit(options.report, to_json(report));
  if (options.report == "-") return 0;  // standard output is the report
  if (options.explain) print(tiles ? explain_tiles(plan, report.tiles->plan) : explain_text(plan));
  print_summary(report, names, statistics);
  return 0;
}

}  // namespace apps
