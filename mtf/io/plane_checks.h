// SPDX-License-Identifier: Apache-2.0
#pragma once

// What every image writer requires of its planes.

#include <string>
#include <vector>

#include "mtf/io/image_io.h"

namespace mtf::io {

/// Throws UsageError unless there is at least one plane and all have the same, non-empty size of at most
/// `max_plane_pixels` pixels and 2^30 columns or rows.
void check_planes(const std::string& path, const std::vector<NamedPlane>& planes);

}  // namespace mtf::io
