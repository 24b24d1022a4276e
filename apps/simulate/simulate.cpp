// SPDX-License-Identifier: Apache-2.0

// One whole image: read, compile, run, hand over.

#include "apps/simulate/simulate.h"

#include <algorithm>

#include "apps/sensor/sensor_place.h"
#include "apps/simulate/frames/sequence.h"
#include "apps/simulate/image_output.h"
#include "apps/simulate/output_files.h"
#include "apps/simulate/radiometric_chain.h"
#include "apps/simulate/run_watch.h"
#include "apps/simulate/simulate_parts.h"
#include "apps/simulate/tiles/simulate_tiles.h"
#include "apps/text/words.h"
#include "mtf/io/image_io.h"
#include "mtf/survey/bad_pixels.h"

namespace apps {
namespace {

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

bool any_bad(const std::vector<mtf::Image>& masks) {
  return std::any_of(masks.begin(), masks.end(), [](const mtf::Image& mask) { return mask.size() > 0; });
}

/// Files that a run reads, but for the channels of the scene.
std::vector<std::string> inputs_of(const mtf::io::SensorConfig& sensor, const SceneSource& scene) {
  std::vector<std::string> inputs = files_of(sensor);
  if (!scene.image) inputs.push_back(scene.file);
  return inputs;
}

SimulateResult simulate_whole(const mtf::io::SensorConfig& config, SceneSource& source, const SimulateOptions& options,
                              const RadiometricChain* radiometric) {
  SimulateResult result;
  RunReport& report = result.report;
  RunWatch watch(options, report);
  mtf::io::Scene scene = take_scene(config, source);
  report.warnings = scene.warnings;
  for (std::string& warning : mtf::io::sampling_warnings(config.system, scene.grid))
    report.warnings.push_back(std::move(warning));
  std::vector<mtf::Image> masks = treat_bad_pixels(scene, options.nan, report.bad_pixels);
  if (!report.bad_pixels.empty()) watch.note(report.bad_pixels);
  watch.tell_stage("read");
  mtf::io::SceneDefaults defaults = config.scene;
  SceneLight light;
  if (radiometric != nullptr) {
    light = to_light(config, *radiometric, scene, masks, source, options.threads);
    defaults.border_value = light.border_value;
    watch.tell_stage("light");
  }
  if (source.filter) source.filter(scene);
  mtf::System<double> system = radiometric != nullptr ? radiometric->system : config.system;
  if (light.rate) system.band->rate = light.rate;
  for (std::string& warning : light.warnings) report.warnings.push_back(std::move(warning));

  mtf::PlanOptions plan_options = plan_options_of(options, config, scene);
  plan_options.scene = summarise_all(scene, defaults, light.error, report.warnings);
  plan_options.separate_readout = radiometric != nullptr;
  if (radiometric != nullptr && !options.tolerance && plan_options.scene)
    plan_options.tolerance = radiometric->tolerance(plan_options.tolerance, plan_options.scene->std);
  plan_options.progress = watch.planning();
  const std::optional<mtf::TiledSensorPlan> tiles =
      radiometric != nullptr ? std::nullopt : flat_tiles(config, scene, masks, plan_options, report);
  // Which pixels a bad one changes is asked of the plan: it has to hold for more than this scene.
  if (!tiles && !any_bad(masks)) plan_options.spectrum = spectrum_of_all(scene, config.scene.border, options.threads);
  const int samples_a_pitch = radiometric != nullptr ? radiometric->samples_a_pitch() : 1;
  const double unseen = radiometric != nullptr ? radiometric->unseen_tolerance(plan_options.tolerance) : 0.0;
  mtf::SensorPlan plan =
      tiles ? tiles->inner()
            : compile_reachable(options.tolerance.has_value(), unseen, plan_options, report.warnings,
                                [&] { return mtf::compile_sensor(system, scene.grid, plan_options, samples_a_pitch); });
  plan_options.progress = {};
  for (const std::string& text : plan.presample.report().notes) report.warnings.push_back(text);
  for (const std::string& warning : report.warnings) watch.tell_warning(warning);
  if (options.measure)
    watch.note("--rigor measure chose the method (" + plan.presample.report().method +
               ") and its FFT plans by timing; results may differ between runs, within the tolerance");
  watch.tell_stage("plan");

  SimulatedImage image;
  if (radiometric != nullptr)
    image.planes = at_its_place(config, [&] {
      return run_chain(*radiometric, plan, std::move(scene.planes.front()), defaults.border_value, report,
                       options.threads);
    });
  else if (tiles)
    image.planes = run_flat_tiles(*tiles, scene, config.scene.border_value, report);
  else
    image.planes = plan.run(std::move(scene.planes), config.scene.border_value, options.threads);
  if (report.chain && report.chain->held.any())
    watch.warn(words(report.chain->held) +
               (options.region ? ", counted in the whole image and not in --roi alone" : ""));
  for (std::size_t c = 0; c < masks.size(); ++c)
    if (masks[c].size() > 0)
      mtf::propagate_bad_pixels(plan, masks[c], plan_options.tolerance, options.threads, image.planes[c].view());
  if (radiometric != nullptr && options.region) {
    report.region = options.region;
    for (mtf::Image& plane : image.planes) plane = cropped(plane, *options.region);
  }
  for (std::size_t c = 0; c < image.planes.size(); ++c) {
    result.statistics.push_back(mtf::statistics(image.planes[c].view()));
    if (masks[c].size() == 0 && result.statistics.back().not_finite > 0) refuse_overflow(scene.names[c]);
  }
  watch.tell_stage("run");

  result.names = output_names(scene.names);
  image.metadata = provenance(config, scene, plan, plan_options.tolerance);
  if (radiometric != nullptr) add_chain(image.metadata, *radiometric, 0);
  describe_run(report, config, facts_of(scene), source.file, options, plan_options.tolerance);
  report.plan = std::make_shared<const mtf::SensorPlan>(std::move(plan));
  const Written written = deliver(options, options.out, result.names, image, integer_range(radiometric, options));
  if (!image.planes.empty()) result.images.push_back(std::move(image));
  watch.tell_stage("write");
  if (written.scaling) {
    describe_integers(report, written);
    watch.note(std::to_string(report.scaling.bits) + "-bit output, value = " + mtf::format_double(report.scaling.gain) +
               " x file + " + mtf::format_double(report.scaling.offset) +
               (report.clamped > 0 ? ", " + std::to_string(report.clamped) + " samples clamped" : ""));
  }
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
  if (!options.out.empty()) outputs.insert(outputs.begin(), options.out);
  require_writable(outputs, inputs);
  const std::shared_ptr<const RadiometricChain> radiometric = radiometric_chain_of(sensor, options.stage);
  if (!wants_tiles(sensor, scene, options, radiometric.get()))
    return simulate_whole(sensor, scene, options, radiometric.get());
  if (!options.out.empty())
    for (const char* suffix : {".part", ".part.tiles"}) {  // where finished tiles are kept
      for (const std::string& input : inputs) require_different(input, options.out + suffix);
      for (const std::string& output : outputs)
        if (is_same_file(output, options.out + suffix))
          throw mtf::UsageError(one_line(output) + ": is where finished tiles of " + one_line(options.out) +
                                " are kept; give it another name");
    }
  return simulate_tiles(sensor, scene, options, radiometric.get());
}

}  // namespace apps
