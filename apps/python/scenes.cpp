// SPDX-License-Identifier: Apache-2.0

// 3-D scenes and the air: surface temperatures, pictures, transmission.

#include <pybind11/stl.h>

#include "apps/atmosphere/atmosphere_options.h"
#include "apps/python/job.h"
#include "apps/python/topics.h"
#include "apps/scene/command/heat_files.h"
#include "apps/scene/command/picture_options.h"
#include "apps/terminal/output_set.h"

namespace apps::python {
namespace {

using Point = std::array<double, 3>;

Global silent(int threads) { return {.threads = threads, .quiet = true, .progress = Progress::none}; }

std::string atmosphere(const FileName& file, const std::vector<std::pair<std::string, std::string>>& settings,
                       const std::string& bands, double source_k, double tolerance, bool sky,
                       std::optional<double> cloud_cover, std::optional<double> cloud_k) {
  AtmosphereOptions options;
  options.file = file;
  options.given = settings;
  options.bands = bands;
  options.source_k = source_k;
  options.tolerance = tolerance;
  options.sky = sky;
  options.cloud_cover = cloud_cover;
  options.cloud_k = cloud_k;
  std::string json;
  run_job([&](JobControl&) { json = atmosphere_json(options, silent(0)); });
  return json;
}

/// Solves a scene into a folder that is there and empty, with the files of `mtf heat`. Returns heat.json and warnings.
py::tuple heat(const FileName& file, const FileName& folder, double tolerance_k, int rays, bool every_facet,
               int threads, const py::object& progress) {
  std::vector<std::string> warnings;
  std::string json;
  run_job([&](JobControl& control) {
    const ProgressCall report(progress, control);
    std::vector<mtf::io::Diagnostic> findings;
    const scene::SceneFile read = scene::load_scene(file, &findings);
    for (const mtf::io::Diagnostic& finding : findings) warnings.push_back(mtf::io::format_diagnostic(finding, file));
    const scene::HeatOptions options{
        .tolerance_k = tolerance_k, .rays = rays, .every_facet = every_facet, .threads = threads, .go_on = [&] {
          return !control.stopped();
        }};
    const scene::HeatScene prepared = scene::prepare_heat(read, options);
    warnings.insert(warnings.end(), prepared.warnings.begin(), prepared.warnings.end());
    OutputSet outputs({.folder = folder, .names = scene::heat_names(), .inputs = files_of(read)});
    scene::HeatFiles files(outputs.in(""), folder, read, prepared);
    const scene::HeatReport made = scene::run_heat(
        prepared, options, [&](const scene::HeatOutput& output) { files.append(output); },
        [&](const std::string&, double share) { report(share); });
    control.check();
    files.write(made, options);
    outputs.commit();
    json = scene::heat_json(read, prepared, made, options);
  });
  return py::make_tuple(json, warnings);
}

std::string render(const FileName& scene_file, const std::vector<FileName>& sensors, const FileName& out,
                   const FileName& temperatures, const std::string& time, bool solve,
                   const std::optional<Point>& position, const std::optional<Point>& look_at,
                   std::optional<double> samples_per_pitch, int points, bool plain, bool no_air,
                   const std::vector<std::string>& layers, int threads) {
  const RenderCommandOptions options{.scene = scene_file,
                                     .out = out,
                                     .sensors = {sensors.begin(), sensors.end()},
                                     .temperatures = temperatures,
                                     .time = time,
                                     .heat = solve,
                                     .position = position,
                                     .look_at = look_at,
                                     .sampling = {.samples_per_pitch = samples_per_pitch, .points = points},
                                     .plain = plain,
                                     .no_air = no_air,
                                     .layers = layers,
                                     .force = true,
                                     .format = Format::json};
  std::string json;
  run_job([&](JobControl&) { json = render_pictures(options, silent(threads)); });
  return json;
}

}  // namespace

void add_scenes(py::module_& module) {
  module.def("atmosphere", &atmosphere, "file"_a, "settings"_a, "bands"_a, "source_k"_a, "tolerance"_a, "sky"_a,
             "cloud_cover"_a, "cloud_k"_a);
  module.def("heat", &heat, "file"_a, "folder"_a, "tolerance_k"_a, "rays"_a, "every_facet"_a, "threads"_a,
             "progress"_a);
  module.def("render", &render, "scene"_a, "sensors"_a, "out"_a, "temperatures"_a, "time"_a, "solve"_a, "position"_a,
             "look_at"_a, "samples_per_pitch"_a, "points"_a, "plain"_a, "no_air"_a, "layers"_a, "threads"_a);
}

}  // namespace apps::python
