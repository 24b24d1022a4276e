// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the process that parses a file sends to the one that asked for the mesh: the kind of the result, then a text or
// the mesh, in the byte order of the machine.
//
//   u64 kind                              ImportOutcome
//   text                                  unless it is a mesh
//   u64 x 6                               numbers of vertices, faces, corners, group names, material names, notes
//   f64 x 3 vertices, u32 x corners       coordinates; vertex of each corner
//   u32 x 3 faces                         corners of each face, group of each, material of each
//   (u32 length, bytes) x names           group names, then material names, then notes
//
// The receiver trusts nothing: numbers are compared with the bytes that came before memory is taken.

#include <cstdint>
#include <string>
#include <string_view>

#include "radiometry/scene/mesh.h"

namespace apps::scene {

enum class ImportOutcome : std::uint64_t {
  mesh = 1,
  damaged,        ///< the text says what is wrong with the file
  out_of_memory,  ///< the limit on memory
  too_large       ///< the limit on output
};

/// Bytes of the mesh in this form.
std::uint64_t stream_size(const radiometry::scene::Mesh& mesh);

std::string encode_mesh(const radiometry::scene::Mesh& mesh);
std::string encode_failure(ImportOutcome outcome, std::string_view text);

struct DecodedImport {
  ImportOutcome outcome = ImportOutcome::mesh;
  std::string text;
  radiometry::scene::Mesh mesh;
};

/// Throws RuntimeError when the bytes are not of this form: too few, too many, an index that leads nowhere.
DecodedImport decode_import(std::string_view bytes);

}  // namespace apps::scene
