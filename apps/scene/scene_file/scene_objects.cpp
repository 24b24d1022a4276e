// SPDX-License-Identifier: Apache-2.0

// [[mesh]], [[region]], [ground] and [camera] of a scene file.

#include <algorithm>
#include <cmath>

#include "apps/scene/scene_file/scene_fields.h"
#include "apps/scene/scene_file/scene_reader.h"
#include "mtf/io/file_checks.h"

namespace apps::scene {
namespace {

namespace cfg = mtf::io::cfg;
using cfg::Node;
using cfg::Section;

/// Either a material or a given temperature, or both: then the material is the surface's alone.
void read_surface(SceneReader& s, const Section& section, std::optional<std::size_t>& material,
                  std::optional<GivenTemperature>& temperature) {
  material = read_reference(section, "material", s.material_names, "material");
  if (material) s.used_materials.insert(std::string(s.material_names[*material]));
  temperature = read_given_temperature(s, section);
  if (section.find("material") == nullptr && section.find("temperature") == nullptr &&
      !s.reader.has_failed(section.at("material")) && !s.reader.has_failed(section.at("temperature")))
    section.error("material",
                  "missing; write the name of a [[material]], or temperature = \"300 K\" instead of solving");
}

bool same_faces(const RegionSection& a, const RegionSection& b) {
  return a.mesh == b.mesh && a.group == b.group && a.mesh_material == b.mesh_material;
}

double distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

}  // namespace

bool is_ground_alone(const SceneReader& s) {
  return s.tree.find("ground") != nullptr && s.tree.find("mesh") == nullptr && s.tree.find("region") == nullptr;
}

void read_meshes(SceneReader& s) {
  const Node* list = find_tables(s, "mesh");
  if (list == nullptr) {
    if (s.tree.find("mesh") == nullptr && !s.reader.has_failed("mesh") && !is_ground_alone(s))
      s.reader.error({}, "mesh",
                     "missing; write [[mesh]] with name = \"vehicle\" and file = \"vehicle.obj\"; a scene of one open "
                     "facet has [ground], no mesh and no region");
    return;
  }
  for (std::size_t i = 0; i < list->items.size(); ++i) {
    const Node& node = list->items[i];
    const Section section{s.reader, node, "mesh[" + std::to_string(i) + "]", "[[mesh]]"};
    cfg::check_keys(section, kMeshKeys);
    MeshSection mesh;
    mesh.name = read_name(section, s.mesh_names, "vehicle");
    if (section.find("file") == nullptr && !s.reader.has_failed(section.at("file")))
      section.error("file", "missing; write file = \"vehicle.obj\" (OBJ, PLY, STL or glTF 2)");
    mesh.file = read_path(section, "file").value_or("");
    if (const Node* file = section.find("file")) mesh.file_at = file->position;
    mesh.unit_m = read_si(section, kMeshUnit).value_or(1.0);
    s.scene.meshes.push_back(std::move(mesh));
  }
}

void read_regions(SceneReader& s) {
  const Node* list = find_tables(s, "region");
  if (list == nullptr) {
    if (s.tree.find("region") == nullptr && !s.reader.has_failed("region") && !is_ground_alone(s))
      s.reader.error({}, "region", "missing; write [[region]] with mesh = \"vehicle\" and material = \"armour\"");
    return;
  }
  for (std::size_t i = 0; i < list->items.size(); ++i) {
    const Node& node = list->items[i];
    const Section section{s.reader, node, "region[" + std::to_string(i) + "]", "[[region]]"};
    cfg::check_keys(section, kRegionKeys);
    RegionSection region;
    region.group = cfg::read_string(section, "group").value_or("");
    region.mesh_material = cfg::read_string(section, "mesh_material").value_or("");
    if (section.find("mesh") == nullptr && !s.reader.has_failed(section.at("mesh")))
      section.error("mesh", "missing; write the name of a [[mesh]]");
    const auto mesh = read_reference(section, "mesh", s.mesh_names, "mesh");
    if (mesh) s.used_meshes.insert(std::string(s.mesh_names[*mesh]));
    region.mesh = mesh.value_or(0);
    read_surface(s, section, region.material, region.temperature);
    region.name = cfg::read_string(section, "name").value_or("");
    if (region.name.empty())
      region.name = !region.group.empty()           ? region.group
                    : !region.mesh_material.empty() ? region.mesh_material
                    : mesh                          ? std::string(s.mesh_names[*mesh])
                                                    : std::string();
    const auto& regions = s.scene.regions;
    if (mesh &&
        std::any_of(regions.begin(), regions.end(), [&](const auto& other) { return same_faces(other, region); }))
      section.error("mesh", "there is a region of the same faces already");
    if (std::any_of(regions.begin(), regions.end(), [&](const auto& other) { return other.name == region.name; }))
      section.error("name", "there is a region \"" + mtf::io::printable(region.name, 40) +
                                "\" already; give this one a name of its own");
    s.scene.regions.push_back(std::move(region));
  }
}

void read_ground(SceneReader& s) {
  const Node* table = find_section(s, "ground", "");
  if (table == nullptr) return;
  const Section section{s.reader, *table, "ground", "[ground]"};
  cfg::check_keys(section, kGroundKeys);
  GroundSection& ground = s.scene.ground.emplace();
  read_surface(s, section, ground.material, ground.temperature);
}

void read_measured(SceneReader& s) {
  const Node* table = find_section(s, "measured", "");
  if (table == nullptr) return;
  const Section section{s.reader, *table, "measured", "[measured]"};
  cfg::check_keys(section, kMeasuredKeys);
  MeasuredSection& measured = s.scene.measured.emplace();
  measured.temperature = read_schedule_value(s, section, kTemperature).value_or(radiometry::heat::Schedule{});
  if (measured.temperature.constant())
    section.error("temperature", "a measured day is a table of times; write the name of a CSV file");
  measured.sd_k = read_si(section, kMeasuredSd);
}

void read_camera(SceneReader& s) {
  const Node* table = find_section(s, "camera", "");
  if (table == nullptr) return;
  const Section section{s.reader, *table, "camera", "[camera]"};
  cfg::check_keys(section, kCameraKeys);
  const auto up = read_point(section, "up");
  if (up && distance(*up, {}) == 0.0) section.error("up", "a direction of length 0");
  CameraSection camera;
  if (section.find("path") != nullptr) {
    for (const std::string_view key : {"position", "look_at"})
      if (section.find(key) != nullptr) section.error(key, "the camera has a path already; leave out one of them");
    const auto file = read_path(section, "path");
    if (!file) return;
    try {
      camera.path = read_camera_path(*file);
    } catch (const mtf::Error& error) {
      return section.error("path", mtf::io::printable(error.what(), 400));
    }
    camera.position_m = camera.path->place.front().position_m;
    camera.look_at_m = camera.path->place.front().look_at_m;
  } else {
    for (const std::string_view key : {"position", "look_at"})
      if (section.find(key) == nullptr && !s.reader.has_failed(section.at(key)))
        section.error(key, "missing; write " + std::string(key) + " = [\"14 m\", \"-12 m\", \"5 m\"]");
    const auto position = read_point(section, "position"), look_at = read_point(section, "look_at");
    if (!position || !look_at) return;
    if (distance(*position, *look_at) == 0.0) section.error("look_at", "the camera looks at its own position");
    camera.position_m = *position;
    camera.look_at_m = *look_at;
  }
  if (up) camera.up = *up;
  s.scene.camera = camera;
}

}  // namespace apps::scene
