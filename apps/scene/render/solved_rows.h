// SPDX-License-Identifier: Apache-2.0
#pragma once

// The heat balance of a scene until pictures of it are taken, in memory.

#include "apps/scene/heat/read_thermal_scene.h"
#include "apps/scene/render/side_temperatures.h"

namespace apps::scene {

/// Temperatures of all facets from the output at or before `from_s` to the one at or after `to_s` (UTC); the run begins
/// where [time] says, and ends there. Throws UsageError for times that [time] does not have, and as run_heat.
HeatRows solved_rows(const SceneFile& file, double from_s, double to_s, const HeatOptions& options,
                     const HeatProgress& progress);

}  // namespace apps::scene
