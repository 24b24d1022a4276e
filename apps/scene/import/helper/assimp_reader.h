// SPDX-License-Identifier: Apache-2.0
#pragma once

// STL and glTF 2 by Assimp, each by the one importer that is for it. They throw std::runtime_error with what is wrong,
// std::bad_alloc when memory is short.

#include <filesystem>
#include <string>

#include "radiometry/scene/mesh.h"

namespace apps::scene {

radiometry::scene::Mesh read_stl(std::string content);

/// The transforms of the nodes apply. `extension`: .gltf or .glb; `folder`: of the buffers of a .gltf file.
radiometry::scene::Mesh read_gltf(const std::string& extension, std::string content,
                                  const std::filesystem::path& folder);

}  // namespace apps::scene
