// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the temperature of the ground was, measured: a table of temperatures, or the long-wave radiation that a station
// saw coming up. The ground emits epsilon sigma T^4 and reflects the rest of what the sky sends:
//   L_up = epsilon sigma T^4 + (1 - epsilon) L_down
// Records that are means over an interval stand for its middle.

#include <string>
#include <vector>

#include "apps/scene/scene_file/scene_file.h"

namespace apps::scene {

struct MeasuredSurface {
  std::string source;
  bool from_longwave = false;
  std::vector<double> time_s;  ///< from the start of the run, rising
  std::vector<double> kelvin;  ///< NaN where the record has no value
};

/// The records that lie in the run. Throws UsageError where the scene has neither [measured] temperature nor weather
/// with longwave_up and longwave_down, and where no record lies in the run.
MeasuredSurface measured_surface(const SceneFile& scene, double emissivity);

}  // namespace apps::scene
