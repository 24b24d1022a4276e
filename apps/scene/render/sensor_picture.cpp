// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/render/sensor_picture.h"

#include <cmath>

#include "apps/sensor/sensor_air.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/sensor/sensor_place.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/file_checks.h"
#include "mtf/version.h"
#include "mtf/work/usable_memory.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

using mtf::io::Quantity;

constexpr double kMostOfFinest = 0.1;  ///< MTF at the finest detail that samples hold

/// In photons, or watts.
Quantity quantity_of(const PictureSensor& sensor) {
  return sensor.band.curves.flux == radiometry::Flux::watts ? Quantity::radiance : Quantity::photon_radiance;
}

/// Three numbers in the scene's frame, m for places.
std::string words_of(const std::array<double, 3>& v) {
  return mtf::format_double(v[0]) + " " + mtf::format_double(v[1]) + " " + mtf::format_double(v[2]);
}

/// NETD at 300 K, without air, which is in the picture; 0 where the sensor has none.
double netd_k(const mtf::io::SensorConfig& config) {
  constexpr double kScene_k = 300.0;
  try {
    return budget_of(config.system, load_chain(without_path(config)).sensor, kScene_k).netd_k;
  } catch (const mtf::UsageError&) {  // a budget that needs more than the light of a picture
    return 0.0;
  }
}

}  // namespace

PictureSensor picture_sensor(const mtf::io::SensorConfig& config, PictureQuantity quantity) {
  PictureSensor sensor{.config = config, .band = {.name = "Y", .curves = load_curves(config)}, .quantity = quantity};
  const mtf::Frame<double>& frame = config.system.frame;
  if (frame.columns < 1 || frame.rows < 1)
    throw mtf::UsageError(config.file +
                          ": frame.format: missing; the field of view follows from it: write format = [640, 512]");
  const radiometry::SensorSettings settings = radiometry::sensor_settings(config.tables);
  if (quantity == PictureQuantity::radiance) {
    const radiometry::Interval band = sensor.band.curves.band;
    sensor.band.curves = {};
    sensor.band.curves.band = band;
    sensor.band.curves.flux = radiometry::Flux::watts;
  } else {
    if (!settings.detector)
      throw mtf::UsageError(config.file +
                            ": has no [detector], whose response weights the radiance; add it, or write --quantity "
                            "radiance");
    sensor.response = response_sha256(sensor.band.curves);
    if (const double netd = netd_k(config); netd > 0.0 && netd < mtf::kInfinity) sensor.band.noise_k = netd;
  }
  sensor.has_path = settings.path || settings.atmosphere;
  if (settings.atmosphere) sensor.air = at_its_place(config, [&] { return read_air(*settings.atmosphere); });
  return sensor;
}

radiometry::render::Camera picture_camera(const PictureSensor& sensor, const radiometry::render::Pose& pose,
                                          double samples_per_pitch) {
  const mtf::Frame<double>& frame = sensor.config.system.frame;
  return camera_of({.focal_length_mm = frame.focal_length_mm,
                    .pitch_x_um = frame.pitch_x_um,
                    .pitch_y_um = frame.pitch_y_um,
                    .columns = frame.columns,
                    .rows = frame.rows,
                    .samples_per_pitch = samples_per_pitch},
                   pose);
}

std::string memory_words(const mtf::io::SensorConfig& sensor, double samples_per_pitch, double bytes_a_sample) {
  constexpr double kWorthSaying = 1024.0 * 1024.0 * 1024.0;
  const mtf::Frame<double>& frame = sensor.system.frame;
  const double columns = std::ceil(static_cast<double>(frame.columns) * samples_per_pitch);
  const double rows = std::ceil(static_cast<double>(frame.rows) * samples_per_pitch);
  const double bytes = columns * rows * bytes_a_sample;
  const mtf::UsableMemory memory = mtf::usable_memory();
  const std::string words = "pictures of " + mtf::format_double(columns) + " x " + mtf::format_double(rows) +
                            " samples take about " + mtf::io::shown_bytes(bytes) + " of memory, " + memory.whose + " " +
                            mtf::io::shown_bytes(memory.bytes);
  if (bytes > memory.bytes)
    throw mtf::UsageError(words + "; take fewer samples a pitch, a smaller format or fewer layers");
  return bytes > kWorthSaying ? words : "";
}

FinestDetail finest_detail(const PictureSensor& sensor, double samples_per_pitch) {
  const mtf::System<double>& system = sensor.config.system;
  FinestDetail finest;
  for (const mtf::Axis axis : {mtf::Axis::x, mtf::Axis::y}) {
    const double frequency = 500.0 * samples_per_pitch / system.frame.pitch_um(axis);
    const mtf::Complex<double> h =
        system.otf(mtf::Stage::presample,
                   axis == mtf::Axis::x ? mtf::Freq<double>{frequency, 0.0} : mtf::Freq<double>{0.0, frequency});
    if (const double passed = std::hypot(h.re, h.im); passed >= finest.mtf) finest = {frequency, passed};
  }
  return finest;
}

double samples_for(std::span<const PictureSensor> sensors) {
  constexpr double kLeast = 2.0, kMost = 8.0;
  double samples = kLeast;
  for (const PictureSensor& sensor : sensors)
    while (samples < kMost && finest_detail(sensor, samples).mtf > kMostOfFinest) samples += 1.0;
  return samples;
}

std::string sampling_warning(const PictureSensor& sensor, double samples_per_pitch) {
  const FinestDetail finest = finest_detail(sensor, samples_per_pitch);
  if (finest.mtf <= kMostOfFinest) return "";
  const std::string name = sensor.config.system.name.empty() ? sensor.config.file : sensor.config.system.name;
  return one_line(name) + ": its MTF is " + significant(finest.mtf, 2) + " at " +
         significant(finest.frequency_cy_mm, 3) + " cy/mm, the finest detail that " +
         significant(samples_per_pitch, 3) +
         " samples a pitch hold; finer detail of the scene shows as false detail, which no error that is stated "
         "includes: take --samples-per-pitch " +
         significant(2.0 * samples_per_pitch, 3);
}

std::string reflected_warning(const PictureSensor& sensor, double error_k, int rays) {
  if (error_k <= sensor.band.noise_k) return "";
  const std::string name = sensor.config.system.name.empty() ? sensor.config.file : sensor.config.system.name;
  return one_line(name) + ": the light that surfaces reflect errs by " + significant(1e3 * error_k, 2) +
         " mK rms at 300 K, by " + std::to_string(rays) + " rays a side, more than the noise of " +
         significant(1e3 * sensor.band.noise_k, 2) + " mK";
}

radiometry::render::Pose pose_of(const SceneFile& file, const std::optional<radiometry::scene::Point>& position,
                                 const std::optional<radiometry::scene::Point>& look_at) {
  if (!file.camera && !(position && look_at))
    throw mtf::UsageError(one_line(file.file) +
                          ": [camera]: missing; write position = [\"14 m\", \"-12 m\", \"5 m\"] and look_at, or give "
                          "--position and --look-at");
  radiometry::render::Pose pose;
  if (file.camera) pose = {file.camera->position_m, file.camera->look_at_m, file.camera->up};
  return {position.value_or(pose.position), look_at.value_or(pose.look_at), pose.up};
}

void require_same_view(std::span<const PictureSensor> sensors, std::span<const radiometry::render::Camera> cameras) {
  constexpr double kSame = 1e-9;
  const auto words = [&](std::size_t s) {
    const radiometry::render::Camera& camera = cameras[s];
    return one_line(sensors[s].config.file) + " sees " + std::to_string(camera.width) + " x " +
           std::to_string(camera.height) + " samples of " + significant(1e6 * camera.step_x, 6) + " x " +
           significant(1e6 * camera.step_y, 6) + " urad";
  };
  const auto same = [](double a, double b) { return std::abs(a - b) <= kSame * b; };
  for (std::size_t s = 1; s < sensors.size(); ++s) {
    const radiometry::render::Camera &a = cameras[s], &b = cameras[0];
    if (a.width == b.width && a.height == b.height && same(a.step_x, b.step_x) && same(a.step_y, b.step_y) &&
        same(a.axis_x, b.axis_x) && same(a.axis_y, b.axis_y))
      continue;
    throw mtf::UsageError("sensors of one picture need the same field of view and samples: " + words(0) + ", " +
                          words(s) + "; change focal_length, pitch or format, or render them one by one");
  }
}

mtf::io::Metadata picture_metadata(const SceneFile& file, const PictureScene& scene, const PictureSensor& sensor,
                                   const radiometry::render::Camera& camera,
                                   const radiometry::render::RenderOptions& options,
                                   const radiometry::render::RenderedFrame& frame, std::size_t band) {
  mtf::io::Metadata m;
  const Quantity quantity = quantity_of(sensor);
  m.text["mtf:quantity"] =
      (sensor.quantity == PictureQuantity::weighted ? "weighted_" : "") + std::string(quantity_name(quantity));
  m.text["mtf:units"] = quantity_unit(quantity);
  if (!sensor.response.empty()) m.text["mtf:response"] = sensor.response;
  m.text["mtf:path"] = scene.scene.air ? "included" : "none";
  m.text["mtf:aperture"] = options.points > 1 ? "box" : "point";
  m.text["mtf:sensor"] = sensor.config.system.name;
  m.text["mtf:configSha256"] = sensor.config.sha256;
  m.text["mtf:sceneSha256"] = file.sha256;
  m.text["mtf:time"] = radiometry::heat::instant_text(scene.utc_s);
  m.text["mtf:cameraPosition"] = words_of(camera.position);
  m.text["mtf:cameraAhead"] = words_of(camera.ahead);
  m.text["mtf:version"] = std::string(mtf::version) + " " + mtf::git_commit;
  m.text["mtf:promisedError"] = mtf::format_double(frame.promised[band]);
  if (frame.view_rays > 0) m.text["mtf:reflectedError_K"] = mtf::format_double(frame.reflected_k[band]);
  for (const auto& [name, words] : scene.closures) m.text["mtf:" + name] = words;
  const mtf::Frame<double>& lens = sensor.config.system.frame;
  const double step_x = camera.step_x * lens.focal_length_mm * 1e-3,
               step_y = camera.step_y * lens.focal_length_mm * 1e-3;
  m.pairs["mtf:pixelPitch"] = {step_x, step_y};
  m.lists["mtf:bandEdges"] = {static_cast<float>(sensor.band.curves.band.lo_um),
                              static_cast<float>(sensor.band.curves.band.hi_um)};
  m.history.push_back("mtf render: " + (frame.sides > 0
                                            ? std::to_string(options.points * options.points) + " points a sample"
                                            : "from layers"));
  return m;
}

mtf::io::Scene scene_of(radiometry::render::RenderedFrame frame, const PictureSensor& sensor,
                        const radiometry::render::Camera& camera, const mtf::io::Metadata& metadata) {
  const double focal_length_um = sensor.config.system.frame.focal_length_mm * 1e3;
  mtf::io::Scene scene;
  scene.names = {"Y"};
  scene.planes.push_back(std::move(frame.radiance.front()));
  scene.grid = {camera.width, camera.height, camera.step_x * focal_length_um, camera.step_y * focal_length_um};
  scene.quantity = quantity_of(sensor);
  for (const auto& [name, text] : metadata.text) scene.info.attributes[name] = text;
  return scene;
}

std::vector<mtf::io::NamedPlane> picture_planes(const radiometry::render::RenderedFrame& frame, std::size_t band) {
  std::vector<mtf::io::NamedPlane> planes{{"Y", frame.radiance[band].view()}};
  for (const radiometry::render::NamedLayer& layer : frame.layers)
    if (layer.band.value_or(band) == band) planes.push_back({layer.name, layer.plane.view()});
  return planes;
}

}  // namespace apps::scene
