// SPDX-License-Identifier: Apache-2.0
#pragma once

// The bytes that a mesh may be made of: the file itself, which is open already, and the buffers that a .gltf file
// names, which have to be ordinary files in its own folder. Nothing else is opened.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace apps::scene {

/// All that can be read from the descriptor. Throws std::runtime_error.
std::string read_all(int descriptor);

/// The file of this name, a relative reference as glTF writes it, in `folder`; nothing when it is not there, no
/// ordinary file, in another folder, or when `folder` is empty.
std::optional<std::string> buffer_file(const std::filesystem::path& folder, std::string_view uri);

}  // namespace apps::scene
