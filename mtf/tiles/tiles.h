// SPDX-License-Identifier: Apache-2.0
#pragma once

// The linear chain of a sensor tile by tile: scenes larger than memory, regions of interest, and scenes that are flat
// in large parts.
//
//   TiledSensorPlan plan = compile_tiled(system, scene_grid, options, {.memory = 1 << 30});
//   TileTally tally = plan.run(read, surveys, write, {});
//
// A tile takes the samples of its pixels and of a halo around them from the scene's canvas (mtf/border.h), filters
// them by one plan shared by all tiles, and keeps the middle. The promise is that of a SensorPlan: the rms error over
// all output pixels is at most tolerance x std of the scene. Where the halo of the whole OTF would be too long the OTF
// is split (mtf/otf/split.h): tiles do the near part, a coarse image of the whole scene the far part. Where even that
// does not help (an OTF with a step or kink at the scene's Nyquist frequency, a ratio of pitch to sample that is not
// p/q; an OTF that changes over the field) the scene is one tile, if memory allows.

#include <cstdint>
#include <functional>
#include <optional>

#include "mtf/grid.h"
#include "mtf/plan/sensor_plan.h"
#include "mtf/survey/survey.h"

namespace mtf {

struct TileOptions {
  std::int64_t memory = 0;                      ///< bytes that may be in use, 0 = those of the machine
  std::int64_t row_bytes = 0;                   ///< that the reader holds for each row of the scene that a tile needs
  std::int64_t more_rows = 0;                   ///< rows that the reader holds besides
  std::int64_t channels = 1;                    ///< of the scene
  double receiver_bytes = 0.0;                  ///< that WriteTile takes for a pixel of each tile at work
  std::int64_t held_bytes = 0;                  ///< that the caller holds during the whole run
  int threads = 0;                              ///< 0 = all cores
  std::optional<Region> region = std::nullopt;  ///< detector pixels that are wanted
  std::int64_t side = 0;                        ///< of a tile in pixels, 0 = by cost
};

struct TileReport {
  std::int64_t count = 1;                   ///< tiles of the output
  std::array<std::int64_t, 2> side{};       ///< pixels, x and y
  std::array<std::int64_t, 2> halo{};       ///< scene samples on each side
  std::array<std::int64_t, 2> post_halo{};  ///< pixels that the filters after the sampling read around a tile
  bool whole = false;                       ///< the scene is one tile
  std::string reason;                       ///< of that
  std::int64_t every = 0;                   ///< scene samples for one of the coarse image, 0 = the OTF is not split
  int in_flight = 1;                        ///< tiles at work at once
  std::int64_t bytes = 0;                   ///< predicted to be in use
  double halo_error = 0.0;                  ///< bound of what the halo leaves out, rms relative to the scene's std
  double predicted_error = 0.0, tolerance = 0.0;  ///< of the whole chain
};

/// One tile of the output; `region` is in output pixels, counted from the corner of the region of interest.
struct Tile {
  std::int64_t index = 0;
  Region region;
};

/// Takes a finished tile, one plane a channel. Called from several threads at once. Where values are beyond what
/// float32 holds, some pixels are not finite.
using WriteTile = std::function<void(const Tile& tile, std::span<const ImageView<const float>> planes)>;

struct TileRunOptions {
  double border_value = 0.0;
  std::function<bool(std::int64_t)> done = nullptr;  ///< true for tiles that are there already
  std::function<void(std::int64_t done, std::int64_t of)> progress = nullptr;  ///< serialised
};

struct TileTally {
  std::int64_t computed = 0, flat = 0, resumed = 0;  ///< tiles; flat in every channel, with the halo
  double saved_ms = 0.0;                             ///< that the flat ones would have taken, estimated
};

/// How an output is cut into equal tiles along an axis. A tile starts at a whole number of pixels and of scene samples,
/// so that one plan serves them all: with pitch / sample = p/q every q pixels are p samples.
///
///   |margin|      tile      |margin|     canvas of the plan, in pixels; all three are multiples of q
///          |post|    |post|              pixels that the filters after the sampling read
struct TileAxis {
  PitchRatio ratio;
  std::int64_t outputs = 0;  ///< pixels of the output along this axis
  std::int64_t first = 0;    ///< detector pixel at which tile 0 starts, a multiple of q
  std::int64_t skipped = 0;  ///< pixels of tile 0 before the output starts
  std::int64_t tile = 0, margin = 0, post = 0;

  std::int64_t count() const { return (skipped + outputs + tile - 1) / tile; }
  std::int64_t canvas_pixels() const { return tile + 2 * margin; }
  std::int64_t canvas_samples() const { return canvas_pixels() / ratio.pixels * ratio.samples; }
  /// First sample of the canvas of tile i; negative beyond the edge.
  std::int64_t first_sample(std::int64_t i) const { return (first + i * tile - margin) / ratio.pixels * ratio.samples; }
  double overlap() const { return static_cast<double>(canvas_pixels()) / static_cast<double>(tile); }
};

class TiledSensorPlan {
 public:
  const TileReport& report() const { return report_; }
  const SampleGrid& in() const { return in_; }
  /// The region of interest, or the whole detector grid.
  const SampleGrid& out() const { return out_; }
  /// The plan of one tile, or of the whole scene.
  const SensorPlan& inner() const { return *inner_; }
  Tile tile(std::int64_t index) const;

  /// Runs all tiles. One survey a channel, made with `every` of the report or, where that is 0, any; scenes with pixels
  /// that are not finite are refused (RuntimeError). The same bits for any number of threads.
  TileTally run(const ReadWindow& read, std::span<const Survey> surveys, const WriteTile& write,
                const TileRunOptions& options) const;
  /// Planes in memory, surveyed here.
  std::vector<Image> run(std::span<const ImageView<const float>> scene, double border_value = 0.0,
                         TileTally* tally = nullptr) const;

  /// Share of the tiles that are flat with their halo, in planes in memory; costs little where none is.
  double flat_share(std::span<const ImageView<const float>> scene, double border_value) const;

 private:
  friend TiledSensorPlan compile_tiled(const System<double>&, const SampleGrid&, const PlanOptions&,
                                       const TileOptions&);
  friend std::optional<TiledSensorPlan> cut_into_tiles(const System<double>&, const SampleGrid&, const PlanOptions&,
                                                       const TileOptions&, std::int64_t, std::string&);
  struct Workspace;
  int helpers() const;
  bool run_tile(std::int64_t index, double border_value, const Image* far, double far_mean, Workspace& memory,
                Image& out) const;
  void read_canvas(const ReadWindow& read, std::size_t channel, std::int64_t index, double border_value,
                   Image& canvas) const;
  void filter_after_sampling(std::int64_t index, double border_value, Image& pixels) const;
  TileTally run_whole(const ReadWindow& read, std::size_t channels, const WriteTile& write,
                      const TileRunOptions& options) const;

  SampleGrid in_, out_, detector_;
  Border border_ = Border::reflect;
  int threads_ = 0;
  Region region_;
  TileAxis x_, y_;
  double dc_ = 1.0;  ///< gain of the mean of the presample filter
  std::optional<SensorPlan> inner_;
  std::optional<Plan> far_;
  std::optional<CoarseGrid> coarse_;
  TileReport report_;
};

/// Scene samples for one of the coarse image of a survey that is made before the plan is; 0 where none is worth it.
std::int64_t coarse_every(const SampleGrid& scene, Border border, std::int64_t memory);

/// Throws as compile_sensor, and UsageError where the memory does not suffice, naming the least that does, and for a
/// region that is not within the detector.
TiledSensorPlan compile_tiled(const System<double>& system, const SampleGrid& scene, const PlanOptions& options,
                              const TileOptions& tiles);

/// The plan of a scene in memory that takes less time in tiles because many of them are flat; nothing where it does
/// not, which for a scene without flat parts shows at once.
std::optional<TiledSensorPlan> worth_tiling(const System<double>& system, const SampleGrid& scene,
                                            std::span<const ImageView<const float>> planes, double border_value,
                                            const PlanOptions& options);

}  // namespace mtf
