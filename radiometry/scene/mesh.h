// SPDX-License-Identifier: Apache-2.0
#pragma once

// A mesh as a file has it: polygons over shared vertices, each with the group and the material that the file names.
// Nothing is checked or repaired here; facets.h makes planar facets of it.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace radiometry::scene {

/// Metres; x east, y north, z up.
using Point = std::array<double, 3>;

struct Mesh {
  std::vector<Point> vertices;
  std::vector<std::uint32_t> corners;   ///< vertex of each corner, face after face, counter-clockwise seen from outside
  std::vector<std::uint64_t> first;     ///< face i has the corners [first[i], first[i + 1]); size faces + 1, or empty
  std::vector<std::uint32_t> group;     ///< of each face, an index into group_names
  std::vector<std::uint32_t> material;  ///< of each face, an index into material_names
  std::vector<std::string> group_names, material_names;
  std::vector<std::string> notes{};  ///< what the file holds and is not in the mesh: "2 lines (l) make no face"

  /// `first` has to hold its 0.
  void add_face(std::span<const std::uint32_t> of_vertices, std::uint32_t of_group = 0, std::uint32_t of_material = 0) {
    corners.insert(corners.end(), of_vertices.begin(), of_vertices.end());
    first.push_back(corners.size());
    group.push_back(of_group);
    material.push_back(of_material);
  }
  std::size_t faces() const { return group.size(); }
  std::span<const std::uint32_t> corners_of(std::size_t face) const {
    return std::span(corners).subspan(first[face], first[face + 1] - first[face]);
  }
};

}  // namespace radiometry::scene
