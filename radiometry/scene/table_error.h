// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sampling error of tables of views and of visibility, from a second independent set with twice the rays (and, of
// the sun, at other directions too) on facets picked at random. The difference of two sets has the variance of both; it
// is reported as it is, so that the error of the first one is overstated by a factor of 1.1 to 1.2.

#include <cstdint>
#include <span>

#include "radiometry/scene/sun_visibility.h"
#include "radiometry/scene/views.h"

namespace radiometry::scene {

/// Over `count` sides, which is all of them where the scene has fewer than were asked for.
struct TableError {
  double rms = 0.0;
  double percentile_95 = 0.0;  ///< of the absolute difference
  std::size_t count = 0;
};

/// Of the view of the whole sky, and of other surfaces.
struct ViewError {
  TableError sky, surfaces;
};

/// `views` was made of `receivers` with `options`; of those among the receivers, where they are named.
ViewError view_error(const Rays& rays, const Receivers& receivers, const Views& views, const ViewOptions& options,
                     std::size_t count = 2000, std::span<const std::uint32_t> among = {});

/// A direction to the sun, of length 1, and its place in the table: after an entry, by a share of the time to the next.
struct SunCheck {
  Vector to_sun{};
  std::size_t entry = 0;
  double share = 0.0;
};

struct SunError {
  TableError of_directions;  ///< over sides and those directions that they face
  TableError of_sides;       ///< over sides, of the largest of all directions
};
/// Of the irradiance by the sun as a share of the direct normal irradiance, visibility times cosine. `sun` was made of
/// `sides` with `options`.
SunError sun_error(const Rays& rays, std::span<const Side> sides, std::span<const SunCheck> checks,
                   const SunVisibility& sun, const SunOptions& options, std::size_t count = 2000);

}  // namespace radiometry::scene
