// SPDX-License-Identifier: Apache-2.0
#pragma once

// Wavefront OBJ: `v`, `f`, `g`, `o` and `usemtl` lines. Indices count from 1, or backwards from the last vertex when
// they are negative. A backslash at the end of a line continues it. Points, lines and curves (`p`, `l`, `curv`) and
// words that are not known are noted, free-form surfaces and other files (`surf`, `call`) refused; the rest has no part
// in polygons.

#include <string_view>

#include "radiometry/scene/mesh.h"

namespace apps::scene {

/// Throws std::runtime_error with the number of the line.
radiometry::scene::Mesh read_obj(std::string_view text);

}  // namespace apps::scene
