// SPDX-License-Identifier: Apache-2.0

// `mtf scene`: the example scene, and what a scene file says.

#include <algorithm>
#include <cmath>

#include "apps/options.h"
#include "apps/scene/heat/read_thermal_scene.h"
#include "apps/scene/outputs/mesh_files.h"
#include "apps/scene/render/picture_scene.h"
#include "apps/scene/scene_file/demo_lwir.toml.h"
#include "apps/scene/scene_file/demo_mwir.toml.h"
#include "apps/scene/scene_file/demo_scene_text.h"
#include "apps/scene/vehicle/vehicle.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/text_table.h"
#include "radiometry/light/constants.h"
#include "radiometry/weather/instant.h"

namespace apps {
namespace {

using namespace scene;

int write_demo(const SceneOptions& options) {
  const std::string folder = options.file + "/";
  OutputSet outputs(
      {.folder = options.file,
       .force = options.force,
       .names = {"scene.toml", "weather.csv", "engine.csv", "mwir.toml", "lwir.toml", "vehicle.obj", "terrain.obj"}});
  emit(outputs.in("scene.toml"), demo_scene_text());
  emit(outputs.in("weather.csv"), demo_weather_text());
  emit(outputs.in("engine.csv"), demo_engine_text());
  emit(outputs.in("mwir.toml"), mtf::embedded::demo_mwir_toml);
  emit(outputs.in("lwir.toml"), mtf::embedded::demo_lwir_toml);
  write_obj(outputs.in("vehicle.obj"), make_vehicle());
  write_obj(outputs.in("terrain.obj"), make_terrain());
  outputs.commit();
  const std::string file = shell_word(folder + "scene.toml");
  print("written to " + folder + ": scene.toml weather.csv engine.csv mwir.toml lwir.toml vehicle.obj terrain.obj\n" +
        "next: mtf heat " + file + " -o temperatures\nnext: mtf render " + file + " " +
        shell_word(folder + "mwir.toml") + " " + shell_word(folder + "lwir.toml") +
        " --heat --time 2026-06-21T12:10:00Z --position 54,-46,14 -o dawn --picture dawn.png\n");
  return 0;
}

std::string meshes_text(const HeatScene& scene) {
  TextTable table({"mesh", "faces", "facets", "vertices", "shells", "open", "left out", "extent [m]"});
  for (const radiometry::scene::MeshReport& mesh : scene.facets().report)
    table.add({one_line(mesh.name), std::to_string(mesh.faces), std::to_string(mesh.facets),
               std::to_string(mesh.vertices), std::to_string(mesh.shells), std::to_string(mesh.open_shells),
               std::to_string(mesh.bad_index + mesh.not_finite + mesh.degenerate + mesh.duplicate),
               fixed(mesh.extent_m[0], 2) + " x " + fixed(mesh.extent_m[1], 2) + " x " + fixed(mesh.extent_m[2], 2)});
  using enum Align;
  return table.aligned({left, right, right, right, right, right, right, left});
}

std::string regions_text(const HeatScene& scene) {
  std::vector<std::size_t> count(scene.input.regions.size(), 0);
  std::vector<double> area(count.size(), 0.0);
  for (std::size_t f = 0; f < scene.facets().size(); ++f) {
    ++count[scene.input.region_of[f]];
    area[scene.input.region_of[f]] += scene.facets().facet[f].area_m2;
  }
  TextTable table({"region", "facets", "area [m2]", "material", "temperature"});
  for (std::size_t r = 0; r < count.size(); ++r) {
    const Region& region = scene.input.regions[r];
    table.add({one_line(region.name), std::to_string(count[r]), fixed(area[r], 2),
               region.material ? one_line(scene.input.materials[*region.material].name) : "black",
               region.is_given() ? "given" : "solved"});
  }
  using enum Align;
  return table.aligned({left, right, right, left, left});
}

/// `air_k` and wind of the mean weather: what a material gives off for each kelvin, and what follows from it.
std::string materials_text(const HeatScene& scene) {
  const Surroundings& s = scene.surroundings;
  const auto mean = [](const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  };
  const double air = mean(s.air_k), wind = mean(s.wind_m_s);
  TextTable table({"material", "d [mm]", "R [m2 K/W]", "C [kJ/m2/K]", "absorptance", "emissivity", "h [W/m2/K]",
                   "time constant", "along the surface [m]"});
  for (const Material& material : scene.material) {
    const auto& c = material.construction;
    double thickness = 0.0;
    for (const auto& layer : c.layers) thickness += layer.thickness_m;
    const double h = forced_coefficient(c.convection, wind);
    const double loss = h + 4.0 * c.emissivity * radiometry::kStefanBoltzmann_w_m2_k4 * std::pow(air, 3);
    const double seconds = loss > 0.0 ? capacity(c) / loss : 0.0;
    table.add({one_line(material.name), significant(1e3 * thickness, 3), significant(resistance(c), 3),
               significant(capacity(c) / 1e3, 3), significant(material.solar_absorptance, 3),
               significant(c.emissivity, 3), significant(h, 3),
               seconds > 5400.0 ? significant(seconds / 3600.0, 2) + " h" : significant(seconds / 60.0, 2) + " min",
               loss > 0.0 ? significant(in_plane_length_m(c, loss), 2) : "-"});
  }
  using enum Align;
  return table.aligned({left, right, right, right, right, right, right, right, right}) +
         "h and time constant at the mean wind of " + significant(wind, 2) + " m/s and air of " + fixed(air, 1) +
         " K. Conduction along the surface is left out:\nit evens out differences over the last column's length.\n";
}

std::string weather_text(const HeatScene& scene) {
  const Surroundings& s = scene.surroundings;
  const auto range = [](const std::vector<double>& values, int decimals) {
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    return fixed(*least, decimals) + " to " + fixed(*most, decimals);
  };
  std::string text = "from " + radiometry::heat::instant_text(scene.input.start_s) + " to " +
                     radiometry::heat::instant_text(scene.input.end_s) + ", outputs every " +
                     significant(scene.input.step_s, 6) + " s\n";
  text += "air " + range(s.air_k, 1) + " K, wind " + range(s.wind_m_s, 1) + " m/s, direct sun " +
          range(s.direct_w_m2, 0) + " W/m2, diffuse " + range(s.diffuse_w_m2, 0) + " W/m2, long-wave sky " +
          range(s.sky_longwave_w_m2, 0) + " W/m2\n";
  for (const radiometry::heat::SunCrossing& crossing :
       sun_crossings(scene.input.place, scene.input.start_s, scene.input.end_s))
    text += std::string("the sun ") + (crossing.rises ? "rises" : "sets") + " at " +
            radiometry::heat::instant_text(std::round(crossing.utc_s)) + "\n";
  return text;
}

/// What `mtf render` says of the same scene at its start.
std::string pictures_text(const SceneFile& file) {
  std::string text = "pictures at " + radiometry::heat::instant_text(file.time.start_s) + ":\n";
  PictureScene picture;
  picture.utc_s = file.time.start_s;
  add_surroundings(file, {}, picture);
  for (const auto& [name, words] : picture.closures) text += "  " + name + ": " + words + "\n";
  return text;
}

}  // namespace

int run_scene(const SceneOptions& options, const Global& global) {
  if (options.action == SceneOptions::Action::demo) return write_demo(options);
  std::vector<mtf::io::Diagnostic> findings;
  const SceneFile file = load_scene(options.file, &findings);
  const HeatScene scene = prepare_heat(file, {.threads = global.threads});
  for (const mtf::io::Diagnostic& finding : findings) note(global, mtf::io::format_diagnostic(finding, file.file));
  for (const std::string& warning : scene.warnings) note(global, "warning: " + warning);
  if (options.action == SceneOptions::Action::check) {
    print(one_line(options.file) + ": ok, " + plural(static_cast<std::int64_t>(scene.facets().size()), "facet") +
          " in " + plural(static_cast<std::int64_t>(file.regions.size()), "region") + "\n");
    return 0;
  }
  print(meshes_text(scene) + "\n" + regions_text(scene) + "\n" + materials_text(scene) + "\n" + weather_text(scene) +
        pictures_text(file));
  return 0;
}

}  // namespace apps
