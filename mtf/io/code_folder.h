// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the toolkit lies: what belongs to it (modules, programs) is found from there, wherever it has been moved to.

#include <filesystem>

namespace mtf::io {

/// Folder of the shared library or the program that contains `code`.
std::filesystem::path code_folder(const void* code);

}  // namespace mtf::io
