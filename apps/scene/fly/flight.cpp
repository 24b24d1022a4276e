// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/fly/flight.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <tuple>

#include "apps/scene/render/picture_scene.h"
#include "apps/sensor/sensor_air.h"
#include "mtf/error.h"
#include "mtf/settings.h"
#include "mtf/work/stop.h"
#include "mtf/work/stopwatch.h"
#include "radiometry/render/renderer.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace render = radiometry::render;

// A scene in the light of one time: what a flight makes once for some time of the scene's clock.

/// What light depends on.
struct LightKey {
  std::int64_t interval = 0;  ///< of the scene's clock
  std::string response{};
  radiometry::Interval band{};
  std::optional<mtf::SettingsTable> air{};  ///< [atmosphere] of the sensor file

  bool operator==(const LightKey& other) const { return interval == other.interval && same_but_for_time(other); }
  bool same_but_for_time(const LightKey& other) const {
    return response == other.response && band.lo_um == other.band.lo_um && band.hi_um == other.band.hi_um &&
           air == other.air;
  }
};

/// A scene in one light, and what draws it.
struct Light {
  LightKey key;
  PictureScene scene;
  double temperatures_utc_s = 0.0;
  std::unique_ptr<render::Renderer> renderer{};
};

// The views of sides that a camera will see, worked out in the background in a copy of the scene, and taken over by the
// renderer of the frames once they are there.

class LookAhead {
 public:
  LookAhead() = default;
  LookAhead(const LookAhead&) = delete;
  LookAhead& operator=(const LookAhead&) = delete;
  ~LookAhead() { enough_ = ended_ = true; }  // the future waits for the work

  /// True from begin() until take() has handed over what was found.
  bool is_working() const { return found_.valid(); }
  /// Starts a thread that calls `make` for a copy of the scene and renders it from each camera in turn. Only where
  /// is_working() is false.
  void begin(std::vector<render::Camera> cameras, std::function<std::unique_ptr<Light>()> make) {
    enough_ = false;
    found_ = std::async(std::launch::async, [this, cameras = std::move(cameras), make = std::move(make)] {
      const mtf::StopScope scope(&ended_);
      Found found;
      const std::unique_ptr<Light> copy = make();
      for (const render::Camera& camera : cameras) {
        try {
          require_above_ground(copy->scene, camera.position);
          copy->renderer->render(camera);
        } catch (const mtf::UsageError&) {  // there is no picture from there
        }
        found.looked_from.push_back(camera);
        if (enough_) break;  // not before the first one: frame after frame, all of them have their turn
      }
      found.known = copy->renderer->known();
      return found;
    });
  }
  /// The thread ends once the picture that it renders now is done.
  void enough() { enough_ = true; }
  /// Gives the views that were found to `renderer`, if the thread has ended; else does nothing.
  void take(render::Renderer& renderer) {
    if (!found_.valid() || found_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    try {
      Found found = found_.get();
      renderer.learn(*found.known);
      looked_from_.insert(looked_from_.end(), found.looked_from.begin(), found.looked_from.end());
    } catch (const std::exception&) {  // such as too little memory for a copy: frames do without
    }
  }
  /// Whether a camera with the same lens and format, less than `near_m` away from this one and pointing in nearly the
  /// same direction (cosine above 0.999), has had its turn; it may be in a place that there is no picture from.
  bool has_seen(const render::Camera& camera, double near_m) const {
    using radiometry::scene::operator-;
    constexpr double kSameDirection = 0.999;
    return std::any_of(looked_from_.begin(), looked_from_.end(), [&](const render::Camera& other) {
      return radiometry::scene::length(camera.position - other.position) < near_m &&
             radiometry::scene::dot(camera.ahead, other.ahead) > kSameDirection && camera.step_x == other.step_x &&
             camera.step_y == other.step_y && camera.width == other.width && camera.height == other.height;
    });
  }
  void forget() { looked_from_.clear(); }  ///< for another light, which needs views of its own

 private:
  struct Found {
    std::shared_ptr<const render::Renderer::Known> known{};
    std::vector<render::Camera> looked_from{};
  };

  std::vector<render::Camera> looked_from_{};
  std::atomic<bool> enough_{false}, ended_{false};
  std::future<Found> found_{};
};

/// A picture that was made, kept for sensors that change while it does not.
struct SeenPicture {
  render::Camera camera{};
  int points = 0;         ///< n x n of a sample
  std::size_t light = 0;  ///< number of the light
  double temperatures_utc_s = 0.0;
  render::RenderedFrame frame{};
};

/// All but its layers and times.
render::RenderedFrame clone(const render::RenderedFrame& frame) {
  render::RenderedFrame copy{
      .promised = frame.promised, .reflected_k = frame.reflected_k, .view_rays = frame.view_rays, .sides = frame.sides};
  copy.radiance.push_back(frame.radiance.front().clone());
  return copy;
}

bool same_view(const render::Camera& a, const render::Camera& b) {
  const auto values = [](const render::Camera& c) {
    return std::tie(c.position, c.ahead, c.right, c.down, c.width, c.height, c.step_x, c.step_y, c.axis_x, c.axis_y);
  };
  return values(a) == values(b);
}

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

/// The simulation of images that have as many samples a pitch and points a sample: their plans are of another grid, and
/// of another blur of the samples.
struct SampledSimulation {
  double samples_per_pitch = 0.0;
  int points = 0;
  LiveSimulation simulation;
};

struct Flight::State {
  PictureSource& source;
  SceneFile file;
  PictureOptions air;
  FlightOptions options;
  std::vector<SampledSimulation> simulations{};             ///< the one of the last frame first
  std::optional<KnownSensor> last_sensor{}, next_sensor{};  ///< of the last frame, and of prepare()
  std::unique_ptr<Light> light{};
  std::size_t lights = 0;  ///< so far
  std::optional<SeenPicture> seen{};
  std::optional<render::Camera> last_camera{};  ///< that saw something
  std::optional<LightKey> coming_key{};
  std::future<std::unique_ptr<Light>> coming{};
  std::size_t ahead_light = 0;  ///< number of the light that `ahead` is of
  LookAhead ahead{};            ///< the last member, as its work uses the others

  const KnownSensor& known(const Sensor& sensor);
  LightKey key_of(const KnownSensor& sensor, double utc_s) const;
  std::unique_ptr<Light> made(const LightKey& key, const PictureSensor& sensor,
                              const std::shared_ptr<const render::Renderer::Known>& views) const;
  void require_time(double utc_s) const;
  render::Camera camera(const PictureSensor& sensor, const CameraPlace& place, double samples_per_pitch) const;
  void set_light(const KnownSensor& sensor, double utc_s, bool may_lag, FlightFrame& frame);
  /// Begins to make that light in the background, unless another one is being made; with what the camera of the last
  /// picture sees in it, where `looked_at`: temperatures of another hour are other patches, which every side sees anew.
  void begin_light(const LightKey& key, const KnownSensor& sensor, bool looked_at);
  render::RenderedFrame rendered(const render::Camera& camera, int points);
  LiveSimulation& simulation_of(double samples_per_pitch, int points);
  const LiveSimulation& last_simulation() const;
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
                                           const std::shared_ptr<const render::Renderer::Known>& views) const {
  PictureOptions with = air;
  with.sensor_air = sensor.air;
  with.sensor_file = sensor.config.file;
  const double middle = options.begin_s + (static_cast<double>(key.interval) + 0.5) * options.light_every_s;
  double utc_s = std::clamp(middle, options.begin_s, std::max(options.begin_s, options.end_s));
  if (const auto span = source.temperatures_span_utc_s()) utc_s = std::clamp(utc_s, (*span)[0], (*span)[1]);
  auto out = std::make_unique<Light>(Light{key, source.at(utc_s, with), utc_s});
  add_band_limits(file, sensor.band.curves.band, out->scene);
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

render::Camera Flight::State::camera(const PictureSensor& sensor, const CameraPlace& place,
                                     double samples_per_pitch) const {
  return picture_camera(sensor,
                        {.position = place.position_m,
                         .look_at = place.look_at_m,
                         .up = file.camera ? file.camera->up : radiometry::scene::Vector{0.0, 0.0, 1.0}},
                        samples_per_pitch);
}

void Flight::State::begin_light(const LightKey& key, const KnownSensor& sensor, bool looked_at) {
  const bool busy = coming.valid() && coming.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
  if (busy) return;
  coming_key = key;
  coming = std::async(std::launch::async, [this, key, picture = sensor.picture, views = light->renderer->known(),
                                           camera = looked_at ? last_camera : std::nullopt] {
    auto made_light = made(key, picture, views);
    if (camera) made_light->renderer->render(*camera);
    return made_light;
  });
}

void Flight::State::set_light(const KnownSensor& sensor, double utc_s, bool may_lag, FlightFrame& frame) {
  const LightKey key = key_of(sensor, utc_s);
  if (light && light->key == key) return;
  if (may_lag && light && light->key.same_but_for_time(key)) {
    // What has been made by now is nearer to what is wanted than the present one.
    const bool ready = coming_key && coming_key->same_but_for_time(key) &&
                       coming.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    if (ready) {
      coming_key.reset();
      light = coming.get();
      ++lights;
      frame.new_light = true;
    }
    frame.light_lags = !(light->key == key);
    if (frame.light_lags && coming_key != key) begin_light(key, sensor, true);
    return;
  }
  frame.new_light = true;
  ++lights;
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
    : state_(new State{.source = source, .file = file, .air = air, .options = options}) {  // made in place
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
  state.begin_light(key, known, false);
}

void Flight::look_ahead(std::span<const CameraPlace> places) {
  State& state = *state_;
  if (!state.light || state.coming_key) return;
  const Light& light = *state.light;
  state.ahead.take(*light.renderer);
  if (state.ahead_light != state.lights) state.ahead.forget();
  state.ahead_light = state.lights;
  if (state.ahead.is_working()) return;
  const PictureSensor& sensor = state.last_sensor->picture;
  std::vector<render::Camera> cameras;
  for (const CameraPlace& place : places) try {
      const render::Camera camera = state.camera(sensor, place, 1.0);
      if (!state.ahead.has_seen(camera, 0.02 * light.scene.scene.facets().half_extent_m)) cameras.push_back(camera);
    } catch (const mtf::UsageError&) {  // no camera can be there
    }
  if (cameras.empty()) return;
  state.ahead.begin(std::move(cameras), [&state, key = light.key, sensor, views = light.renderer->known()] {
    return state.made(key, sensor, views);
  });
}

render::RenderedFrame Flight::State::rendered(const render::Camera& camera, int points) {
  if (seen && seen->light == lights && seen->temperatures_utc_s == light->temperatures_utc_s &&
      seen->points == points && same_view(seen->camera, camera))
    return clone(seen->frame);
  seen.reset();
  render::RenderedFrame frame = light->renderer->render(camera, points);
  last_camera = camera;
  if (options.keep_radiance) seen = SeenPicture{camera, points, lights, light->temperatures_utc_s, clone(frame)};
  return frame;
}

LiveSimulation& Flight::State::simulation_of(double samples_per_pitch, int points) {
  constexpr std::size_t kKept = 2;  // while a camera moves, and at rest
  const auto found = std::find_if(simulations.begin(), simulations.end(), [&](const SampledSimulation& one) {
    return one.samples_per_pitch == samples_per_pitch && one.points == points;
  });
  if (found == simulations.end()) {
    simulations.insert(simulations.begin(), {samples_per_pitch, points, LiveSimulation(options.image)});
    if (simulations.size() > kKept) simulations.pop_back();
  } else {
    std::rotate(simulations.begin(), found, found + 1);
  }
  return simulations.front().simulation;
}

const LiveSimulation& Flight::State::last_simulation() const {
  if (simulations.empty()) throw mtf::UsageError("a flight has no images before its first frame");
  return simulations.front().simulation;
}

void Flight::set_image(const SimulateOptions& options) {
  state_->options.image = options;
  state_->simulations.clear();
}

FlightFrame Flight::frame(const Sensor& sensor, const CameraPlace& place, double utc_s, std::int64_t number,
                          const FrameChoice& choice) {
  State& state = *state_;
  const mtf::StopScope views_are_whole(choice.stop_image != nullptr ? nullptr : mtf::stop_flag());
  state.require_time(utc_s);
  state.ahead.enough();
  if (state.light) state.ahead.take(*state.light->renderer);
  FlightFrame out;
  const mtf::Stopwatch preparing;
  if (!state.last_sensor || state.last_sensor->sensor != sensor) state.last_sensor = KnownSensor(state.known(sensor));
  const KnownSensor& known = *state.last_sensor;
  state.set_light(known, utc_s, choice.light_may_lag, out);
  out.timing_ms.emplace_back("light", preparing.ms());
  Light& light = *state.light;
  const mtf::Stopwatch temperatures;
  if (state.source.temperatures_change() &&
      std::abs(utc_s - light.temperatures_utc_s) >= state.options.temperatures_every_s) {
    state.source.temperatures(utc_s, light.scene.scene.temperature_k);
    light.temperatures_utc_s = utc_s;
    light.renderer->temperatures_changed();
  }
  out.timing_ms.emplace_back("temperatures", temperatures.ms());
  require_above_ground(light.scene, place.position_m);
  const double samples_per_pitch = choice.samples_per_pitch.value_or(state.options.samples_per_pitch);
  const render::Camera camera = state.camera(known.picture, place, samples_per_pitch);
  render::RenderOptions how = state.options.render;
  how.points = choice.points.value_or(how.points);
  render::RenderedFrame frame = state.rendered(camera, how.points);
  out.timing_ms.insert(out.timing_ms.end(), frame.timing_ms.begin(), frame.timing_ms.end());
  out.promised = frame.promised.front();
  out.reflected_k = frame.reflected_k.front();
  out.view_rays = frame.view_rays;
  out.sides = frame.sides;
  out.shaded = frame.shaded;
  const mtf::Stopwatch imaging;
  light.scene.utc_s = utc_s;  // that of the picture
  const mtf::io::Metadata metadata = picture_metadata(state.file, light.scene, known.picture, camera, how, frame);
  const bool has_air = light.scene.scene.air.has_value();
  LiveSimulation& simulation = state.simulation_of(samples_per_pitch, how.points);
  mtf::io::Scene radiance = scene_of(std::move(frame), known.picture, camera, metadata);
  if (state.options.keep_radiance) {
    out.radiance = facts_of(radiance);
    out.radiance->planes.push_back(radiance.planes.front().clone());
  }
  const mtf::StopScope of_image(choice.stop_image != nullptr ? choice.stop_image : mtf::stop_flag());
  out.image =
      simulation.image(std::move(radiance), has_air ? known.without_air : known.sensor, number, choice.correction);
  out.correction_lags = simulation.correction_lags();
  out.tolerance = simulation.plan().options.tolerance;
  out.warnings = simulation.warnings();
  if (out.new_light) out.warnings.insert(out.warnings.end(), light.scene.warnings.begin(), light.scene.warnings.end());
  out.timing_ms.emplace_back("sensor", imaging.ms());
  return out;
}

void Flight::require_place(const CameraPlace& place) const {
  if (!state_->light) throw mtf::UsageError("a flight knows no places before its first frame");
  state_->camera(state_->last_sensor->picture, place, state_->options.samples_per_pitch);
  require_above_ground(state_->light->scene, place.position_m);
  render::require_outside(state_->light->scene.scene, place.position_m);
}

const std::vector<std::pair<std::string, std::string>>& Flight::closures() const {
  if (!state_->light) throw mtf::UsageError("a flight has no closures before its first frame");
  return state_->light->scene.closures;
}
IntegerRange Flight::integer_range() const { return state_->last_simulation().integer_range(); }
const std::vector<std::string>& Flight::names() const { return state_->last_simulation().names(); }
const mtf::SensorPlan& Flight::plan() const { return state_->last_simulation().plan(); }
int Flight::plans_compiled() const {
  int count = 0;
  for (const SampledSimulation& one : state_->simulations) count += one.simulation.plans_compiled();
  return count;
}
int Flight::plans_updated() const {
  int count = 0;
  for (const SampledSimulation& one : state_->simulations) count += one.simulation.plans_updated();
  return count;
}

}  // namespace apps::scene
