// SPDX-License-Identifier: Apache-2.0
#pragma once

// glTF 2.0 (Khronos; ISO/IEC 12113:2022). The scene that the file shows is read: the triangles of its nodes, strips and
// fans among them, with the transforms of the nodes. What would change the shape and is not applied is refused: skins,
// morph targets with a weight, instances, extensions that the file requires. What else is left out is noted.

#include <filesystem>
#include <string_view>

#include "radiometry/scene/mesh.h"

namespace apps::scene {

/// `extension`: .gltf or .glb; `folder`: of the buffers of a .gltf file. Throws std::runtime_error with what is wrong,
/// std::bad_alloc when memory is short.
radiometry::scene::Mesh read_gltf(std::string_view extension, std::string_view content,
                                  const std::filesystem::path& folder);

}  // namespace apps::scene
