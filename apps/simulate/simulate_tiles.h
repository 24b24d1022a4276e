// SPDX-License-Identifier: Apache-2.0
#pragma once

// `mtf simulate` in tiles: --memory, --roi, and scenes that are larger than the machine or flat in large parts.

#include <optional>

#include "apps/options.h"
#include "apps/simulate/run_report.h"

namespace apps {

/// A plan in tiles where so many of them are flat that it takes less time; not where pixels have been masked. Says so
/// in the report.
std::optional<mtf::TiledSensorPlan> flat_tiles(const mtf::io::SensorConfig& config, const mtf::io::Scene& scene,
                                               const std::vector<mtf::Image>& masks, const mtf::PlanOptions& options,
                                               RunReport& report);
std::vector<mtf::Image> run_flat_tiles(const mtf::TiledSensorPlan& plan, const mtf::io::Scene& scene,
                                       double border_value, RunReport& report);

/// True when a limit or a region is given, or the whole image would not fit the machine.
bool wants_tiles(const SimulateOptions& options);

/// Reads, compiles, runs, writes and reports. Returns the exit code; throws as run_simulate.
int simulate_tiles(const SimulateOptions& options, const Global& global, const mtf::io::SensorConfig& config);

}  // namespace apps
