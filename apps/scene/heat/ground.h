// SPDX-License-Identifier: Apache-2.0
#pragma once

// The ground beyond the scene, which rays see that leave below the horizon: a level surface under the whole sky, alike
// everywhere. It is solved before the rest, which it does not feel; or it has a given temperature; or, where the scene
// file has no [ground], it is black and has the temperature of the air.

#include <optional>

#include "apps/scene/heat/heat_batches.h"

namespace apps::scene {

struct Ground {
  GroundLight light;
  std::optional<MaterialRun> run;  ///< where it is solved
};

Ground ground_of(const HeatScene& scene, double tolerance_k);

}  // namespace apps::scene
