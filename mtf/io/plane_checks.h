// SPDX-License-Identifier: Apache-2.0
#pragma once

// What every image writer requires of its planes, and what readers that want one ask.

#include <algorithm>
#include <string>
#include <vector>

#include "mtf/io/image_io.h"

namespace mtf::io {

/// Throws UsageError unless there is at least one plane and all have the same, non-empty size of at most
/// `max_plane_pixels` pixels and 2^30 columns or rows.
void check_planes(const std::string& path, const std::vector<NamedPlane>& planes);

/// Whether a picture of three colours is a grey one: its planes are equal.
inline bool is_grey(const std::vector<Image>& planes) {
  const auto is_first = [&](const Image& one) {
    return std::equal(one.data(), one.data() + one.size(), planes[0].data(), planes[0].data() + planes[0].size());
  };
  return planes.size() == 3 && is_first(planes[1]) && is_first(planes[2]);
}

}  // namespace mtf::io
