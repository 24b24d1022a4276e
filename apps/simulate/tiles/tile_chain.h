// SPDX-License-Identifier: Apache-2.0
#pragma once

// A sensor in a run in tiles (radiometry/chain/chain_tiles.h): which sensors and scenes can go through it, the scene's
// windows as light, and each tile from light to the output stage, with one report for all. Of a linear sensor the
// windows are light as they are, and the filtered tile is the output.

#include <mutex>
#include <optional>

#include "apps/simulate/sensor_run.h"
#include "apps/simulate/tiles/tile_scene.h"
#include "mtf/io/tile_store.h"
#include "radiometry/chain/chain_tiles.h"

namespace apps {

/// radiometry::whole_image_stages() up to the image that is wanted; "" of a linear sensor.
std::string stages_of_the_whole(const SensorRun& sensor);

/// Throws UsageError for a sensor with such stages: it names them, and the last output stage before them.
void require_tileable(const SensorRun& sensor);

/// What of a sensor's filters tiles do themselves: all of a linear sensor, the presample OTF and the sampling before a
/// chain.
mtf::System<double> tiled_system(const SensorRun& sensor);

/// From now on the windows of `source` are light. Reads the whole scene once, after the checks of the sensor's maps.
/// Returns what a constant border is worth. Throws UsageError as require_light_of_windows, require_maps and
/// light_of_windows.
double read_as_light(const SensorRun& sensor, const std::string& file, TileScene& source, std::int64_t memory,
                     int threads, RunWatch& watch);

/// What the chain needs beside the plan of the tiles.
void count_memory(const SensorRun& sensor, mtf::TileOptions& options);

/// What comes after the filters of the tiles of one run, and what it has counted in all of them.
class ChainOfTiles {
 public:
  using Planes = std::span<const mtf::ImageView<const float>>;
  /// Takes a finished tile and what has been counted in it. Called from several threads at once.
  using Take = std::function<void(const mtf::Tile& tile, Planes planes, const mtf::io::TileCounts& counts)>;

  /// `first` is the pixel of the detector at which the output of `plan` starts. The counts go to `report`, that of the
  /// sensor, which lives longer. Throws UsageError as TiledChain.
  ChainOfTiles(const SensorRun& sensor, const mtf::TiledSensorPlan& plan, radiometry::Origin first, int threads,
               std::optional<ChainReport>& report);

  /// Filtered light to the output stage. From several threads at once.
  void run(const mtf::Tile& tile, Planes filtered, const Take& take);
  /// How many counts there are.
  std::size_t counts_a_tile() const;
  /// Adds what a stopped run counted in a tile.
  void add(const mtf::io::TileCounts& counts);

 private:
  std::optional<radiometry::TiledChain> chain_;
  radiometry::Origin first_;
  int threads_;
  std::mutex lock_;
  std::optional<ChainReport>& report_;
};

}  // namespace apps
