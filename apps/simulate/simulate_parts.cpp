// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/simulate_parts.h"

#include <algorithm>
#include <utility>

#include "apps/sensor/sensor_place.h"
#include "apps/simulate/simulate.h"
#include "apps/text/message_words.h"
#include "mtf/engines/fft/scene_spectrum.h"
#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/survey/bad_pixels.h"

namespace apps {
namespace {
std::vector<mtf::Image> through_chain(Frame& frame, radiometry::ChainState* state, int threads) {
  const SceneInput& input = *frame.input;
  const auto number = static_cast<std::uint32_t>(frame.number);
  const radiometry::OutputStage stage = frame.sensor.chain()->stage;
  frame.counted = at_its_place(frame.sensor.config(), [&] {
    if (frame.kept != nullptr)
      return frame.chain->run(*frame.kept, number, stage, input.border_value, threads, state, frame.noise_rows,
                              frame.whole_levels);
    mtf::Image light =
        frame.own != nullptr ? std::move(frame.own->scene.planes.front()) : input.scene.planes.front().clone();
    return frame.chain->run(std::move(light), number, stage, input.border_value, threads, state, frame.whole_levels);
  });
  std::vector<mtf::Image> images;
  images.push_back(std::move(frame.counted.image));
  return images;
}

/// What the chain or the plan has made, as it is handed on.
std::vector<mtf::Image> finished(const Frame& frame, std::vector<mtf::Image> images, int threads) {
  const SceneInput& input = *frame.input;
  for (std::size_t c = 0; c < images.size(); ++c) {
    const mtf::Image& mask = input.masks[c];
    if (mask.size() > 0)
      mtf::propagate_bad_pixels(*frame.plan, mask, frame.plan->options.tolerance, threads, images[c].view());
    if (frame.region) images[c] = cropped(images[c], *frame.region);
    if (mask.size() == 0 && !mtf::all_finite(images[c].view())) refuse_overflow(input.scene.names[c]);
  }
  return images;
}

std::vector<mtf::Image> filtered(Frame& frame, int threads) {
  const SceneInput& input = *frame.input;
  if (frame.kept != nullptr) return frame.plan->run(*frame.kept, input.border_value, threads);
  if (frame.own != nullptr && !frame.tiles)
    return frame.plan->run(std::move(frame.own->scene.planes), input.border_value, threads);
  std::vector<mtf::ImageView<const float>> planes;
  for (const mtf::Image& plane : input.scene.planes) planes.push_back(plane.view());
  return frame.tiles ? frame.tiles->run(planes, input.border_value, &frame.tally)
                     : frame.plan->run(planes, input.border_value, threads);
}

bool same_encoding(const std::optional<mtf::io::Encoding>& a, const std::optional<mtf::io::Encoding>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->kind == b->kind && a->gamma == b->gamma && a->stored == b->stored && a->linear == b->linear &&
         a->name == b->name;
}

/// Takes the scene out of `source`; `watch` hears of the steps "read" and "light" of a run of one image. Throws as
/// take_scene, treat_bad_pixels and SensorRun::light.
SceneInput load_input(SceneSource source, const SensorRun& sensor, NanPolicy nan, int threads,
                      RunWatch* watch = nullptr) {
  SceneInput input;
  input.scene = take_scene(sensor.config(), source);
  input.masks = treat_bad_pixels(input.scene, nan, input.bad_pixels);
  if (nan == NanPolicy::propagate && !input.bad_pixels.empty() && !sensor.is_linear()) {
    const radiometry::SensorSettings& settings = sensor.chain()->loaded.sensor.settings;
    if (settings.distortion || settings.ghost)
      throw mtf::UsageError(sensor.config().file + ": " + (settings.distortion ? "[distortion]" : "[ghost]") +
                            ": moves light, so that the pixels which a bad one reaches are not known; use --nan fill");
  }
  if (watch != nullptr && !input.bad_pixels.empty()) watch->note(input.bad_pixels);
  if (watch != nullptr) watch->tell_stage("read");
  SceneLight light = sensor.light(input.scene, input.masks, source, threads);
  if (watch != nullptr && !sensor.is_linear()) watch->tell_stage("light");
  if (source.filter) source.filter(input.scene);
  input.border_value = light.border_value;
  input.rate = std::move(light.rate);
  input.warnings = std::move(light.warnings);
  input.summary =
      summarise_all(input.scene, sensor.config().scene.border, input.border_value, light.error, input.warnings);
  return input;
}

}  // namespace

mtf::PlanOptions plan_options_of(const SimulateOptions& options, const SensorRun& sensor, const mtf::io::Scene& scene,
                                 const std::optional<mtf::SceneSummary>& summary) {
  const mtf::io::SceneDefaults& defaults = sensor.config().scene;
  mtf::PlanOptions plan;
  plan.tolerance = sensor.tolerance(options.tolerance, summary ? std::optional(summary->std) : std::nullopt);
  plan.border = defaults.border;
  plan.rigor = options.measure ? mtf::Rigor::measure : mtf::Rigor::estimate;
  plan.aperture = aperture_of(defaults, scene);
  plan.scene = summary;
  plan.separate_readout = !sensor.is_linear();
  plan.device = options.device;
  plan.threads = options.threads;
  return plan;
}

std::string device_words(const mtf::DeviceChoice& choice) {
  const std::optional<std::string> why = choice.device ? choice.device->failure() : std::nullopt;
  return why ? choice.device->info().name + " failed, and the processor did its work then: " + *why : "";
}

mtf::SceneAperture aperture_of(const mtf::io::SceneDefaults& defaults, const mtf::io::Scene& scene) {
  mtf::io::SceneDefaults own = defaults;
  const auto stated = scene.info.attributes.find("mtf:aperture");
  if (stated != scene.info.attributes.end() && (stated->second == "point" || stated->second == "box")) {
    own.aperture = stated->second == "box" ? mtf::io::Aperture::box : mtf::io::Aperture::point;
    own.aperture_size = {};
  }
  return scene_aperture(own, scene.grid);
}

void describe_run(RunReport& report, const mtf::io::SensorConfig& config, mtf::io::Scene scene_facts,
                  const std::string& scene_path, const SimulateOptions& options, double tolerance) {
  report.sensor_file = config.file;
  report.sensor_sha256 = config.sha256;
  report.scene = std::move(scene_facts);
  report.scene_path = scene_path;
  report.out_path = options.out;
  report.tolerance = tolerance;
}

std::string correction_warning(const std::shared_ptr<const radiometry::TwoPoint>& correction) {
  constexpr double kMany = 0.01;  // of the pixels
  if (!correction) return "";
  const auto pixels = correction->gain.size(), bad = std::ssize(correction->bad);
  std::string text;
  if (correction->saturated.any())
    text = "its flat frames are saturated, so that it falsifies pixels that are not: " +
           where_held(correction->saturated) + "; move both flat frames further away from the ends of the range";
  if (static_cast<double>(bad) > kMany * static_cast<double>(pixels))
    text += (text.empty() ? "" : "; ") + std::to_string(bad) + " of " + std::to_string(pixels) +
            " pixels count as bad and are left out of it; raise correction.limit unless they are";
  return text.empty() ? "" : "[correction]: " + text;
}

std::vector<mtf::Image> treat_bad_pixels(mtf::io::Scene& scene, NanPolicy policy, std::string& summary) {
  if (policy == NanPolicy::refuse) require_decoded(scene);
  std::vector<mtf::Image> masks(scene.planes.size());
  std::int64_t total = 0;
  for (std::size_t c = 0; c < scene.planes.size(); ++c) {
    const mtf::Statistics s = mtf::statistics(scene.planes[c].view());
    if (s.not_finite == 0) continue;
    if (policy == NanPolicy::refuse)
      throw mtf::RuntimeError("channel " + scene.names[c] + ": " + std::to_string(s.not_finite) +
                              " pixels are NaN or infinite, the first at column " + std::to_string(s.first_x) +
                              ", row " + std::to_string(s.first_y) +
                              (scene.info.no_data.empty() ? "" : ", or have no data, stored as " + scene.info.no_data) +
                              "; use --nan fill (from neighbours) or --nan propagate");
    if (policy == NanPolicy::propagate) masks[c] = mtf::bad_pixel_mask(scene.planes[c].view());
    total += mtf::fill_bad_pixels(scene.planes[c].view());
  }
  if (total > 0)
    summary = std::to_string(total) + " NaN or infinite pixels were filled from their neighbours" +
              (policy == NanPolicy::propagate ? "; output pixels that depend on them are NaN" : "");
  return masks;
}

std::optional<mtf::SceneSummary> harder_of(std::optional<mtf::SceneSummary> a,
                                           const std::optional<mtf::SceneSummary>& b) {
  if (!a || !b) return a ? a : b;
  a->largest = std::max(a->largest, b->largest / b->std * a->std);
  a->error = std::max(a->error, b->error / b->std * a->std);
  a->deviation = std::max(a->deviation, b->deviation / b->std * a->std);
  a->canvas_norm = std::max(a->canvas_norm, b->canvas_norm / b->std * a->std);
  a->flat_rows = std::min(a->flat_rows, b->flat_rows);
  a->flat_columns = std::min(a->flat_columns, b->flat_columns);
  return a;
}

std::optional<mtf::SceneSummary> summarise_all(const mtf::io::Scene& scene, mtf::Border border, double border_value,
                                               double error, std::vector<std::string>& warnings) {
  std::optional<mtf::SceneSummary> worst;
  for (const mtf::Image& plane : scene.planes)
    worst = harder_of(worst, mtf::summarise(plane.view(), border, border_value));
  // Less contrast than the rounding of float32 is none: such a scene has no std that a tolerance could be a share of.
  constexpr double kRounding = 0x1p-23;
  if (worst && worst->std <= kRounding * worst->largest) {
    warnings.push_back(
        "the scene has less contrast than its values are rounded by in single precision; the promised error is not of "
        "that contrast: take off a constant first");
    return std::nullopt;
  }
  if (worst) worst->error = error;
  return worst;
}

void loosen_default(const mtf::UnreachableTolerance& refusal, const SensorRun& sensor, mtf::PlanOptions& options,
                    std::vector<std::string>& warnings) {
  if (refusal.reachable() > sensor.unseen_tolerance(options.tolerance))
    warnings.push_back("the default tolerance " + significant(options.tolerance, 2) +
                       " cannot be kept for this scene; " + significant(refusal.reachable(), 2) + " is used");
  options.tolerance = refusal.reachable();
}

std::shared_ptr<const mtf::SceneSpectrum> spectrum_of_all(const mtf::io::Scene& scene, mtf::Border border,
                                                          int threads) {
  constexpr std::int64_t kWorthIt = std::int64_t{1} << 26;  // beyond, its memory counts
  std::vector<std::shared_ptr<const mtf::SceneSpectrum>> spectra;
  for (const mtf::Image& plane : scene.planes) {
    if (plane.size() > kWorthIt) return nullptr;
    if (auto spectrum = mtf::scene_spectrum(plane.view(), border, threads)) spectra.push_back(std::move(spectrum));
  }
  return mtf::largest_of(spectra);
}

Written deliver(const SimulateOptions& options, const std::string& file, const std::vector<std::string>& names,
                SimulatedImage& image, const IntegerRange& range) {
  Written written;
  if (!file.empty()) {
    written = write_sensor_image(file, names, image.planes, image.metadata, range);
  } else if (options.sink) {
    std::vector<mtf::ImageView<const float>> views;
    for (const mtf::Image& plane : image.planes) views.push_back(std::as_const(plane).view());
    const mtf::Region whole{0, 0, views.front().width, views.front().height};
    options.sink({image.frame, whole, names, views, image.metadata});
  } else {
    return written;
  }
  if (!options.keep_images) image.planes.clear();
  return written;
}

bool takes_whole_levels(const SimulateOptions& options) {
  return !options.out.empty() && !options.range && !options.keep_images &&
         !mtf::io::holds_floats(mtf::io::format_from_extension(options.out));
}

void RunWatch::Caller::tell(const SimulateEvent& event) {
  const std::scoped_lock guard(lock_);
  if (watch_ && !watch_(event)) throw Cancelled("the run was cancelled by its caller");
}

void RunWatch::Caller::leave() {
  const std::scoped_lock guard(lock_);
  watch_ = nullptr;
}

void RunWatch::note(const std::string& text) {
  report_.notes.push_back(text);
  tell({SimulateEvent::Kind::note, text, 0.0});
}

void RunWatch::warn(const std::string& text) {
  if (text.empty()) return;
  report_.warnings.push_back(text);
  tell_warning(text);
}

void RunWatch::describe_integers(const Written& written) {
  if (!written.scaling) return;
  const mtf::io::IntegerScaling& scaling = report_.scaling = *written.scaling;
  report_.clamped = written.clamped;
  report_.integer_scaling = "value = gain x file + offset, in " + report_.unit();
  note(std::to_string(scaling.bits) + "-bit output, value = " + mtf::format_double(scaling.gain) + " x file + " +
       mtf::format_double(scaling.offset) +
       (written.clamped > 0 ? ", " + std::to_string(written.clamped) + " samples clamped" : ""));
}

void RunWatch::lap(const char* stage) {
  const Clock::time_point now = Clock::now();
  report_.timing_ms.emplace_back(stage, std::chrono::duration<double, std::milli>(now - last_).count());
  last_ = now;
}

void RunWatch::tell_stage(const char* stage) {
  lap(stage);
  tell({SimulateEvent::Kind::stage, stage, report_.timing_ms.back().second});
}

mtf::OtfProgress RunWatch::planning() {
  if (!caller_->watches()) return {};
  return [caller = caller_](std::int64_t values) {
    caller->tell({SimulateEvent::Kind::planning, "planning", static_cast<double>(values)});
  };
}

std::vector<std::string> warnings_of(const SensorRun& sensor, const mtf::io::Scene& scene) {
  std::vector<std::string> warnings = scene.warnings;
  for (std::string& text : mtf::io::sampling_warnings(sensor.config().system, scene.grid))
    warnings.push_back(std::move(text));
  const auto add = [&](std::string text) {
    if (!text.empty()) warnings.push_back(std::move(text));
  };
  add(spectrum_warning(sensor.system(), scene.wavelength_um, !sensor.is_linear()));
  if (sensor.is_linear()) return warnings;
  add(source_warning(sensor.system(), sensor.chain()->loaded, scene.quantity));
  const radiometry::SensorSettings& settings = sensor.chain()->loaded.sensor.settings;
  const mtf::Frame<double>& frame = sensor.config().system.frame;
  const double cy_sample =
      0.5 * std::max(scene.grid.step_x_um / frame.pitch_x_um, scene.grid.step_y_um / frame.pitch_y_um);
  if (const auto& d = settings.distortion; d && (d->k1 != 0.0 || d->k2 != 0.0 || d->k3 != 0.0))
    add("[distortion] interpolates the scene, whose MTF at the Nyquist frequency of the pixels it lowers to as little "
        "as " +
        significant(radiometry::distortion_mtf(std::min(cy_sample, 0.5)), 3) +
        ", which is not in the promised error; give the scene more samples per pitch");
  const double columns = static_cast<double>(scene.grid.width) * scene.grid.step_x_um / frame.pitch_x_um,
               rows = static_cast<double>(scene.grid.height) * scene.grid.step_y_um / frame.pitch_y_um;
  if ((settings.vignetting || settings.distortion || settings.narcissus) &&
      (columns + 1e-9 < frame.columns || rows + 1e-9 < frame.rows))
    add("the scene covers " + significant(columns, 4) + " x " + significant(rows, 4) +
        " pixels from the upper left of " + mtf::size_text(frame.columns, frame.rows) +
        ", about whose middle the sensor file has its vignetting, distortion or narcissus; of a smaller detector "
        "give the size in frame.format");
  if (settings.adc && settings.adc->bits > 24)
    add("[adc] bits = " + std::to_string(settings.adc->bits) +
        ": images hold whole counts up to 2^24, larger ones are rounded to 24 bits");
  return warnings;
}

std::vector<std::string> warnings_of(const Frame& frame) {
  std::vector<std::string> warnings = warnings_of(frame.sensor, frame.input->scene);
  warnings.insert(warnings.end(), frame.input->warnings.begin(), frame.input->warnings.end());
  return warnings;
}

void load_own(Frame& frame, SceneSource source, NanPolicy nan, int threads, RunWatch* watch) {
  const auto input = std::make_shared<SceneInput>(load_input(std::move(source), frame.sensor, nan, threads, watch));
  frame.own = input.get();
  frame.input = input;
}

std::shared_ptr<const radiometry::Chain> chain_of(const SensorRun& sensor, const mtf::SensorPlan& plan, int threads,
                                                  const radiometry::Chain* before, bool keep_shading) {
  if (sensor.is_linear()) return nullptr;
  return at_its_place(sensor.config(), [&] {
    return std::make_shared<const radiometry::Chain>(plan, sensor.system(), sensor.chain()->loaded.sensor,
                                                     radiometry::Origin{}, threads, before, keep_shading);
  });
}

std::vector<mtf::Image> run_planes(Frame& frame, radiometry::ChainState* state, int threads) {
  return finished(frame, frame.chain ? through_chain(frame, state, threads) : filtered(frame, threads), threads);
}

void run_batch(std::span<const std::shared_ptr<Frame>> frames, int threads) {
  const Frame& first = *frames.front();
  const SceneInput& input = *first.input;
  mtf::KeptScene scene({first.input, &input.scene.planes});
  const std::int64_t step = frames.size() > 1 ? frames[1]->number - first.number : 1;
  std::vector<radiometry::ChainFrame> made = at_its_place(first.sensor.config(), [&] {
    return first.chain->run_batch(
        scene, {static_cast<std::uint32_t>(first.number), static_cast<std::uint32_t>(step), std::ssize(frames)},
        first.sensor.chain()->stage, input.border_value, threads, first.whole_levels);
  });
  for (std::size_t i = 0; i < frames.size(); ++i) {
    std::vector<mtf::Image> images;
    images.push_back(std::move(made[i].image));
    frames[i]->counted = std::move(made[i]);
    frames[i]->image.planes = finished(*frames[i], std::move(images), threads);
  }
}

mtf::io::Metadata metadata_of(const Frame& frame) {
  mtf::io::Metadata metadata =
      frame.sensor.metadata(frame.input->scene, *frame.plan, frame.plan->options.tolerance, frame.number);
  metadata.text["mtf:frame"] = std::to_string(frame.number);
  if (!frame.settings.empty()) metadata.text["mtf:schedule"] = frame.settings;
  return metadata;
}

mtf::System<double> system_for(const SensorRun& sensor, const SceneInput& input) {
  mtf::System<double> system = sensor.system();
  if (input.rate) system.band->rate = input.rate;
  return system;
}

bool same_spacing(const mtf::io::SceneDefaults& a, const mtf::io::SceneDefaults& b) {
  return a.sample_x_um == b.sample_x_um && a.sample_y_um == b.sample_y_um;
}

bool same_values(const mtf::io::SceneDefaults& a, const mtf::io::SceneDefaults& b) {
  return same_spacing(a, b) && a.quantity == b.quantity && a.gain == b.gain && a.offset == b.offset &&
         same_encoding(a.encoding, b.encoding) && a.border == b.border && a.border_value == b.border_value;
}

std::shared_ptr<const SceneInput> StillScene::of(const SensorRun& sensor) {
  if (input_ && same_values(sensor_.config().scene, sensor.config().scene) && same_light(sensor_, sensor))
    return input_;
  // A scene that is loaded a second time will probably be loaded often: its file is kept, unless it is very large.
  constexpr std::int64_t kMostSamples = std::int64_t{1} << 28;
  const auto samples = [&] { return std::ssize(input_->scene.planes) * input_->scene.planes.front().size(); };
  if (input_ && !source_.image && !source_.stored && samples() <= kMostSamples)
    source_.stored = std::make_shared<const mtf::io::ImageFile>(mtf::io::read_image(source_.file, source_.read));
  input_ = std::make_shared<const SceneInput>(load_input(clone(source_), sensor, nan_, threads_));
  sensor_ = sensor;
  return input_;
}

}  // namespace apps
