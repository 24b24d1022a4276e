// SPDX-License-Identifier: Apache-2.0
#pragma once

// STL (3D Systems, 1988). Binary: 80 bytes that mean nothing, the number of triangles, then 50 bytes each: a normal,
// three vertices in single precision and two bytes. Text: `solid NAME`, then facets of one loop of vertices, then
// `endsolid`. A file is binary when its size is that of the triangles that it announces. Normals are not read: the
// order of the vertices says which side is outside.

#include <string_view>

#include "radiometry/scene/mesh.h"

namespace apps::scene {

/// Throws std::runtime_error with what is wrong, and in a text with the number of the line.
radiometry::scene::Mesh read_stl(std::string_view content);

}  // namespace apps::scene
