// SPDX-License-Identifier: Apache-2.0
#pragma once

// The ground beyond the scene, which rays see that leave below the horizon: a level surface under the whole sky, alike
// everywhere. It is solved before the rest, which it does not feel; or it has a given temperature; or, where the scene
// has none, it is black and has the temperature of the air.

#include <optional>

#include "radiometry/thermal/heat_batches.h"

namespace radiometry::thermal {

struct Ground {
  GroundLight light;
  std::optional<MaterialRun> run;  ///< where it is solved
};

Ground ground_of(const HeatScene& scene, double tolerance_k);

/// A level surface under the whole sky, whose first day repeats.
struct LevelRun {
  std::vector<double> kelvin;  ///< at the nodes of the surroundings
  MaterialRun run;
  heat::Plan plan;
};
/// `utc_s`: of the start of the run. `like`: the plan of a similar surface, whose cells and steps are taken where they
/// keep twice the tolerance; then small changes of the surface make small changes of the temperatures. Throws as solve.
LevelRun level_run(const Surroundings& surroundings, double utc_s, const Material& surface, double tolerance_k,
                   const heat::Plan* like = nullptr);

}  // namespace radiometry::thermal
