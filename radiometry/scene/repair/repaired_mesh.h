// SPDX-License-Identifier: Apache-2.0
#pragma once

// A mesh without the faces that cannot be used, over vertices at different positions: facets.h says what is left out.

#include <cstdint>
#include <vector>

#include "radiometry/scene/facets.h"
#include "radiometry/scene/repair/shells.h"

namespace radiometry::scene {

struct RepairedMesh {
  std::vector<Point> vertices;
  Polygons faces;
  std::vector<std::uint32_t> source;  ///< of each face: its number in the mesh
};

/// Fills the counts of the report that are of faces left out and of vertices, and the extent.
RepairedMesh repaired_mesh(const PlacedMesh& placed, MeshReport& report);

}  // namespace radiometry::scene
