// SPDX-License-Identifier: Apache-2.0

// One whole image: read, compile, run, hand over.

#include "apps/simulate/simulate.h"

#include <algorithm>

#include "apps/simulate/frames/sequence.h"
#include "apps/simulate/output_files.h"
#include "apps/simulate/simulate_parts.h"
#include "apps/simulate/tiles/simulate_tiles.h"
#include "apps/text/message_words.h"
#include "mtf/field/sample_ranges.h"

namespace apps {
namespace {

bool any_bad(const std::vector<mtf::Image>& masks) {
  return std::any_of(masks.begin(), masks.end(), [](const mtf::Image& mask) { return mask.size() > 0; });
}

/// Files that a run reads, but for the channels of the scene.
std::vector<std::string> inputs_of(const mtf::io::SensorConfig& sensor, const SceneSource& scene) {
  std::vector<std::string> inputs = files_of(sensor);
  if (!scene.image)
    for (std::string& file : mtf::io::files_of_image(scene.file)) inputs.push_back(std::move(file));
  return inputs;
}

/// The range of each sample, of a sensor whose defocus goes by it (mtf/field/sample_ranges.h).
std::shared_ptr<const mtf::Image> ranges_of(const SensorRun& sensor, const SceneSource& source,
                                            const SimulateOptions& options) {
  const auto entry = mtf::entry_by_range(sensor.system());
  if (!entry) return nullptr;
  const std::string key = sensor.config().file + ": presample[" + std::to_string(*entry) + "].focus: ";
  if (options.nan == NanPolicy::propagate)
    throw mtf::UsageError(key +
                          "which pixels a bad one reaches is not known where defocus goes by range; use --nan fill");
  if (source.filter || (sensor.chain() && sensor.chain()->loaded.sensor.settings.distortion))
    throw mtf::UsageError(key + "defocus by range takes samples that stay where their ranges are; leave out " +
                          (source.filter ? "the filter of the scene" : "[distortion]"));
  std::string channel = "Z";
  if (sensor.chain())
    if (const auto& scene = sensor.chain()->loaded.sensor.settings.scene; scene && !scene->depth_channel.name.empty())
      channel = scene->depth_channel.name;
  try {
    return std::make_shared<const mtf::Image>(plane_beside(source, channel));
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError(key + error.what());
  }
}

SimulateResult simulate_whole(const SensorRun& sensor, SceneSource& source, const SimulateOptions& options) {
  SimulateResult result;
  RunReport& report = result.report;
  RunWatch watch(options, report);
  const std::string scene_path = source.file;
  Frame frame;
  frame.sensor = sensor;
  frame.region = options.region;
  const std::shared_ptr<const mtf::Image> range_m = ranges_of(sensor, source, options);
  load_own(frame, std::move(source), options.nan, options.threads, &watch);
  const mtf::io::Scene& scene = frame.input->scene;
  report.bad_pixels = frame.input->bad_pixels;
  report.warnings = warnings_of(frame);

  mtf::PlanOptions plan_options = plan_options_of(options, sensor, scene, frame.input->summary);
  plan_options.progress = watch.planning();
  plan_options.range_m = range_m;
  const bool bad = any_bad(frame.input->masks);
  if (sensor.is_linear() && !bad && !range_m && !options.device.device)
    frame.tiles = flat_tiles(sensor.config(), scene, plan_options, report);
  // Which pixels a bad one changes is asked of the plan: it has to hold for more than this scene.
  if (!frame.tiles && !bad) plan_options.spectrum = spectrum_of_all(scene, plan_options.border, options.threads);
  frame.plan = std::make_shared<const mtf::SensorPlan>(
      frame.tiles ? frame.tiles->inner()
                  : compile_reachable(options.tolerance.has_value(), sensor, plan_options, report.warnings, [&] {
                      return mtf::compile_sensor(system_for(sensor, *frame.input), scene.grid, plan_options,
                                                 sensor.samples_a_pitch());
                    }));
  report.plan = frame.plan;
  for (const std::string& text : frame.plan->presample.report().notes) report.warnings.push_back(text);
  for (const std::string& warning : report.warnings) watch.tell_warning(warning);
  if (options.measure)
    watch.note("--rigor measure chose the method (" + frame.plan->presample.report().method +
               ") and its FFT plans by timing; results may differ between runs, within the tolerance");
  watch.tell_stage("plan");

  frame.chain = chain_of(sensor, *frame.plan, options.threads);
  SimulatedImage& image = frame.image;
  image.planes = run_planes(frame, nullptr, options.threads);
  watch.warn(device_words(options.device));
  for (const mtf::Image& plane : image.planes) result.statistics.push_back(mtf::statistics(plane.view()));
  if (frame.tiles) report.tiles->tally = frame.tally;
  report.region = options.region;
  if ((report.chain = sensor.report())) {
    report.chain->timing_ms.assign(frame.counted.timing_ms.begin(), frame.counted.timing_ms.end());
    report.chain->add(frame.counted);
    if (report.chain->held.any())
      watch.warn(words(report.chain->held) +
                 (options.region ? ", counted in the whole image and not in --roi alone" : ""));
    watch.warn(correction_warning(report.chain->correction));
  }
  watch.tell_stage("run");

  result.names = output_names(scene.names);
  image.metadata = sensor.metadata(scene, *frame.plan, plan_options.tolerance, 0, options.region);
  describe_run(report, sensor.config(), facts_of(scene), scene_path, options, plan_options.tolerance);
  const Written written = deliver(options, options.out, result.names, image, sensor.integer_range(options.range));
  if (!image.planes.empty()) result.images.push_back(std::move(image));
  watch.tell_stage("write");
  watch.describe_integers(written);
  return result;
}

}  // namespace

SimulateResult simulate(const mtf::io::SensorConfig& sensor, SceneSource scene, const SimulateOptions& options) {
  if (!scene.image && scene.file.empty())
    throw mtf::UsageError("there is no scene; name a file of it, or give its planes as `image`");
  complete_name(scene);
  if (!options.out.empty()) mtf::io::format_from_extension(options.out);
  if (is_sequence(scene, options)) {
    if (options.memory || options.region)
      throw mtf::UsageError("--memory and --roi are for one image; leave them out of a sequence");
    return simulate_sequence(sensor, scene, options);
  }
  const std::vector<std::string> inputs = inputs_of(sensor, scene);
  std::vector<std::string> outputs = options.also_written;
  if (!options.out.empty()) {
    const std::vector<std::string> files = mtf::io::files_of_image(options.out);
    outputs.insert(outputs.begin(), files.begin(), files.end());
  }
  require_writable(outputs, inputs);
  const SensorRun run(sensor, options.stage);
  const bool by_range = mtf::entry_by_range(run.system()).has_value();
  if (by_range && options.memory) mtf::refuse_range(run.system(), sensor.file + ": an image in tiles (--memory)");
  if (by_range || !wants_tiles(run, scene, options)) return simulate_whole(run, scene, options);
  if (!options.out.empty())
    for (const char* suffix : {".part", ".part.tiles"}) {  // where finished tiles are kept
      for (const std::string& input : inputs) require_different(input, options.out + suffix);
      for (const std::string& output : outputs)
        if (is_same_file(output, options.out + suffix))
          throw mtf::UsageError(one_line(output) + ": is where finished tiles of " + one_line(options.out) +
                                " are kept; give it another name");
    }
  return simulate_tiles(run, scene, options);
}

}  // namespace apps
