// SPDX-License-Identifier: Apache-2.0
#pragma once

// PLY (Turk 1994): a header that lists elements with their properties, then their values as text or in binary, in
// either byte order. Read are x, y, z of the element `vertex` and the list `vertex_indices` (or `vertex_index`) of
// `face` and of `tristrips`, strips of triangles that -1 divides. Elements of other names are noted. In a text every
// element ends its line, and nothing follows the last one: a header that does not fit the values is refused.

#include <string_view>

#include "radiometry/scene/mesh.h"

namespace apps::scene {

/// Throws std::runtime_error with the element that is wrong, and when the file ends before all that it announces.
radiometry::scene::Mesh read_ply(std::string_view content);

}  // namespace apps::scene
