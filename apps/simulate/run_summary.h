// SPDX-License-Identifier: Apache-2.0
#pragma once

// The lines that `mtf simulate` ends with, for whole images and for tiles.

#include <string>
#include <vector>

#include "apps/simulate/run_report.h"
#include "mtf/survey/statistics.h"

namespace apps {

/// "out.exr  256x256  radiance [W.m^-2.sr^-1]".
std::string summary_head(const RunReport& report, const mtf::SampleGrid& out);

/// A line a channel: extremes, mean and standard deviation.
std::string summary_channels(const std::vector<std::string>& names, const std::vector<mtf::Statistics>& statistics);

/// Predicted error, and the time in its parts; the last line is not ended.
std::string summary_costs(const RunReport& report);

/// What --explain prints of a plan.
std::string explain_text(const mtf::SensorPlan& plan);

/// The same of a run in tiles, behind lines that say so; nothing else where the scene is one tile.
std::string explain_tiles(const mtf::SensorPlan& plan, const mtf::TileReport& tiles);

}  // namespace apps
