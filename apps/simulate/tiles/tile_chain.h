// SPDX-License-Identifier: Apache-2.0
#pragma once

// The chain of a sensor with [detector] in a run in tiles (radiometry/chain/chain_tiles.h): which sensors and scenes
// can go through it, the scene's windows as light, and each tile from light to the output stage, with one report for
// all.

#include <mutex>

#include "apps/simulate/radiometric_chain.h"
#include "apps/simulate/tiles/tile_scene.h"
#include "mtf/io/tile_store.h"
#include "radiometry/chain/chain_tiles.h"

namespace apps {

/// radiometry::whole_image_stages() up to the image that is wanted.
std::string stages_of_the_whole(const RadiometricChain& radiometric);

/// Throws UsageError for a sensor with such stages: it names them, and the last output stage before them.
void require_tileable(const mtf::io::SensorConfig& config, const RadiometricChain& radiometric);

/// What of a sensor's filters tiles do themselves: the presample OTF and the sampling.
mtf::System<double> presample_of(const RadiometricChain& radiometric);

/// From now on the windows of `source` are light. Reads the whole scene once, after the checks of the sensor's maps.
/// Returns what a constant border is worth. Throws UsageError as require_light_of_windows, require_maps and
/// light_of_windows.
double read_as_light(const mtf::io::SensorConfig& config, const RadiometricChain& radiometric, const std::string& file,
                     TileScene& source, std::int64_t memory, int threads, RunWatch& watch);

/// What the chain needs beside the plan of the tiles.
void count_memory(const RadiometricChain& radiometric, mtf::TileOptions& options);

/// The chain on the tiles of one run, and what it has counted in all of them.
class ChainOfTiles {
 public:
  /// `first` is the pixel of the detector at which the output of `plan` starts. The counts go to `report`, which lives
  /// longer. Throws UsageError as TiledChain.
  ChainOfTiles(const mtf::io::SensorConfig& config, const RadiometricChain& radiometric,
               const mtf::TiledSensorPlan& plan, radiometry::Origin first, int threads, ChainReport& report);

  struct Result {
    mtf::Image image;
    mtf::io::TileCounts counts;  ///< of this tile
  };
  /// Light to the output stage. From several threads at once.
  Result run(const mtf::Tile& tile, mtf::ImageView<const float> light);
  /// The number of Result::counts.
  static std::size_t counts_a_tile();
  /// Adds what a stopped run counted in a tile.
  void add(const mtf::io::TileCounts& counts);

 private:
  radiometry::TiledChain chain_;
  radiometry::Origin first_;
  int threads_;
  std::mutex lock_;
  ChainReport& report_;
};

}  // namespace apps
