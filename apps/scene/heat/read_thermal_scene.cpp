// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/read_thermal_scene.h"

#include <algorithm>
#include <set>

#include "apps/scene/heat/read_temperatures.h"
#include "apps/scene/import/import_mesh.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/work/stopwatch.h"
#include "radiometry/atmosphere/spectral_path.h"
#include "radiometry/heat/construction.h"
#include "radiometry/weather/clear_sky.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;
using radiometry::scene::Mesh;

heat::Convection convection_of(const Convection& convection) {
  switch (convection.model) {
    case ConvectionModel::none:
      return heat::NoConvection{};
    case ConvectionModel::tarp:
      return heat::Tarp{};
    case ConvectionModel::linear:
      return heat::LinearConvection{convection.h0_w_m2_k, convection.h1_j_m3_k};
    case ConvectionModel::mcadams:
      break;
  }
  return heat::McAdams{};
}

/// Sets the inside of the surface, and the schedule that drives it.
void set_inside(const MaterialSection& material, Material& made) {
  const Inside& inside = material.inside;
  switch (inside.kind) {
    case InsideKind::adiabatic:
      break;
    case InsideKind::fixed:
      made.construction.inside = heat::FixedTemperature{};
      made.inside = inside.temperature;
      break;
    case InsideKind::film:
      made.construction.inside = heat::InnerFilm{inside.h_w_m2_k};
      made.inside = inside.temperature;
      break;
    case InsideKind::flux:
      made.construction.inside = heat::InnerFlux{};
      made.inside = inside.flux;
      break;
    case InsideKind::sheet:
      made.construction.inside =
          heat::Sheet{inside.back_emissivity ? inside.back_emissivity->value : material.emissivity.value,
                      convection_of(material.convection)};
      break;
    case InsideKind::pair: {
      // Meshes of walls are seldom as thick as the layers say to the millimetre.
      constexpr double kRoom = 2.0;
      double thickness = 0.0;
      for (const LayerSection& layer : material.layers) thickness += layer.thickness_m;
      made.construction.inside = heat::Sheet{material.emissivity.value, convection_of(material.convection)};
      made.pair_m = inside.thickness_m.value_or(kRoom * thickness);
      break;
    }
  }
}

/// Constant sources as heat at the surfaces; others as schedules of all layers.
void set_sources(const MaterialSection& material, Material& made) {
  std::vector<double> constant;
  for (const LayerSection& layer : material.layers) {
    made.sources.push_back(layer.source.value.empty() ? heat::constant_schedule(0.0) : layer.source);
    made.construction.generates = made.construction.generates || !made.sources.back().constant();
    constant.push_back(made.sources.back().value.front());
  }
  if (made.construction.generates) return;
  made.sources.clear();
  const heat::SourceHeat generated = heat::source_heat(made.construction, constant);
  made.source_w_m2 = generated.front_w_m2;
  made.back_source_w_m2 = generated.back_w_m2;
}

/// A scene of [ground] alone.
Mesh open_facet() {
  Mesh mesh;
  mesh.vertices = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {1.0, 1.0, 0.0}, {0.0, 1.0, 0.0}};
  mesh.corners = {0, 1, 2, 3};
  mesh.first = {0, 4};
  mesh.group = mesh.material = {0};
  mesh.group_names = mesh.material_names = {""};
  return mesh;
}

/// Of each face of the mesh, the region that has it.
std::vector<std::uint32_t> regions_of_faces(const SceneFile& file, std::size_t mesh_index, const Mesh& mesh) {
  constexpr std::uint32_t kNobody = radiometry::scene::kNone;
  std::vector<std::uint32_t> of_group(mesh.group_names.size(), kNobody);
  std::vector<std::uint32_t> of_material(mesh.material_names.size(), kNobody);
  std::uint32_t of_rest = kNobody;
  const auto names_text = [](const std::vector<std::string>& names) {
    if (names.empty()) return std::string("none");
    return joined(names, [](const std::string& name) { return one_line(name.empty() ? "''" : name); });
  };
  for (std::size_t r = 0; r < file.regions.size(); ++r) {
    const RegionSection& region = file.regions[r];
    if (region.mesh != mesh_index) continue;
    const auto claim = [&](const std::vector<std::string>& names, const std::string& name,
                           std::vector<std::uint32_t>& of, const char* what) {
      const auto found = std::find(names.begin(), names.end(), name);
      if (found == names.end())
        throw mtf::UsageError(one_line(file.file) + ": region '" + one_line(region.name) +
                              "': " + one_line(file.meshes[mesh_index].file) + " has no " + what + " '" +
                              one_line(name) + "' (there are: " + names_text(names) + ")");
      of[static_cast<std::size_t>(found - names.begin())] = static_cast<std::uint32_t>(r);
    };
    if (!region.group.empty())
      claim(mesh.group_names, region.group, of_group, "group");
    else if (!region.mesh_material.empty())
      claim(mesh.material_names, region.mesh_material, of_material, "material");
    else
      of_rest = static_cast<std::uint32_t>(r);
  }
  std::vector<std::uint32_t> of_face(mesh.faces());
  for (std::size_t f = 0; f < mesh.faces(); ++f) {
    const std::uint32_t by_group = of_group[mesh.group[f]];
    const std::uint32_t by_material = of_material[mesh.material[f]];
    of_face[f] = by_group != kNobody ? by_group : by_material != kNobody ? by_material : of_rest;
    if (of_face[f] == kNobody)
      throw mtf::UsageError(one_line(file.file) + ": mesh '" + one_line(file.meshes[mesh_index].name) +
                            "': no [[region]] has the faces of group '" + one_line(mesh.group_names[mesh.group[f]]) +
                            "', material '" + one_line(mesh.material_names[mesh.material[f]]) +
                            "'; add one for them, or one of the mesh without a group for the rest");
  }
  return of_face;
}

/// Measured, by a formula with clouds, or by the air of [atmosphere]; gaps in columns that it leaves do not matter.
LongwaveSky sky_of(const SceneFile& file) {
  using enum heat::WeatherQuantity;
  const SkySection& sky = file.sky;
  if (sky.longwave == LongwaveModel::measured) return {};
  LongwaveSky made;
  if (sky.cloud == CloudSource::from_longwave) made.columns.push_back(longwave_down);
  if (sky.longwave != LongwaveModel::swinbank) made.columns.push_back(vapour_pressure);
  if (sky.cloud == CloudSource::from_weather) made.columns.push_back(cloud_cover);
  made.w_m2 = [sky, air = clear_sky_of(file)](const heat::WeatherAt& at) mutable {
    return sky_longwave(sky, at, air ? &*air : nullptr).irradiance_w_m2;
  };
  return made;
}

/// The air of [sky] longwave = "atmosphere" where it is coldest, warmest and most humid.
std::vector<std::string> air_limits(const SceneFile& file, const Surroundings& s) {
  if (file.sky.longwave != LongwaveModel::atmosphere || !file.atmosphere) return {};
  constexpr radiometry::Interval kThermal_um{5.0, 15.0};
  const ClearSkyFlux model(*file.atmosphere, file.place.altitude_m);
  const auto [coldest, warmest] = std::ranges::minmax_element(s.air_k);
  std::vector<std::string> texts;
  std::set<std::string> said;  // rules
  for (const auto node : {coldest - s.air_k.begin(), warmest - s.air_k.begin(),
                          std::ranges::max_element(s.vapour_pa) - s.vapour_pa.begin()}) {
    const auto k = static_cast<std::size_t>(node);
    for (const std::string& limit : limits_of(model.air_at(s.air_k[k], s.vapour_pa[k]), kThermal_um))
      if (said.insert(limit.substr(0, limit.find(';'))).second)
        texts.push_back("[atmosphere], as the weather has it at " +
                        heat::instant_text(file.time.start_s + s.time_s[k]) + ": " + limit);
  }
  return texts;
}

}  // namespace

Material material_of(const MaterialSection& material, double air_pressure_pa) {
  Material made;
  made.name = material.name;
  for (const LayerSection& layer : material.layers) {
    made.construction.layers.push_back(
        {layer.conductivity_w_m_k, layer.density_kg_m3, layer.heat_capacity_j_kg_k, layer.thickness_m});
  }
  made.construction.emissivity = material.emissivity.value;
  made.construction.convection = convection_of(material.convection);
  made.solar_absorptance = material.solar_absorptance;
  made.back_solar_absorptance = material.inside.back_solar_absorptance.value_or(material.solar_absorptance);
  set_inside(material, made);
  made.construction.wet_fraction = material.wet_fraction;
  made.construction.air_pressure_pa = air_pressure_pa;
  if (auto* sheet = std::get_if<heat::Sheet>(&made.construction.inside)) sheet->wet_fraction = material.wet_fraction;
  set_sources(material, made);
  require_valid(made);
  return made;
}

ThermalScene values_of(const SceneFile& file) {
  if (file.ground && file.ground->temperature && !file.ground->temperature->table.empty())
    throw mtf::UsageError(one_line(file.file) +
                          ": [ground]: it has no facets, so that no table of them tells its temperature; give a "
                          "temperature, or a schedule as a CSV file of time and temperature");
  ThermalScene scene{.name = file.file,
                     .start_s = file.time.start_s,
                     .end_s = file.time.end_s,
                     .step_s = file.time.step_s,
                     .place = file.place,
                     .north_rad = file.north_rad};
  for (const MaterialSection& material : file.materials)
    scene.materials.push_back(material_of(material, heat::standard_pressure_pa(file.place.altitude_m)));
  const auto given = [](const auto& section) {
    return section.temperature ? section.temperature->schedule : heat::Schedule{};
  };
  for (const RegionSection& region : file.regions)
    scene.regions.push_back({.name = region.name, .material = region.material, .temperature = given(region)});
  if (file.ground) scene.ground = LevelGround{file.ground->material, given(*file.ground)};
  if (file.camera) scene.camera_m = file.camera->position_m;
  return scene;
}

void read_scene_weather(const SceneFile& file, ThermalScene& scene) {
  scene.weather = scene_weather(file);
  scene.sky = sky_of(file);
  require_weather(scene);
}

void read_meshes(const SceneFile& file, ThermalScene& scene) {
  std::vector<Mesh> meshes;
  for (const MeshSection& mesh : file.meshes)
    meshes.push_back(mesh.file.empty() ? open_facet() : import_mesh(mesh.file, mesh.unit_m));
  std::vector<radiometry::scene::PlacedMesh> placed;
  std::vector<std::vector<std::uint32_t>> regions;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    placed.push_back({file.meshes[m].name, &meshes[m]});
    regions.push_back(regions_of_faces(file, m, meshes[m]));
  }
  scene.facets = facets_of(placed);
  std::vector<bool> used(file.regions.size(), false);
  for (const radiometry::scene::Facet& facet : scene.facets.facet) {
    scene.region_of.push_back(regions[facet.mesh][facet.face]);
    used[scene.region_of.back()] = true;
  }
  for (std::size_t r = 0; r < used.size(); ++r) {
    if (used[r]) continue;
    std::string reason = "; remove it, or name a group that has faces";
    for (std::size_t m = 0; m < regions.size(); ++m)
      if (std::find(regions[m].begin(), regions[m].end(), r) != regions[m].end()) {
        reason = ": those of its groups were left out";
        for (const std::string& warning : scene.facets.warnings)
          if (warning.starts_with("mesh `" + file.meshes[m].name + "`")) reason += "; " + warning;
      }
    throw mtf::UsageError(one_line(file.file) + ": region '" + one_line(file.regions[r].name) + "' has no face" +
                          one_line(reason));
  }
}

void read_tables(const SceneFile& file, ThermalScene& scene) {
  for (std::size_t r = 0; r < file.regions.size(); ++r)
    if (const auto& given = file.regions[r].temperature; given && !given->table.empty())
      scene.regions[r].table =
          std::make_shared<const TemperatureRows>(read_temperatures(given->table, scene.facets.size()));
}

Surroundings surroundings_of(const SceneFile& file, int directions, double tolerance_k) {
  ThermalScene scene = values_of(file);
  read_scene_weather(file, scene);
  return surroundings_of(scene, directions, tolerance_k);
}

HeatScene prepare_heat(const SceneFile& file, const HeatOptions& options) {
  require_files(file);
  const mtf::Stopwatch weather;
  ThermalScene given = values_of(file);
  read_scene_weather(file, given);
  const double weather_ms = weather.ms();
  const mtf::Stopwatch meshes;
  read_meshes(file, given);
  read_tables(file, given);
  const double meshes_ms = meshes.ms();
  HeatScene scene = prepare_heat(std::move(given), options);
  scene.timing_ms.front().second += weather_ms;
  scene.timing_ms.insert(scene.timing_ms.begin() + 1, {"meshes", meshes_ms});
  std::vector<std::string> limits = air_limits(file, scene.surroundings);
  scene.warnings.insert(scene.warnings.begin() + static_cast<std::ptrdiff_t>(scene.surroundings.warnings.size()),
                        std::make_move_iterator(limits.begin()), std::make_move_iterator(limits.end()));
  return scene;
}

}  // namespace apps::scene
