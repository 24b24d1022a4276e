// SPDX-License-Identifier: Apache-2.0
#pragma once

// A mesh from a file: OBJ, PLY, STL and glTF 2 (.gltf, .glb).
//
//   const radiometry::scene::Mesh vehicle = apps::scene::import_mesh("vehicle.obj", 1.0);
//
// The file is parsed in a process of its own, `libexec/mtfkit/mtfkit-import`, which is given
// limits on memory, processor time and output. A damaged or malicious file can therefore stop that process only: the
// caller gets an error that names the file. The process ends with the caller, however that one ends.
//
// Faces stay the polygons that the file has. Vertices with the same coordinates become one vertex, others stay apart;
// those that no face uses are left out. What else the file holds is refused where it would change the shape, and noted
// where it is left out (README.md has the list). Coordinates keep the precision of the file. Those that are not finite
// stay, and so do faces of fewer than three corners: radiometry/scene/facets.h leaves them out and counts them, with
// the other repairs of a mesh.
//
//   format       group of a face                                   material of a face
//   OBJ          the name in the `g` or `o` line before it         the name in `usemtl` (.mtl files are not opened)
//   PLY          none                                              none
//   STL          the word after `solid`                            none
//   glTF 2       the name of its node, whose transforms apply      the name of the material of its primitive
//
// A face without a group or a material has the empty name. Buffers of a .gltf file are read from its own folder only.

#include <cstdint>
#include <filesystem>

#include "radiometry/scene/mesh.h"

namespace apps::scene {

/// The axis of the file that points up. A file with y up is turned about x by 90 degrees: (x, y, z) becomes (x, -z, y),
/// the scene's east, north, up.
enum class Up {
  of_format,  ///< y for glTF, whose specification says so; z for the others, which say nothing
  y,
  z
};

/// What the process that parses the file may use. 0 stands for a limit that grows with the size of the file.
struct ImportLimits {
  std::uint64_t memory_bytes = 0;  ///< of address space: 512 MiB and 64 bytes a byte of the file, at most what
                                   ///< is usable
  std::uint32_t cpu_s = 0;         ///< of processor time, whole seconds: 1 s and 1 s for every 4 MiB
  std::uint64_t output_bytes = 0;  ///< of the mesh, about 60 bytes a face: 64 MiB and 64 bytes a byte of the file,
                                   ///< at most a quarter of the usable memory
};

/// The mesh in `file`, whose coordinates are multiples of `unit_m` metres. Throws UsageError for an extension that is
/// not one of .obj, .ply, .stl, .gltf, .glb, and for a unit that is not positive; RuntimeError when the file is
/// missing, no ordinary file, empty, damaged (cut short, a vertex that is no number, a face with a vertex that is not
/// there) or without faces, when the process came up against a limit or crashed, and when it is not installed.
radiometry::scene::Mesh import_mesh(const std::filesystem::path& file, double unit_m, Up up = Up::of_format,
                                    const ImportLimits& limits = {});

}  // namespace apps::scene
