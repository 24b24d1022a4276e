// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `mtf render` and `mtf fly` take.

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/options.h"

namespace apps {

/// How the samples of a picture are taken.
struct SamplingOptions {
  std::optional<double> samples_per_pitch{};  ///< along each axis; else as many as sensors ask for (sensor_picture.h)
  int points = 2;                             ///< n x n of each sample
};

struct RenderCommandOptions {
  std::string scene, out;            ///< `out`: a file, or of several sensors a folder
  std::vector<std::string> sensors;  ///< one or more, of one field of view
  std::string temperatures, time;
  bool heat = false;                                       ///< temperatures are solved first
  std::string picture{};                                   ///< PNG to draw, "" = none
  std::optional<std::array<double, 3>> position, look_at;  ///< m; in place of those of [camera]
  SamplingOptions sampling;
  double tolerance = 5e-6;  ///< of the tables of the air
  bool plain = false;       ///< radiance in the band, without weights
  bool no_air = false;
  std::vector<std::string> layers;
  std::string from{};                  ///< layers of another renderer, in place of the meshes; "" = none
  std::string materials{};             ///< table of their indices
  std::optional<bool> planar_depth{};  ///< of `from`; else as the file is
  std::vector<std::pair<std::string, std::string>> channels{};  ///< of `from`: role, name
  bool force = false;
  Format format = Format::table;  ///< of standard output: table or json
};

/// Writes the files; what the command prints then. Throws as the command.
std::string render_pictures(const RenderCommandOptions& options, const Global& global);

int run_render(const RenderCommandOptions& options, const Global& global);

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
  SimulateOptions image;  ///< tolerance, range, nan
  std::string device = "cpu";
  Format format = Format::table;  ///< of standard output: table or json
};

int run_fly(const FlyCommandOptions& options, const Global& global);

}  // namespace apps
