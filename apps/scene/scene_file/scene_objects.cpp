// SPDX-License-Identifier: Apache-2.0

// [[mesh]], [[region]], [ground] and [camera] of a scene file.

#include <algorithm>

#include "apps/scene/scene_file/scene_reader.h"
#include "mtf/words.h"

namespace apps::scene {
namespace {

/// Of a region or the ground: a material, a temperature, or both; then the material is the surface's alone.
void require_surface(const Section& section) {
  for (const char* key : {"material", "temperature"})
    if (section.find(key) != nullptr || section.reader.has_failed(section.at(key))) return;
  section.error("material", "missing; write the name of a [[material]], or temperature = \"300 K\" instead of solving");
}

bool same_faces(const RegionSection& a, const RegionSection& b) {
  return a.mesh == b.mesh && a.group == b.group && a.mesh_material == b.mesh_material;
}

}  // namespace

bool is_ground_alone(const SceneReader& s) {
  return s.tree.find("ground") != nullptr && s.tree.find("mesh") == nullptr && s.tree.find("region") == nullptr;
}

void read_meshes(SceneReader& s) {
  if (s.tree.find("mesh") == nullptr && !s.reader.has_failed("mesh") && !is_ground_alone(s))
    s.reader.error({}, "mesh",
                   "missing; write [[mesh]] with name = \"vehicle\" and file = \"vehicle.obj\"; a scene of one open "
                   "facet has [ground], no mesh and no region");
  for (const Section& section : find_sections(s, "mesh")) {
    MeshSection& mesh = s.scene.meshes.emplace_back();
    read_table(s, section, mesh);
    add_name(section, s.mesh_names);
    if (const Node* file = section.find("file")) mesh.file_at = file->position;
  }
}

void read_regions(SceneReader& s) {
  if (s.tree.find("region") == nullptr && !s.reader.has_failed("region") && !is_ground_alone(s))
    s.reader.error({}, "region", "missing; write [[region]] with mesh = \"vehicle\" and material = \"armour\"");
  for (const Section& section : find_sections(s, "region")) {
    RegionSection region;
    read_table(s, section, region);
    require_surface(section);
    const bool on_mesh = !s.reader.has_failed(section.at("mesh"));
    if (region.name.empty())
      region.name = !region.group.empty()           ? region.group
                    : !region.mesh_material.empty() ? region.mesh_material
                    : on_mesh                       ? std::string(s.mesh_names[region.mesh])
                                                    : std::string();
    const auto& regions = s.scene.regions;
    if (on_mesh && std::ranges::any_of(regions, [&](const auto& other) { return same_faces(other, region); }))
      section.error("mesh", "there is a region of the same faces already");
    if (std::any_of(regions.begin(), regions.end(), [&](const auto& other) { return other.name == region.name; }))
      section.error("name", "there is a region \"" + mtf::printable(region.name, 40) +
                                "\" already; give this one a name of its own");
    s.scene.regions.push_back(std::move(region));
  }
}

void read_ground(SceneReader& s) {
  const auto section = find_section(s, "ground", "");
  if (!section) return;
  read_table(s, *section, s.scene.ground.emplace());
  require_surface(*section);
}

void read_measured(SceneReader& s) {
  const auto section = find_section(s, "measured", "");
  if (!section) return;
  MeasuredSection& measured = s.scene.measured.emplace();
  read_table(s, *section, measured);
  if (measured.temperature.constant())
    section->error("temperature", "a measured day is a table of times; write the name of a CSV file");
}

void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::optional<CameraPath>& value) {
  std::string file;
  read_value(s, section, of_type(FieldType::file, row), file);
  if (!file.empty()) try {
      value = read_camera_path(file);
    } catch (const mtf::Error& error) {
      section.error(row.name, mtf::printable(error.what(), 400));
    }
}

void read_camera(SceneReader& s) {
  const auto found = find_section(s, "camera", "");
  if (!found) return;
  const Section& section = *found;
  CameraSection camera;
  read_table(s, section, camera);
  if (camera.up == std::array<double, 3>{}) section.error("up", "a direction of length 0");
  if (section.find("path") != nullptr) {
    for (const std::string_view key : {"position", "look_at"})
      if (section.find(key) != nullptr) section.error(key, "the camera has a path already; leave out one of them");
    if (!camera.path) return;
    camera.position_m = camera.path->place.front().position_m;
    camera.look_at_m = camera.path->place.front().look_at_m;
  } else {
    for (const FieldInfo& row : rows_of<CameraSection>())
      if (row.name == "position" || row.name == "look_at") require_value(section, required(row));
    if (s.reader.has_failed("camera.position") || s.reader.has_failed("camera.look_at")) return;
    if (camera.position_m == camera.look_at_m) section.error("look_at", "the camera looks at its own position");
  }
  s.scene.camera = std::move(camera);
}

}  // namespace apps::scene
