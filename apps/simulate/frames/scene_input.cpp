// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/frames/scene_input.h"

#include "apps/simulate/simulate_parts.h"

namespace apps {
namespace {

bool same_encoding(const std::optional<mtf::io::Encoding>& a, const std::optional<mtf::io::Encoding>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->kind == b->kind && a->gamma == b->gamma && a->stored == b->stored && a->linear == b->linear &&
         a->name == b->name;
}

}  // namespace

SceneInput load_input(SceneSource source, const SensorRun& sensor, NanPolicy nan, int threads, RunWatch* watch) {
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
