// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `mtf fly` takes.

#include <optional>
#include <string>

#include "apps/options.h"
#include "apps/scene/command/render_options.h"
#include "apps/simulate/simulate_options.h"

namespace apps {

struct FlyCommandOptions {
  std::string scene, sensor, out;
  std::string temperatures, time, schedule;
  std::string report;  ///< JSON file to write, "" = none
  std::optional<FrameRange> frames;
  std::optional<double> seconds;
  double rate_hz = 25.0;
  double speed = 1.0;  ///< of the scene's clock
  double light_every_s = 60.0;
  double heat_tolerance_k = 0.1;
  SamplingOptions sampling;
  bool no_air = false;
  SimulateOptions image;          ///< tolerance, range, nan
  Format format = Format::table;  ///< of standard output: table or json
};

int run_fly(const FlyCommandOptions& options, const Global& global);

}  // namespace apps
