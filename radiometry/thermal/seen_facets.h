// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which facets a camera can see: those that are met first by a straight line from its position, in whichever direction,
// since a scene file does not limit the field of view.
//
// Lines go to seven points of every triangle that may face the camera: its middle, three near its corners and three
// near the middles of its edges. Every facet that one of them meets first is seen, whichever it was sent to. Of a facet
// that is hidden but for less than the distance of these points nothing may be met, so that facets which share a corner
// with a seen one, and may face the camera, count as seen too. A facet of a closed shell may face the camera where the
// camera lies in front of its plane, or within the box around the shell. The facet on the other side of a wall belongs
// to what is seen, because it is the other end of the same column.

#include <vector>

#include "radiometry/thermal/heat_scene.h"

namespace radiometry::thermal {

/// Of each facet.
std::vector<bool> seen_facets(const HeatScene& scene, const scene::Point& camera_m, int threads);

}  // namespace radiometry::thermal
