// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/frames/sensor_frame.h"

#include <utility>

#include "apps/sensor/sensor_place.h"
#include "apps/simulate/simulate_parts.h"
#include "mtf/survey/bad_pixels.h"

namespace apps {
namespace {

std::vector<mtf::Image> through_chain(Frame& frame, radiometry::ChainState* state, int threads) {
  const SceneInput& input = *frame.input;
  const auto number = static_cast<std::uint32_t>(frame.number);
  const radiometry::OutputStage stage = frame.sensor.chain()->stage;
  frame.counted = at_its_place(frame.sensor.config(), [&] {
    if (frame.kept != nullptr)
      return frame.chain->run(*frame.kept, number, stage, input.border_value, threads, state, frame.noise_rows);
    mtf::Image light =
        frame.own != nullptr ? std::move(frame.own->scene.planes.front()) : input.scene.planes.front().clone();
    return frame.chain->run(std::move(light), number, stage, input.border_value, threads, state);
  });
  std::vector<mtf::Image> images;
  images.push_back(std::move(frame.counted.image));
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

std::vector<std::string> warnings_of(const Frame& frame) {
  std::vector<std::string> warnings = frame.input->scene.warnings;
  for (std::string& text : mtf::io::sampling_warnings(frame.sensor.config().system, frame.input->scene.grid))
    warnings.push_back(std::move(text));
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
  const SceneInput& input = *frame.input;
  std::vector<mtf::Image> images = frame.chain ? through_chain(frame, state, threads) : filtered(frame, threads);
  for (std::size_t c = 0; c < images.size(); ++c) {
    const mtf::Image& mask = input.masks[c];
    if (mask.size() > 0)
      mtf::propagate_bad_pixels(*frame.plan, mask, frame.plan->options.tolerance, threads, images[c].view());
    if (frame.region) images[c] = cropped(images[c], *frame.region);
    if (mask.size() == 0 && !mtf::all_finite(images[c].view())) refuse_overflow(input.scene.names[c]);
  }
  return images;
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
