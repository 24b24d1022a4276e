// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/frames/scene_input.h"

#include "apps/simulate/simulate_parts.h"
#include "mtf/same_list.h"

namespace apps {
namespace {

bool same_encoding(const std::optional<mtf::io::Encoding>& a, const std::optional<mtf::io::Encoding>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->kind == b->kind && a->gamma == b->gamma && a->stored == b->stored && a->linear == b->linear &&
         a->name == b->name;
}

}  // namespace

SceneInput load_input(SceneSource source, const mtf::io::SensorConfig& sensor, const RadiometricChain* radiometric,
                      NanPolicy nan, int threads) {
  SceneInput input{.scene = take_scene(sensor, source),
                   .masks = {},
                   .bad_pixels = {},
                   .summary = {},
                   .border_value = sensor.scene.border_value};
  input.masks = treat_bad_pixels(input.scene, nan, input.bad_pixels);
  mtf::io::SceneDefaults defaults = sensor.scene;
  SceneLight light;
  if (radiometric != nullptr) {
    light = to_light(sensor, *radiometric, input.scene, input.masks, source, threads);
    defaults.border_value = input.border_value = light.border_value;
  }
  if (source.filter) source.filter(input.scene);
  input.rate = light.rate;
  for (std::string& warning : light.warnings) input.scene.warnings.push_back(std::move(warning));
  input.summary = summarise_all(input.scene, defaults, light.error, input.scene.warnings);
  return input;
}

bool same_spacing(const mtf::io::SceneDefaults& a, const mtf::io::SceneDefaults& b) {
  return a.sample_x_um == b.sample_x_um && a.sample_y_um == b.sample_y_um;
}

bool same_values(const mtf::io::SceneDefaults& a, const mtf::io::SceneDefaults& b) {
  return same_spacing(a, b) && a.quantity == b.quantity && a.gain == b.gain && a.offset == b.offset &&
         same_encoding(a.encoding, b.encoding) && a.border == b.border && a.border_value == b.border_value;
}

std::shared_ptr<const SceneInput> StillScene::of(const std::shared_ptr<const mtf::io::SensorConfig>& sensor,
                                                 const RadiometricChain* radiometric) {
  const bool light = radiometric != nullptr;
  const bool serves = input_ && light == light_ && same_values(sensor_->scene, sensor->scene) &&
                      (!light || same_light(*sensor_, *sensor)) &&
                      (!light || !radiometric->loaded.paths ||
                       mtf::same_list(sensor_->system, sensor->system, mtf::Stage::presample));  // `rate` is of it
  if (serves) return input_;
  // A scene that is loaded a second time will probably be loaded often: its file is kept, unless it is very large.
  constexpr std::int64_t kMostSamples = std::int64_t{1} << 28;
  const auto samples = [&] { return std::ssize(input_->scene.planes) * input_->scene.planes.front().size(); };
  if (input_ && !source_.image && !source_.stored && samples() <= kMostSamples)
    source_.stored = std::make_shared<const mtf::io::ImageFile>(mtf::io::read_image(source_.file, source_.read));
  input_ = std::make_shared<const SceneInput>(load_input(clone(source_), *sensor, radiometric, nan_, threads_));
  sensor_ = sensor;
  light_ = light;
  return input_;
}

}  // namespace apps
