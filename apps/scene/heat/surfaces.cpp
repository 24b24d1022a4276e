// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/surfaces.h"

#include <algorithm>
#include <cmath>

#include "apps/scene/import/import_mesh.h"
#include "apps/text/words.h"
#include "mtf/error.h"
#include "radiometry/heat/layer_sources.h"
#include "radiometry/light/constants.h"
#include "radiometry/weather/clear_sky.h"

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
void set_inside(const MaterialSection& material, Surface& surface) {
  const Inside& inside = material.inside;
  switch (inside.kind) {
    case InsideKind::adiabatic:
      break;
    case InsideKind::fixed:
      surface.construction.inside = heat::FixedTemperature{};
      surface.inside = inside.temperature;
      break;
    case InsideKind::film:
      surface.construction.inside = heat::InnerFilm{inside.h_w_m2_k};
      surface.inside = inside.temperature;
      break;
    case InsideKind::flux:
      surface.construction.inside = heat::InnerFlux{};
      surface.inside = inside.flux;
      break;
    case InsideKind::sheet:
      surface.construction.inside =
          heat::Sheet{inside.back_emissivity ? inside.back_emissivity->value : material.emissivity.value,
                      convection_of(material.convection)};
      break;
    case InsideKind::pair: {
      // Meshes of walls are seldom as thick as the layers say to the millimetre.
      constexpr double kRoom = 2.0;
      double thickness = 0.0;
      for (const LayerSection& layer : material.layers) thickness += layer.thickness_m;
      surface.construction.inside = heat::Sheet{material.emissivity.value, convection_of(material.convection)};
      surface.pair_m = inside.thickness_m.value_or(kRoom * thickness);
      break;
    }
  }
}

/// Constant sources as heat at the surfaces; others as schedules of all layers.
void set_sources(const MaterialSection& material, Surface& surface) {
  std::vector<double> constant;
  for (const LayerSection& layer : material.layers) {
    surface.sources.push_back(layer.source.value.empty() ? heat::constant_schedule(0.0) : layer.source);
    surface.construction.generates = surface.construction.generates || !surface.sources.back().constant();
    constant.push_back(surface.sources.back().value.front());
  }
  if (surface.construction.generates) return;
  surface.sources.clear();
  const heat::SourceHeat generated = heat::source_heat(surface.construction, constant);
  surface.source_w_m2 = generated.front_w_m2;
  surface.back_source_w_m2 = generated.back_w_m2;
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
std::vector<std::uint32_t> regions_of_faces(const SceneFile& scene, std::size_t mesh_index, const Mesh& mesh) {
  constexpr std::uint32_t kNobody = radiometry::scene::kNone;
  std::vector<std::uint32_t> of_group(mesh.group_names.size(), kNobody);
  std::vector<std::uint32_t> of_material(mesh.material_names.size(), kNobody);
  std::uint32_t of_rest = kNobody;
  const auto names_text = [](const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + one_line(name.empty() ? "''" : name);
    return text.empty() ? std::string("none") : text;
  };
  for (std::size_t r = 0; r < scene.regions.size(); ++r) {
    const RegionSection& region = scene.regions[r];
    if (region.mesh != mesh_index) continue;
    const auto claim = [&](const std::vector<std::string>& names, const std::string& name,
                           std::vector<std::uint32_t>& of, const char* what) {
      const auto found = std::find(names.begin(), names.end(), name);
      if (found == names.end())
        throw mtf::UsageError(one_line(scene.file) + ": region '" + one_line(region.name) +
                              "': " + one_line(scene.meshes[mesh_index].file) + " has no " + what + " '" +
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
      throw mtf::UsageError(one_line(scene.file) + ": mesh '" + one_line(scene.meshes[mesh_index].name) +
                            "': no [[region]] has the faces of group '" + one_line(mesh.group_names[mesh.group[f]]) +
                            "', material '" + one_line(mesh.material_names[mesh.material[f]]) +
                            "'; add one for them, or one of the mesh without a group for the rest");
  }
  return of_face;
}

}  // namespace

double Surface::emissivity(bool back) const {
  const auto* sheet = std::get_if<heat::Sheet>(&construction.inside);
  return back && sheet != nullptr ? sheet->emissivity : construction.emissivity;
}

Surface surface_of(const MaterialSection& material) {
  const std::string where = "material '" + one_line(material.name) + "'";
  Surface surface;
  surface.name = material.name;
  for (const LayerSection& layer : material.layers) {
    surface.construction.layers.push_back(
        {layer.conductivity_w_m_k, layer.density_kg_m3, layer.heat_capacity_j_kg_k, layer.thickness_m});
  }
  surface.construction.emissivity = material.emissivity.value;
  surface.construction.convection = convection_of(material.convection);
  surface.solar_absorptance = material.solar_absorptance;
  surface.back_solar_absorptance = material.inside.back_solar_absorptance.value_or(material.solar_absorptance);
  set_inside(material, surface);
  surface.construction.wet_fraction = material.wet_fraction;
  if (auto* sheet = std::get_if<heat::Sheet>(&surface.construction.inside)) sheet->wet_fraction = material.wet_fraction;
  require_valid(surface.construction, where);
  set_sources(material, surface);
  constexpr double kLeast_w_m2_k = 1e-3;  // about a thousandth of what a black surface radiates at 200 K
  constexpr double kWind_m_s = 1.0, kKelvin = 300.0;
  const auto& c = surface.construction;
  const auto* film = std::get_if<heat::InnerFilm>(&c.inside);
  const double gives = 4.0 * c.emissivity * radiometry::kStefanBoltzmann_w_m2_k4 * std::pow(kKelvin, 3) +
                       forced_coefficient(c.convection, kWind_m_s) + (film != nullptr ? film->h_w_m2_k : 0.0);
  const bool loses = gives > kLeast_w_m2_k || std::holds_alternative<heat::FixedTemperature>(c.inside);
  if (!loses)
    throw mtf::UsageError(where +
                          ": radiation, convection and film give off next to nothing, so that nothing "
                          "determines its temperature; give an emissivity, or convection");
  return surface;
}

Surfaces read_surfaces(const SceneFile& scene) {
  if (scene.ground && scene.ground->temperature && !scene.ground->temperature->table.empty())
    throw mtf::UsageError(one_line(scene.file) +
                          ": [ground]: it has no facets, so that no table of them tells its temperature; give a "
                          "temperature, or a schedule as a CSV file of time and temperature");
  Surfaces surfaces;
  for (const MaterialSection& material : scene.materials) {
    surfaces.material.push_back(surface_of(material));
    surfaces.material.back().construction.air_pressure_pa = heat::standard_pressure_pa(scene.place.altitude_m);
  }
  std::vector<Mesh> meshes;
  for (const MeshSection& mesh : scene.meshes)
    meshes.push_back(mesh.file.empty() ? open_facet() : import_mesh(mesh.file, mesh.unit_m));
  std::vector<radiometry::scene::PlacedMesh> placed;
  std::vector<std::vector<std::uint32_t>> regions;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    placed.push_back({scene.meshes[m].name, &meshes[m]});
    regions.push_back(regions_of_faces(scene, m, meshes[m]));
  }
  surfaces.facets = facets_of(placed);
  std::vector<bool> used(scene.regions.size(), false);
  for (const radiometry::scene::Facet& facet : surfaces.facets.facet) {
    surfaces.region.push_back(regions[facet.mesh][facet.face]);
    used[surfaces.region.back()] = true;
  }
  for (std::size_t r = 0; r < used.size(); ++r) {
    if (used[r]) continue;
    std::string reason = "; remove it, or name a group that has faces";
    for (std::size_t m = 0; m < regions.size(); ++m)
      if (std::find(regions[m].begin(), regions[m].end(), r) != regions[m].end()) {
        reason = ": those of its groups were left out";
        for (const std::string& warning : surfaces.facets.warnings)
          if (warning.starts_with("mesh `" + scene.meshes[m].name + "`")) reason += "; " + warning;
      }
    throw mtf::UsageError(one_line(scene.file) + ": region '" + one_line(scene.regions[r].name) + "' has no face" +
                          one_line(reason));
  }
  surfaces.warnings = surfaces.facets.warnings;
  return surfaces;
}

}  // namespace apps::scene
