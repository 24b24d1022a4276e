// SPDX-License-Identifier: Apache-2.0
#pragma once

// `mtf simulate` in tiles: --memory, --roi, and scenes that are larger than the machine or flat in large parts.

#include <optional>

#include "apps/options.h"
#include "apps/run_report.h"

namespace apps {

/// True when a limit or a region is given, or the whole image would not fit the machine.
bool wants_tiles(const SimulateOptions& options);

/// Reads, compiles, runs, writes and reports. Returns the exit code; throws as run_simulate.
int simulate_tiles(const SimulateOptions& options, const Global& global, const mtf::io::SensorConfig& config);

}  // namespace apps
