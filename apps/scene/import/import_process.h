// SPDX-License-Identifier: Apache-2.0
#pragma once

// The process `mtfkit-import`: where its program is, and one run of it.

#include <cstdint>
#include <filesystem>
#include <string>

namespace apps::scene {

/// `libexec/mtfkit/mtfkit-import` below the build folder or the prefix that this code lies in, or that a folder of the
/// program's run path lies in. The environment variable MTFKIT_IMPORT names another one. Throws RuntimeError with the
/// places that were searched.
std::filesystem::path import_program();

struct ImportRequest {
  int descriptor = -1;           ///< of the mesh file, at its beginning
  std::string extension;         ///< ".obj"
  std::filesystem::path folder;  ///< of the buffers of a .gltf file; empty when there may be none
  std::uint64_t memory_bytes = 0, cpu_s = 0, output_bytes = 0;
};

/// Seconds that may pass for each second of processor time: a busy machine gives a tenth of a core.
inline constexpr std::uint64_t import_patience = 10;

enum class ImportEnd {
  sent,       ///< the process sent all that it had to
  too_long,   ///< it used the processor time, or `import_patience` times as long passed
  too_large,  ///< it sent more than `output_bytes`
  crashed
};

struct ImportRun {
  ImportEnd end = ImportEnd::crashed;
  std::string bytes;  ///< what it sent (mesh_stream.h)
};

/// Runs the process to its end. Throws RuntimeError when it cannot be started.
ImportRun run_import(const ImportRequest& request);

}  // namespace apps::scene
