// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of a scene that does not go through the memory: why, and with which memory or tolerance it does.
// Internal to mtf/tiles.

#include <string>

#include "mtf/tiles/tiles.h"

namespace mtf {

/// The plan with the OTF split at `every`, or whole where that is 0. Nothing, and the reason, where tiles are
/// impossible. Throws UnreachableTolerance where rounding exceeds the share of the tolerance that a part of the work
/// has.
std::optional<TiledSensorPlan> cut_into_tiles(const System<double>& system, const SampleGrid& scene,
                                              const PlanOptions& options, const TileOptions& tiles, std::int64_t every,
                                              std::string& reason);

/// "12MiB", rounded up.
std::string mebibytes(double bytes);

/// Throws UsageError. `tiles.memory` is the limit, `reason` why tiles do not keep it, `share` the least share of the
/// tolerance that a part of their work has where that is the reason, `whole` the bytes that one plan for all of the
/// scene takes.
[[noreturn]] void refuse_memory(const System<double>& system, const SampleGrid& scene, const PlanOptions& options,
                                const TileOptions& tiles, const std::string& reason, std::optional<double> share,
                                double whole);

}  // namespace mtf
