// SPDX-License-Identifier: Apache-2.0

// `mtf render SCENE SENSOR... -o OUT`: the picture of a scene that a sensor takes in, or those of several sensors from
// one pass of rays.

#include <algorithm>
#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "apps/config_command.h"
#include "apps/figures/picture.h"
#include "apps/options.h"
#include "apps/scene/command/picture_options.h"
#include "apps/scene/command/read_scene.h"
#include "apps/scene/heat/read_temperatures.h"
#include "apps/scene/render/layer_file.h"
#include "apps/scene/render/sensor_picture.h"
#include "apps/sensor/sensor_air.h"
#include "apps/simulate/simulate.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "apps/text/message_words.h"
#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/field/sample_ranges.h"
#include "mtf/image.h"
#include "mtf/io/config/config.h"
#include "mtf/work/stopwatch.h"
#include "radiometry/weather/instant.h"

namespace apps {
namespace {

// What `mtf render` prints of the pictures that it made.

/// A frame of one band for each sensor, and the attributes of their files.
struct RenderOutputs {
  const scene::PictureScene& scene;
  const std::vector<scene::PictureSensor>& sensors;
  const radiometry::render::RenderedFrame& frame;
  const std::vector<mtf::io::Metadata>& metadata;
  double samples_per_pitch;
};

namespace fs = std::filesystem;

Json render_json(const RenderOutputs& made, const std::vector<std::string>& outputs) {
  const auto& [scene, sensors, frame, metadata, samples_per_pitch] = made;
  Json json;
  json["attributes"] = metadata.front().text;
  json["closures"] = Json::object(scene.closures);
  json["samples_per_pitch"] = samples_per_pitch;
  json["divided_samples"] = frame.divided;
  json["shadow_rays"] = frame.shadow_rays;
  json["visible_sides"] = frame.sides;
  json["promised_error"] = frame.promised.front();
  for (std::size_t b = 0; b < outputs.size(); ++b)
    json["pictures"].push_back({{"file", outputs[b]},
                                {"sensor", metadata[b].text.at("mtf:sensor")},
                                {"quantity", metadata[b].text.at("mtf:quantity")},
                                {"promised_error", frame.promised[b]}});
  if (frame.view_rays > 0) {
    json["view_rays"] = frame.view_rays;
    for (std::size_t b = 0; b < outputs.size(); ++b) json["pictures"][b]["reflected_error_K"] = frame.reflected_k[b];
  }
  json["timing_ms"] = Json::object();
  for (const auto& times : {scene.timing_ms, frame.timing_ms})
    for (const auto& [name, ms] : times) {
      Json& time = json["timing_ms"][name];
      time = (time.is_null() ? 0.0 : time.get<double>()) + ms;
    }
  return json;
}

/// What was made, and the commands that come next.
std::string render_summary(const RenderCommandOptions& options, const RenderOutputs& made,
                           const std::vector<std::string>& outputs) {
  const auto& [scene, sensors, frame, metadata, samples_per_pitch] = made;
  TextTable table({"what", "value"});
  const mtf::Image& first = frame.radiance.front();
  table.add({"samples", std::to_string(first.width()) + " x " + std::to_string(first.height()) + ", " +
                            significant(samples_per_pitch, 3) + " a pitch"});
  table.add({"time", radiometry::heat::instant_text(scene.utc_s)});
  const bool one = sensors.size() == 1;
  std::string written, next;
  for (std::size_t b = 0; b < sensors.size(); ++b) {
    const auto& text = metadata[b].text;
    const mtf::Statistics s = mtf::statistics(frame.radiance[b].view());
    const std::string of = one ? "" : one_line(fs::path(options.sensors[b]).stem().string()) + ": ";
    table.add({of + text.at("mtf:quantity") + " [" + text.at("mtf:units") + "]",
               significant(s.min, 4) + " to " + significant(s.max, 4) + ", mean " + significant(s.mean, 4)});
    table.add({of + "error of tables", "at most " + significant(frame.promised[b], 2) + ", relative"});
    if (frame.view_rays > 0)
      table.add({of + "error of reflected light", significant(1e3 * frame.reflected_k[b], 2) + " mK rms at 300 K, by " +
                                                      std::to_string(frame.view_rays) + " rays a side"});
    const scene::FinestDetail finest = scene::finest_detail(sensors[b], samples_per_pitch);
    table.add({of + "finest detail of samples", significant(finest.frequency_cy_mm, 3) +
                                                    " cy/mm, where the sensor's MTF is " + significant(finest.mtf, 2)});
    written += (b == 0 ? "written to " : " ") + outputs[b];
    const std::string image = one ? "image" : fs::path(outputs[b]).replace_extension().string() + "_image";
    next += "next: mtf simulate " + shell_word(options.sensors[b]) + " " + shell_word(outputs[b]) + " -o " +
            shell_word(image + ".exr") + (scene.scene.air && sensors[b].has_path ? " --without-path" : "") + "\n";
  }
  if (frame.sides > 0)
    table.add({"visible sides",
               std::to_string(frame.sides) + "; " + std::to_string(frame.divided) + " samples show more than one"});
  if (frame.shadow_rays > 0) table.add({"shadow rays", std::to_string(frame.shadow_rays)});
  for (const auto& [name, words] : scene.closures) table.add({name, words});
  using enum Align;
  return table.aligned({left, left}) + written + (options.picture.empty() ? "" : " " + options.picture) + "\n" + next;
}

// `mtf render --picture`: radiance beside the image of the sensor, one row a sensor, for the eye.

/// The picture of one sensor, and the file that it was written to.
struct SensorPictureFile {
  const mtf::io::SensorConfig& sensor;
  mtf::ImageView<const float> radiance;
  std::string unit, file;
};

/// Draws the scenes and what `mtf simulate` makes of them.
void draw_pictures(const std::string& path, std::span<const SensorPictureFile> pictures, int threads) {
  PairedPicture page;
  for (const SensorPictureFile& picture : pictures) {
    const std::string name = one_line(picture.sensor.system.name);
    const std::int64_t width = std::max<std::int64_t>(picture.radiance.width, 1024);
    page.add({name + ", radiance", "samples"}, picture.radiance, picture.unit, width);
    const SimulateResult result = simulate(picture.sensor, {.file = picture.file}, {.threads = threads});
    page.add({name + ", image of the sensor", "pixels"}, result.images.front().planes.front().view(),
             result.report.unit(), width);
  }
  page.write(path);
}

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
    if (found == known.end())
      throw mtf::UsageError("--layer: there is no layer " + one_line(name) + "; there are " +
                            joined(known, [](const auto& one) { return std::string(one.first); }));
    choice.*(found->second) = true;
  }
  return choice;
}

std::vector<std::string> inputs_of(const RenderCommandOptions& options, const SceneFile& file,
                                   const std::vector<PictureSensor>& sensors) {
  std::vector<std::string> inputs = files_of(file);
  inputs.insert(inputs.end(), {options.from, options.materials});
  for (const std::string& name : temperature_files(options.temperatures)) inputs.push_back(name);
  for (const PictureSensor& sensor : sensors)
    for (const std::string& name : files_of(sensor.config)) inputs.push_back(name);
  return inputs;
}

/// OpenEXR files, one a sensor: `out` itself, or of several sensors names in that folder.
std::vector<std::string> outputs_of(const RenderCommandOptions& options) {
  const bool one = options.sensors.size() == 1;
  if (one != options.out.ends_with(".exr"))
    throw mtf::UsageError("-o: " + one_line(options.out) +
                          (one ? ": pictures are OpenEXR files; give it the ending .exr"
                               : ": of several sensors it is a folder, with a picture named after each sensor file"));
  if (one) return {options.out};
  std::vector<std::string> outputs;
  for (const std::string& sensor : options.sensors) {
    const std::string file = fs::path(sensor).stem().string() + ".exr";
    if (std::find(outputs.begin(), outputs.end(), file) != outputs.end())
      throw mtf::UsageError("two sensors would both be written to " +
                            one_line((fs::path(options.out) / file).string()) + "; rename a sensor file");
    outputs.push_back(file);
  }
  return outputs;
}

std::vector<PictureSensor> sensors_of(const RenderCommandOptions& options, const SceneFile& file,
                                      const Global& global) {
  std::vector<PictureSensor> sensors;
  for (const std::string& name : options.sensors) {
    sensors.push_back(picture_sensor(read_sensor(name, global),
                                     options.plain ? PictureQuantity::radiance : PictureQuantity::weighted));
    if (sensors.back().air && options.sensors.size() > 1 && !options.no_air)
      throw mtf::UsageError(one_line(name) + ": has [atmosphere]; several sensors see through one air, so move it to " +
                            one_line(file.file) + ", or write --no-air");
  }
  return sensors;
}

/// With the temperatures of the heat balance, where they are asked for.
PictureScene scene_of(const RenderCommandOptions& options, const SceneFile& file, const PictureSensor& sensor,
                      const Global& global) {
  PictureOptions how{.temperatures = options.temperatures,
                     .utc_s = instant_of("--time", options.time),
                     .sensor_air = sensor.air,
                     .sensor_file = sensor.config.file,
                     .air = !options.no_air};
  if (!options.heat) return read_picture_scene(file, how);
  if (!options.temperatures.empty()) throw mtf::UsageError("--heat: solves the temperatures; leave --temperatures out");
  ProgressLine progress(global);
  how.utc_s = how.utc_s.value_or(file.time.start_s);
  TemperatureRows rows = solved_rows(file, *how.utc_s, *how.utc_s, {.threads = global.threads},
                                     [&](const std::string& step, double share) { progress.update(step, share); });
  return PictureSource(file, how, std::move(rows)).at();
}

/// Of layers: no facets, and no options that are about them.
PictureScene layer_scene_of(const RenderCommandOptions& options, const SceneFile& file, const PictureSensor& sensor) {
  if (options.heat || !options.temperatures.empty() || !options.layers.empty())
    throw mtf::UsageError(
        "--from: the layers of another renderer have the temperatures; leave --heat, --temperatures "
        "and --layer out");
  PictureScene scene = read_layer_scene(file, {.utc_s = instant_of("--time", options.time),
                                               .sensor_air = sensor.air,
                                               .sensor_file = sensor.config.file,
                                               .air = !options.no_air});
  scene.closures.emplace_back("layers", one_line(options.from) + ": unhidden view of sky and ground");
  return scene;
}

render::RenderedFrame frame_of_layers(const RenderCommandOptions& options, const SceneFile& file,
                                      const PictureScene& scene, const std::vector<render::RenderBand>& bands,
                                      const render::Camera& camera, const Global& global) {
  LayerFile from{.file = options.from, .materials = options.materials, .planar = options.planar_depth};
  for (const auto& [role, name] : options.channels) from.channels[role] = name;
  render::RenderedFrame frame;
  const mtf::Stopwatch reading;
  const render::SurfaceLayers layers = read_layers(from, file, camera);
  for (const std::string& text : mtf::io::read_info(options.from).notes)
    note(global, "warning: " + one_line(options.from) + ": " + one_line(text));
  frame.timing_ms.emplace_back("layers", reading.ms());
  const mtf::Stopwatch rendering;
  render::LayerFrame made =
      render_layers(scene.scene, bands, camera, layers, {.tolerance = options.tolerance, .threads = global.threads});
  frame.timing_ms.emplace_back("pixels", rendering.ms());
  if (camera.position[2] < made.ground_m)
    note(global, "warning: the camera is below the lowest surface of the layers, at " + significant(made.ground_m, 3) +
                     " m, where the ground beyond them is taken to be");
  if (made.mirrors > 0)
    note(global, "warning: " + std::to_string(made.mirrors) +
                     " samples show glossy materials, which mirror sky and ground alone: layers do not say what else "
                     "a mirror shows");
  if (made.unlit > 0)
    note(global, "warning: " + one_line(options.from) +
                     " has no normals, so that no sunlight falls on its surfaces: add the channels normal.X, normal.Y "
                     "and normal.Z");
  if (made.as_matt > 0)
    note(global, "warning: " + std::to_string(made.as_matt) +
                     " samples show materials that are glossy or have an emissivity by angle; " +
                     one_line(options.from) +
                     " has no normals, so that they are drawn matt, with the mean of their emissivity over the "
                     "hemisphere: add the channels normal.X, normal.Y and normal.Z");
  frame.radiance = std::move(made.radiance);
  frame.promised = std::move(made.promised);
  return frame;
}

}  // namespace

std::string render_pictures(const RenderCommandOptions& options, const Global& global) {
  const mtf::Stopwatch all;
  if (options.from.empty())
    for (const auto& [name, given] : {std::pair{"--materials", !options.materials.empty()},
                                      {"--depth", options.planar_depth.has_value()},
                                      {"--channel", !options.channels.empty()}})
      if (given)
        throw mtf::UsageError(std::string(name) + " is of the layers of another renderer: name them with --from");
  std::vector<std::string> names = outputs_of(options);
  const bool folder = names.size() > 1;
  require_picture_name(options.picture);
  const SceneFile file = read_scene(options.scene, global);
  const std::vector<PictureSensor> sensors = sensors_of(options, file, global);
  constexpr double kOfLayers = 2.0;  // layers are there already
  const double samples_per_pitch = options.sampling.samples_per_pitch ? *options.sampling.samples_per_pitch
                                   : options.from.empty()             ? samples_for(sensors)
                                                                      : kOfLayers;
  OutputSet outputs({.folder = folder ? options.out : "",
                     .force = options.force,
                     .names = folder ? names : std::vector<std::string>(),
                     .files = folder ? std::vector{options.picture} : std::vector{options.out, options.picture},
                     .inputs = inputs_of(options, file, sensors)});
  const auto planes = static_cast<double>(sensors.size() - 1 + options.layers.size() +
                                          2U * static_cast<std::size_t>(std::ranges::count(options.layers, "normal")));
  const double shown = options.picture.empty() ? 0.0 : kShownBytes * static_cast<double>(sensors.size());
  if (const std::string words =
          memory_words(sensors.front().config, samples_per_pitch, kPictureBytes + kPlaneBytes * planes + shown);
      !words.empty())
    note(global, "note: " + words);
  std::vector<render::Camera> cameras;
  std::vector<render::RenderBand> bands;
  const render::Pose pose = pose_of(file, options.position, options.look_at);
  for (const PictureSensor& sensor : sensors) {
    cameras.push_back(picture_camera(sensor, pose, samples_per_pitch));
    bands.push_back(sensor.band);
  }
  require_same_view(sensors, cameras);
  render::RenderOptions how{.points = options.sampling.points,
                            .tolerance = options.tolerance,
                            .layers = layers_of(options.layers),
                            .threads = global.threads};
  how.layers.range = how.layers.range || std::ranges::any_of(sensors, [](const PictureSensor& sensor) {
                       return mtf::entry_by_range(sensor.config.system).has_value();
                     });
  if (!options.from.empty()) how.points = 1;  // a value a sample
  PictureScene scene;
  render::RenderedFrame frame;
  if (options.from.empty()) {
    scene = scene_of(options, file, sensors.front(), global);
    require_above_ground(scene, cameras.front().position);
    render::Renderer renderer(scene.scene, bands, how);
    frame = renderer.render(cameras.front());
    frame.timing_ms.insert(frame.timing_ms.begin(), renderer.timing_ms().begin(), renderer.timing_ms().end());
  } else {
    scene = layer_scene_of(options, file, sensors.front());
    frame = frame_of_layers(options, file, scene, bands, cameras.front(), global);
  }
  for (const PictureSensor& sensor : sensors) add_band_limits(file, sensor.band.curves.band, scene);
  for (const PictureSensor& sensor : sensors)
    if (std::string text = sampling_warning(sensor, samples_per_pitch); !text.empty())
      scene.warnings.push_back(std::move(text));
  for (std::size_t b = 0; b < frame.reflected_k.size(); ++b)
    if (std::string text = reflected_warning(sensors[b], frame.reflected_k[b], frame.view_rays); !text.empty())
      scene.warnings.push_back(std::move(text));
  for (const std::string& warning : scene.warnings) note(global, "warning: " + warning);
  std::vector<mtf::io::Metadata> metadata;
  for (std::size_t b = 0; b < sensors.size(); ++b)
    metadata.push_back(picture_metadata(file, scene, sensors[b], cameras[b], how, frame, b));
  const mtf::Stopwatch writing;
  std::vector<std::string> staged;
  for (std::size_t b = 0; b < sensors.size(); ++b) {
    staged.push_back(folder ? outputs.in(names[b]) : outputs.at(options.out));
    mtf::io::write_exr(staged[b], picture_planes(frame, b), metadata[b]);
    if (folder) names[b] = (fs::path(options.out) / names[b]).string();
  }
  if (!options.picture.empty()) {
    std::vector<mtf::io::SensorConfig> cameras_of;
    for (const PictureSensor& sensor : sensors)
      cameras_of.push_back(scene.scene.air ? without_path(sensor.config) : sensor.config);
    std::vector<SensorPictureFile> pictures;
    for (std::size_t b = 0; b < sensors.size(); ++b)
      pictures.push_back({cameras_of[b], frame.radiance[b].view(), metadata[b].text.at("mtf:units"), staged[b]});
    draw_pictures(outputs.at(options.picture), pictures, global.threads);
  }
  outputs.commit();
  if (options.format != Format::json)
    return render_summary(options, {scene, sensors, frame, metadata, samples_per_pitch}, names);
  Json json = render_json({scene, sensors, frame, metadata, samples_per_pitch}, names);
  json["timing_ms"]["write"] = writing.ms();
  json["timing_ms"]["all"] = all.ms();
  json.sort();
  return json_document(json);
}

int run_render(const RenderCommandOptions& options, const Global& global) {
  print(render_pictures(options, global));
  return 0;
}

}  // namespace apps
