// SPDX-License-Identifier: Apache-2.0
#pragma once

// A scene through a sensor, as one call:
//   scene (radiance, temperature, counts) -> presample OTF, sampling at the pitch -> readout and postsample filters,
// or, for a sensor file with [detector], -> the whole chain of radiometry/chain/chain.h: electrons, counts, display.
// One image, a sequence of frames and an image in tiles are the same call; the options and the scene say which.
//
//   const mtf::io::SensorConfig sensor = apps::read_sensor_file("sensor.toml");
//   const apps::SimulateResult result = apps::simulate(sensor, {.file = "scene.exr"}, {.tolerance = 1e-3});
//   const mtf::Image& image = result.images.front().planes.front();
//
// For image after image of one scene by a sensor that changes, see live_simulation.h. Nothing is printed here.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "apps/sensor/sensor_chain.h"
#include "apps/simulate/run_report.h"
#include "apps/simulate/scene_source.h"
#include "apps/simulate/simulate_options.h"
#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/io/image_io.h"

namespace apps {

/// SimulateOptions::watch has ended a run.
class Cancelled : public mtf::RuntimeError {
 public:
  using mtf::RuntimeError::RuntimeError;
};

/// One image of the sensor: pixels on the detector grid, of RunReport::quantity() in RunReport::unit().
struct SimulatedImage {
  std::int64_t frame = 0;            ///< number of the frame; 0 outside of sequences
  std::vector<mtf::Image> planes{};  ///< one for each name in SimulateResult::names
  mtf::io::Metadata metadata{};      ///< what mtf::io::write_exr stores with it: quantity, unit, pitch, provenance
};

/// What SimulateOptions::sink gets: an image, or one tile of it. All of it is valid during the call only.
struct ImagePart {
  std::int64_t frame = 0;
  mtf::Region region{};                                 ///< in pixels of the image
  const std::vector<std::string>& names;                ///< of the planes
  std::span<const mtf::ImageView<const float>> planes;  ///< the pixels of the region
  const mtf::io::Metadata& metadata;                    ///< of the image
};

struct SimulateResult {
  std::vector<std::string> names{};      ///< of the planes: "Y", or "R", "G", "B", or those of the scene
  std::vector<SimulatedImage> images{};  ///< rising frames; empty where a file or SimulateOptions::sink took them
  /// Of the planes of one image or of the region of it that is wanted; none of tiles that a sink took. Saturated pixels
  /// in `report` are those of the whole image, but for tiles, which make the region alone.
  std::vector<mtf::Statistics> statistics{};
  RunReport report{};  ///< what was done, how exactly and how fast; to_json() of it
};

/// Runs the whole of it. `scene` is used up. Throws UsageError for a request that cannot be met (options that exclude
/// each other, a tolerance or a memory that is too small, channels that are not there), RuntimeError for files and
/// pixels that fail and for a full disk, Cancelled. Output files appear whole or not at all; of a sequence the frames
/// before the one that failed are whole. The pixels are the same for any number of threads. Calls may run at the same
/// time in several threads, but for one with SimulateOptions::memory.
SimulateResult simulate(const mtf::io::SensorConfig& sensor, SceneSource scene, const SimulateOptions& options = {});

}  // namespace apps
