// SPDX-License-Identifier: Apache-2.0
#pragma once

// Faces of a mesh joined into shells, with one winding in each: facets.h has the definitions.

#include <cstdint>
#include <span>
#include <vector>

#include "radiometry/scene/facets.h"

namespace radiometry::scene {

/// Polygons over shared vertices; face i has the corners [first[i], first[i + 1]).
struct Polygons {
  std::vector<std::uint32_t> corners;
  std::vector<std::uint64_t> first{0};

  std::size_t size() const { return first.size() - 1; }
  std::span<const std::uint32_t> operator[](std::size_t i) const {
    return std::span(corners).subspan(first[i], first[i + 1] - first[i]);
  }
};

struct FaceShells {
  std::vector<std::uint32_t> shell_of;  ///< of each face
  std::vector<char> turn;               ///< of each face: its corners have to be reversed
  std::vector<char> closed{};           ///< of each shell
  std::vector<char> outward{};          ///< of each shell: closed, and its normals point out
  std::uint64_t one_sided = 0;          ///< shells that no winding suits
};

FaceShells shells_of(const Polygons& faces, std::span<const Point> vertices, Winding winding);

}  // namespace radiometry::scene
