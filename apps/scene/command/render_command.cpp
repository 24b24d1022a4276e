// SPDX-License-Identifier: Apache-2.0

// `mtf render SCENE SENSOR -o OUT.exr`: the picture of a scene that a sensor takes in.

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "apps/scene/command/render_options.h"
#include "apps/scene/heat/stopwatch.h"
#include "apps/scene/render/sensor_picture.h"
#include "apps/sensor/sensor_file.h"
#include "apps/simulate/output_files.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/survey/statistics.h"
#include "radiometry/heat/weather/instant.h"

namespace apps {
namespace {

using namespace scene;
namespace render = radiometry::render;

render::LayerChoice layers_of(const std::vector<std::string>& names) {
  render::LayerChoice choice;
  const std::array<std::pair<std::string_view, bool render::LayerChoice::*>, 8> known{{
      {"temperature", &render::LayerChoice::temperature},
      {"emissivity", &render::LayerChoice::emissivity},
      {"Z", &render::LayerChoice::range},
      {"facet", &render::LayerChoice::facet},
      {"material", &render::LayerChoice::finish},
      {"normal", &render::LayerChoice::normal},
      {"surface", &render::LayerChoice::surface},
      {"transmittance", &render::LayerChoice::transmittance},
  }};
  for (const std::string& name : names) {
    const auto found = std::find_if(known.begin(), known.end(), [&](const auto& one) { return one.first == name; });
    if (found == known.end()) {
      std::string all;
      for (const auto& [word, member] : known) all += (all.empty() ? "" : ", ") + std::string(word);
      throw mtf::UsageError("--layer: there is no layer " + one_line(name) + "; there are " + all);
    }
    choice.*(found->second) = true;
  }
  return choice;
}

std::optional<double> instant_of(const std::string& text) {
  if (text.empty()) return std::nullopt;
  radiometry::heat::InstantError error;
  const auto instant = radiometry::heat::parse_instant(text, error);
  if (!instant) throw mtf::UsageError("--time: " + one_line(text) + ": " + error.text);
  return instant;
}

render::Pose pose_of(const RenderCommandOptions& options, const SceneFile& file) {
  if (!options.position && !options.look_at) return pose_of(file);
  render::Pose pose;
  if (file.camera || !options.position || !options.look_at) pose = pose_of(file);
  if (options.position) pose.position = *options.position;
  if (options.look_at) pose.look_at = *options.look_at;
  return pose;
}

std::vector<std::string> inputs_of(const RenderCommandOptions& options, const SceneFile& file,
                                   const mtf::io::SensorConfig& config) {
  std::vector<std::string> inputs = files_of(config);
  inputs.push_back(options.scene);
  if (!file.weather.file.empty()) inputs.push_back(file.weather.file);
  for (const MeshSection& mesh : file.meshes)
    if (!mesh.file.empty()) inputs.push_back(mesh.file);
  return inputs;
}

nlohmann::json json_of(const PictureScene& scene, const render::Renderer& renderer, const render::RenderedFrame& frame,
                       const mtf::io::Metadata& metadata) {
  nlohmann::json json;
  for (const auto& [name, text] : metadata.text) json["attributes"][name] = text;
  for (const auto& [name, text] : scene.closures) json["closures"][name] = text;
  json["rays"] = frame.rays;
  json["divided_samples"] = frame.divided;
  json["visible_sides"] = frame.sides;
  json["promised_error"] = frame.promised.front();
  json["timing_ms"] = nlohmann::json::object();
  for (const auto& times : {scene.timing_ms, renderer.timing_ms(), frame.timing_ms})
    for (const auto& [name, ms] : times) json["timing_ms"][name] = json["timing_ms"].value(name, 0.0) + ms;
  return json;
}

}  // namespace

int run_render(const RenderCommandOptions& options, const Global& global) {
  const Stopwatch all;
  if (!options.out.ends_with(".exr"))
    throw mtf::UsageError("-o: " + one_line(options.out) + ": pictures are OpenEXR files; give it the ending .exr");
  std::vector<mtf::io::Diagnostic> findings;
  const SceneFile file = load_scene(options.scene, &findings);
  for (const mtf::io::Diagnostic& finding : findings) note(global, mtf::io::format_diagnostic(finding, file.file));
  const mtf::io::SensorConfig config = read_sensor(options.sensor, global);
  require_writable({options.out}, inputs_of(options, file, config));
  const PictureSensor sensor =
      picture_sensor(config, options.plain ? PictureQuantity::radiance : PictureQuantity::weighted);
  const render::Camera camera = picture_camera(sensor, pose_of(options, file), options.samples_per_pitch);
  const PictureScene scene = read_picture_scene(file, {.temperatures = options.temperatures,
                                                       .utc_s = instant_of(options.time),
                                                       .sensor_air = sensor.air,
                                                       .sensor_file = config.file,
                                                       .air = !options.no_air});
  for (const std::string& warning : scene.warnings) note(global, "warning: " + warning);
  require_above_ground(scene, camera.position);
  const render::RenderOptions how{.further = options.rays == 1   ? 1
                                             : options.rays == 4 ? 2
                                                                 : 4,
                                  .contrast = options.contrast,
                                  .everywhere = options.everywhere,
                                  .layers = layers_of(options.layers),
                                  .threads = global.threads};
  render::Renderer renderer(scene.scene, {sensor.band}, how);
  const render::RenderedFrame frame = renderer.render(camera);
  const mtf::io::Metadata metadata = picture_metadata(file, scene, sensor, camera, how, frame);
  const Stopwatch writing;
  mtf::io::write_exr(options.out, picture_planes(frame), metadata);
  const double write_ms = writing.ms();
  const mtf::Statistics s = mtf::statistics(frame.radiance.front().view());
  const std::string unit = metadata.text.at("mtf:units");
  if (options.json) {
    nlohmann::json json = json_of(scene, renderer, frame, metadata);
    json["timing_ms"]["write"] = write_ms;
    json["timing_ms"]["all"] = all.ms();
    print(json.dump(2) + "\n");
    return 0;
  }
  TextTable table({"what", "value"});
  table.add({"samples", std::to_string(camera.width) + " x " + std::to_string(camera.height)});
  table.add({"time", radiometry::heat::instant_text(scene.utc_s)});
  table.add({metadata.text.at("mtf:quantity") + " [" + unit + "]",
             significant(s.min, 4) + " to " + significant(s.max, 4) + ", mean " + significant(s.mean, 4)});
  table.add({"rays", std::to_string(frame.rays) + ", " + std::to_string(frame.divided) + " samples with further rays"});
  table.add({"error of tables", "at most " + significant(frame.promised.front(), 2) + ", relative"});
  for (const auto& [name, words] : scene.closures) table.add({name, words});
  using enum Align;
  print(table.aligned({left, left}) + "written to " + options.out + "\nnext: mtf simulate " +
        shell_word(options.sensor) + " " + shell_word(options.out) + " -o image.exr" +
        (scene.scene.air && sensor.has_path ? " --without-path" : "") + "\n");
  return 0;
}

}  // namespace apps
