// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sides of facets that take in radiation, and their rays: what each side sees, and when the sun shines on it. Rays
// are traced once, with each side a patch of its own: what is merged, they tell.

#include "radiometry/scene/sun_visibility.h"
#include "radiometry/scene/views.h"
#include "radiometry/thermal/heat_scene.h"

namespace radiometry::thermal {

/// The fronts of all facets, then the backs of sheets; where the back of each facet stands: for a pair, the front of
/// the opposite facet.
struct Sides {
  std::vector<scene::Side> sides;
  std::vector<std::uint32_t> back_of;  ///< of each facet, kNone without
};

Sides sides_of(const HeatScene& scene);

/// The number of rays of each side, empty where all have `rays`: what no one asks for is only seen by others, patch by
/// patch, so that few rays do for each.
std::vector<int> rays_of(const HeatScene& scene, const Sides& all, int rays);

/// Whether no ray from a side left the scene, nor met anything but the inside of the solid that covers it: then it sees
/// its own patch alone.
std::vector<bool> covered_sides(const scene::Views& seen);

/// Shadows of the sides that see any sky; the others are dark.
scene::SunVisibility sun_of(const HeatScene& scene, const Sides& all, const scene::Views& seen,
                            const scene::SunOptions& options);

/// Throws UsageError where the table of shadows has no room: it has a byte, and classes have four, for each side and
/// direction.
void require_room(const HeatScene& scene, const Sides& all);

}  // namespace radiometry::thermal
