// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/fly/flight.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <optional>

#include "apps/scene/heat/stopwatch.h"
#include "apps/sensor/sensor_air.h"
#include "mtf/error.h"
#include "radiometry/heat/weather/instant.h"

namespace apps::scene {
namespace {

namespace render = radiometry::render;

/// What light depends on.
struct LightKey {
  std::int64_t interval = 0;  ///< of the scene's clock
  std::string response{};
  radiometry::Interval band{};
  std::optional<mtf::SettingsTable> air{};  ///< [atmosphere] of the sensor file

  bool operator==(const LightKey& other) const {
    return interval == other.interval && response == other.response && band.lo_um == other.band.lo_um &&
           band.hi_um == other.band.hi_um && air == other.air;
  }
};

/// A scene in one light, and what draws it.
struct Light {
  LightKey key;
  PictureScene scene;
  double temperatures_utc_s = 0.0;
  std::unique_ptr<render::Renderer> renderer{};
};

/// What a sensor file says, worked out once.
struct KnownSensor {
  Flight::Sensor sensor;
  PictureSensor picture;
  Flight::Sensor without_air;  ///< for images of pictures that have the air in them
  std::optional<mtf::SettingsTable> air{};
};

KnownSensor known_sensor(const Flight::Sensor& sensor) {
  KnownSensor known{.sensor = sensor, .picture = picture_sensor(*sensor, PictureQuantity::weighted), .without_air = {}};
  if (const mtf::SettingsTable* air = mtf::find_table(sensor->tables, "atmosphere")) known.air = *air;
  known.without_air = std::make_shared<const mtf::io::SensorConfig>(without_path(*sensor));
  return known;
}

}  // namespace

struct Flight::State {
  PictureSource& source;
  SceneFile file;
  PictureOptions air;
  FlightOptions options;
  LiveSimulation simulation;
  std::optional<KnownSensor> last_sensor{}, next_sensor{};  ///< of the last frame, and of prepare()
  std::unique_ptr<Light> light{};
  std::optional<LightKey> coming_key{};
  std::future<std::unique_ptr<Light>> coming{};

  const KnownSensor& known(const Sensor& sensor);
  LightKey key_of(const KnownSensor& sensor, double utc_s) const;
  std::unique_ptr<Light> made(const LightKey& key, const PictureSensor& sensor,
                              const std::shared_ptr<const render::Renderer::Known>& views);
  void require_time(double utc_s) const;
  render::Camera camera(const PictureSensor& sensor, const CameraPlace& place) const;
  void set_light(const KnownSensor& sensor, double utc_s, FlightFrame& frame);
};

const KnownSensor& Flight::State::known(const Sensor& sensor) {
  for (const std::optional<KnownSensor>* one : {&last_sensor, &next_sensor})
    if (*one && (*one)->sensor == sensor) return **one;
  next_sensor = known_sensor(sensor);
  return *next_sensor;
}

LightKey Flight::State::key_of(const KnownSensor& sensor, double utc_s) const {
  return {static_cast<std::int64_t>(std::floor((utc_s - options.begin_s) / options.light_every_s)),
          sensor.picture.response, sensor.picture.band.curves.band, sensor.air};
}

std::unique_ptr<Light> Flight::State::made(const LightKey& key, const PictureSensor& sensor,
                                           const std::shared_ptr<const render::Renderer::Known>& views) {
  PictureOptions with = air;
  with.sensor_air = sensor.air;
  with.sensor_file = sensor.config.file;
  const double middle = options.begin_s + (static_cast<double>(key.interval) + 0.5) * options.light_every_s;
  double utc_s = std::clamp(middle, options.begin_s, std::max(options.begin_s, options.end_s));
  if (const auto span = source.temperatures_span_utc_s()) utc_s = std::clamp(utc_s, (*span)[0], (*span)[1]);
  auto out = std::make_unique<Light>(Light{key, source.at(utc_s, with), utc_s});
  const render::RenderScene& scene = out->scene.scene;
  out->renderer = views ? std::make_unique<render::Renderer>(scene, std::vector{sensor.band}, *views)
                        : std::make_unique<render::Renderer>(scene, std::vector{sensor.band}, options.render);
  return out;
}

void Flight::State::require_time(double utc_s) const {
  constexpr double kSlack_s = 1e-3;
  if (utc_s >= options.begin_s - kSlack_s && utc_s <= options.end_s + kSlack_s) return;
  using radiometry::heat::instant_text;
  throw mtf::UsageError("a frame at " + instant_text(utc_s) + " is outside of its flight, which goes from " +
                        instant_text(options.begin_s) + " to " + instant_text(options.end_s) +
                        "; state begin_s and end_s");
}

render::Camera Flight::State::camera(const PictureSensor& sensor, const CameraPlace& place) const {
  return picture_camera(sensor,
                        {.position = place.position_m,
                         .look_at = place.look_at_m,
                         .up = file.camera ? file.camera->up : radiometry::scene::Vector{0.0, 0.0, 1.0}},
                        options.samples_per_pitch);
}

void Flight::State::set_light(const KnownSensor& sensor, double utc_s, FlightFrame& frame) {
  const LightKey key = key_of(sensor, utc_s);
  if (light && light->key == key) return;
  frame.new_light = true;
  if (coming_key == key) {
    frame.late = coming.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
    coming_key.reset();
    light = coming.get();
  } else {
    frame.late = true;
    light = made(key, sensor.picture, light ? light->renderer->known() : nullptr);
  }
}

Flight::Flight(PictureSource& source, const SceneFile& file, const PictureOptions& air, const FlightOptions& options)
    : state_(std::make_unique<State>(State{.source = source,
                                           .file = file,
                                           .air = air,
                                           .options = options,
                                           .simulation = LiveSimulation(options.image)})) {
  if (!(options.light_every_s > 0.0)) throw mtf::UsageError("a flight's light is kept for more than 0 s");
}
Flight::~Flight() = default;

void Flight::prepare(const Sensor& sensor, double utc_s) {
  State& state = *state_;
  state.require_time(utc_s);
  if (!state.light) return;
  const KnownSensor& known = state.known(sensor);
  const LightKey key = state.key_of(known, utc_s);
  if (state.light->key == key || state.coming_key == key) return;
  const bool busy = state.coming.valid() && state.coming.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
  if (busy) return;
  state.coming_key = key;
  state.coming =
      std::async(std::launch::async, [&state, key, picture = known.picture, views = state.light->renderer->known()] {
        return state.made(key, picture, views);
      });
}

FlightFrame Flight::frame(const Sensor& sensor, const CameraPlace& place, double utc_s, std::int64_t number) {
  State& state = *state_;
  state.require_time(utc_s);
  FlightFrame out;
  const Stopwatch preparing;
  if (!state.last_sensor || state.last_sensor->sensor != sensor) state.last_sensor = KnownSensor(state.known(sensor));
  const KnownSensor& known = *state.last_sensor;
  state.set_light(known, utc_s, out);
  out.timing_ms.emplace_back("light", preparing.ms());
  Light& light = *state.light;
  const Stopwatch temperatures;
  if (state.source.temperatures_change() &&
      std::abs(utc_s - light.temperatures_utc_s) >= state.options.temperatures_every_s) {
    state.source.temperatures(utc_s, light.scene.scene.temperature_k);
    light.temperatures_utc_s = utc_s;
    light.renderer->temperatures_changed();
  }
  out.timing_ms.emplace_back("temperatures", temperatures.ms());
  require_above_ground(light.scene, place.position_m);
  const render::Camera camera = state.camera(known.picture, place);
  render::RenderedFrame frame = light.renderer->render(camera);
  out.timing_ms.insert(out.timing_ms.end(), frame.timing_ms.begin(), frame.timing_ms.end());
  out.promised = frame.promised.front();
  out.sides = frame.sides;
  out.shaded = frame.shaded;
  const Stopwatch imaging;
  light.scene.utc_s = utc_s;  // that of the picture
  const mtf::io::Metadata metadata =
      picture_metadata(state.file, light.scene, known.picture, camera, state.options.render, frame);
  const bool has_air = light.scene.scene.air.has_value();
  out.image = state.simulation.image(scene_of(std::move(frame), known.picture, camera, metadata),
                                     has_air ? known.without_air : known.sensor, number);
  out.tolerance = state.simulation.plan().options.tolerance;
  out.warnings = state.simulation.warnings();
  if (out.new_light) out.warnings.insert(out.warnings.end(), light.scene.warnings.begin(), light.scene.warnings.end());
  out.timing_ms.emplace_back("sensor", imaging.ms());
  return out;
}

void Flight::require_place(const CameraPlace& place) const {
  if (!state_->light) throw mtf::UsageError("a flight knows no places before its first frame");
  state_->camera(state_->last_sensor->picture, place);
  require_above_ground(state_->light->scene, place.position_m);
  render::require_outside(state_->light->scene.scene, place.position_m);
}

const std::vector<std::pair<std::string, std::string>>& Flight::closures() const {
  if (!state_->light) throw mtf::UsageError("a flight has no closures before its first frame");
  return state_->light->scene.closures;
}
IntegerRange Flight::integer_range() const { return state_->simulation.integer_range(); }
const std::vector<std::string>& Flight::names() const { return state_->simulation.names(); }
int Flight::plans_compiled() const { return state_->simulation.plans_compiled(); }
int Flight::plans_updated() const { return state_->simulation.plans_updated(); }

}  // namespace apps::scene
