// SPDX-License-Identifier: Apache-2.0
#pragma once

// Wavefront OBJ: `v`, `f`, `g`, `o` and `usemtl` lines; all others are passed over. Indices count from 1, or backwards
// from the last vertex when they are negative. A backslash at the end of a line continues it.

#include <string_view>

#include "radiometry/scene/mesh.h"

namespace apps::scene {

/// Throws std::runtime_error with the number of the line.
radiometry::scene::Mesh read_obj(std::string_view text);

}  // namespace apps::scene
