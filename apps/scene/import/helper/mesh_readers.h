// SPDX-License-Identifier: Apache-2.0
#pragma once

// The formats of meshes. Readers throw std::runtime_error with what is wrong, in a text with the number of the line.

#include <filesystem>
#include <string_view>

#include "radiometry/scene/mesh.h"

namespace apps::scene {

/// glTF 2.0 (Khronos; ISO/IEC 12113:2022). The scene that the file shows is read: the triangles of its nodes, strips
/// and fans among them, with the transforms of the nodes. What would change the shape and is not applied is refused:
/// skins, morph targets with a weight, instances, extensions that the file requires. What else is left out is noted.
/// `extension`: .gltf or .glb; `folder`: of the buffers of a .gltf file. Throws std::bad_alloc when memory is short.
radiometry::scene::Mesh read_gltf(std::string_view extension, std::string_view content,
                                  const std::filesystem::path& folder);

/// Wavefront OBJ: `v`, `f`, `g`, `o` and `usemtl` lines. Indices count from 1, or backwards from the last vertex when
/// they are negative. A backslash at the end of a line continues it. Points, lines and curves (`p`, `l`, `curv`) and
/// words that are not known are noted, free-form surfaces and other files (`surf`, `call`) refused; the rest has no
/// part in polygons.
radiometry::scene::Mesh read_obj(std::string_view text);

/// PLY (Turk 1994): a header that lists elements with their properties, then their values as text or in binary, in
/// either byte order. Read are x, y, z of the element `vertex` and the list `vertex_indices` (or `vertex_index`) of
/// `face` and of `tristrips`, strips of triangles that -1 divides. Elements of other names are noted. In a text every
/// element ends its line, and nothing follows the last one: a header that does not fit the values is refused.
radiometry::scene::Mesh read_ply(std::string_view content);

/// STL (3D Systems, 1988). Binary: 80 bytes that mean nothing, the number of triangles, then 50 bytes each: a normal,
/// three vertices in single precision and two bytes. Text: `solid NAME`, then facets of one loop of vertices, then
/// `endsolid`. A file is binary when its size is that of the triangles that it announces. Normals are not read: the
/// order of the vertices says which side is outside.
radiometry::scene::Mesh read_stl(std::string_view content);

}  // namespace apps::scene
