// SPDX-License-Identifier: Apache-2.0
#pragma once

// A mesh face by face. Vertices with the same coordinates become one; -0 is 0.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>

#include "radiometry/scene/mesh.h"

namespace apps::scene {

class MeshBuilder {
 public:
  MeshBuilder() { mesh_.first.push_back(0); }

  /// Of the faces that follow; empty until then. A name that no face has is not in the mesh.
  void set_group(std::string_view name);
  void set_material(std::string_view name);

  /// The number of the vertex there. Throws std::runtime_error when there are 2^32.
  std::uint32_t vertex(radiometry::scene::Point point);
  /// Of whatever number of corners: facets_of leaves out what has fewer than three, and counts it.
  void add_face(std::span<const std::uint32_t> vertices);

  /// Of what the file holds and the mesh does not; once each.
  void note(const std::string& text);

  radiometry::scene::Mesh take() { return std::move(mesh_); }

 private:
  struct PointHash {
    std::size_t operator()(const radiometry::scene::Point& point) const;
  };

  radiometry::scene::Mesh mesh_;
  std::unordered_map<radiometry::scene::Point, std::uint32_t, PointHash> vertices_;
  std::unordered_map<std::string, std::uint32_t> groups_, materials_;
  std::string group_name_, material_name_;
  std::optional<std::uint32_t> group_, material_;  // numbers of the names, once a face has them
};

}  // namespace apps::scene
