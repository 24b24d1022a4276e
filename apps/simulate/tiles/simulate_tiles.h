// SPDX-License-Identifier: Apache-2.0
#pragma once

// An image in tiles: scenes that are larger than the machine, a limit of memory, regions of interest, and scenes that
// are flat in large parts.

#include <optional>

#include "apps/simulate/radiometric_chain.h"
#include "apps/simulate/simulate.h"
#include "mtf/tiles/tiles.h"
#include "mtf/work/usable_memory.h"

namespace apps {

/// A plan in tiles where so many of them are flat that it takes less time; not where pixels have been masked. Says so
/// in the report.
std::optional<mtf::TiledSensorPlan> flat_tiles(const mtf::io::SensorConfig& config, const mtf::io::Scene& scene,
                                               const std::vector<mtf::Image>& masks, const mtf::PlanOptions& options,
                                               RunReport& report);
std::vector<mtf::Image> run_flat_tiles(const mtf::TiledSensorPlan& plan, const mtf::io::Scene& scene,
                                       double border_value, RunReport& report);

/// True when a limit is given, or a region without a chain, or the whole image of a file would not fit `usable` and
/// nothing of the scene, the chain, the output or the treatment of bad pixels needs the whole image.
bool wants_tiles(const mtf::io::SensorConfig& config, const SceneSource& scene, const SimulateOptions& options,
                 const RadiometricChain* radiometric, double usable = mtf::usable_bytes());

/// simulate() of one image in tiles; `radiometric` is the chain of a sensor that has one. Throws UsageError for a chain
/// that needs the whole image.
SimulateResult simulate_tiles(const mtf::io::SensorConfig& config, SceneSource& scene, const SimulateOptions& options,
                              const RadiometricChain* radiometric);

}  // namespace apps
