// SPDX-License-Identifier: Apache-2.0
#pragma once

// Walls of closed shells: the facet on the other side of the wall, for conduction through it. A ray from the centre of
// a facet goes inwards, against the normal; where it meets the back of a facet of a closed shell within the thickness,
// the two are opposite. The relation need not be mutual: the faces of a wedge, or facets of different size, are
// opposite to whichever facet their centre projects on.

#include <cstdint>
#include <span>
#include <vector>

#include "radiometry/scene/rays.h"

namespace radiometry::scene {

struct OppositeFacets {
  std::vector<std::uint32_t> opposite;  ///< of each of the facets asked for, or kNone
  std::vector<double> distance_m;       ///< to it; 0 where there is none
  std::size_t unpaired = 0;             ///< facets without one, those of open shells included
};

/// Throws mtf::UsageError for a thickness that is not above 0.
OppositeFacets opposite_facets(const Rays& rays, std::span<const std::uint32_t> facets, double thickness_m,
                               int threads = 0);

}  // namespace radiometry::scene
