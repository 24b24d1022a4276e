// SPDX-License-Identifier: Apache-2.0
#pragma once

// An image in tiles: scenes that are larger than the machine, a limit of memory, regions of interest, and scenes that
// are flat in large parts.

#include <optional>

#include "apps/simulate/sensor_run.h"
#include "apps/simulate/simulate.h"
#include "mtf/tiles/tiles.h"
#include "mtf/work/usable_memory.h"

namespace apps {

/// A plan in tiles where so many of them are flat that it takes less time. Says so in the report.
std::optional<mtf::TiledSensorPlan> flat_tiles(const mtf::io::SensorConfig& config, const mtf::io::Scene& scene,
                                               const mtf::PlanOptions& options, RunReport& report);

/// True when a limit is given, or a region of a linear sensor, or the whole image of a file would not fit `usable` and
/// nothing of the scene, the chain, the output or the treatment of bad pixels needs the whole image.
bool wants_tiles(const SensorRun& sensor, const SceneSource& scene, const SimulateOptions& options,
                 double usable = mtf::usable_bytes());

/// simulate() of one image in tiles. Throws UsageError for a chain that needs the whole image.
SimulateResult simulate_tiles(const SensorRun& sensor, SceneSource& scene, const SimulateOptions& options);

}  // namespace apps
