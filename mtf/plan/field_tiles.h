// SPDX-License-Identifier: Apache-2.0
#pragma once

// An OTF that changes over the image, its deviations from the mean in tiles with few modes of their own
// (mtf/field/tile_modes.h). A tile takes the samples about it as one period, transforms them once, and comes back once
// for each of its modes, whatever phase they have; what a mode brings is weighted and added to the image of the mean.
//
// The halo. What a tile misses is what the kernels of the deviations reach beyond its halo; the bound is that of tiles
// of one OTF (Young, mtf/tiles). An optic that passes the scene's Nyquist frequency has kernels that fall slowly. The
// scene is then interpolated first, exactly, by a quarter or more samples, and the OTFs end smoothly between the
// scene's Nyquist frequency and that of the finer grid (mtf/otf/taper.h), so that a short halo keeps tight tolerances.

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "mtf/engines/fft/spectral.h"
#include "mtf/field/tile_modes.h"
#include "mtf/plan/plan.h"

namespace mtf {

struct FieldTilesTask {
  const FieldModes& field;
  const System<double>& axis;  ///< the system of one place
  SampleGrid in, out;
  const PlanOptions& options;
  double norm = 1.0;     ///< of the defined canvas, where all of it lies in the image, relative to the scene's std
  double allowed = 0.0;  ///< error for modes that are left out, and for halos
  std::function<Plan(const SampleGrid&)> interpolate;  ///< the plan of the scene on a finer grid
};

/// Tiles of an axis: tile i begins at pixel i x tile, and reads the samples of a period about it.
struct FieldTileAxis {
  PitchRatio ratio;  ///< of the samples that tiles read
  std::int64_t tile = 0, count = 0;
  AxisTransform job = {};  ///< its samples begin with those of the tile; what lies before it comes last
  std::int64_t halo = 0;   ///< samples on each side, at least
  std::int64_t tile_samples() const { return tile / ratio.pixels * ratio.samples; }
  /// Of the scene, at place k of the period of tile i; beyond the edges where it is not within the scene.
  std::int64_t sample(std::int64_t i, std::int64_t k) const {
    return i * tile_samples() + (k < job.samples - halo ? k : k - job.samples);
  }
};

/// Tiles as they are judged, before their OTFs are made.
struct FieldTilesChoice {
  Candidate candidate;  ///< candidate.reason: why there are none
  std::array<FieldTileAxis, 2> axes;
  std::array<std::int64_t, 2> halos{};                        ///< samples that are enough, of which axes may have more
  SampleGrid grid;                                            ///< of the samples that tiles read,
  std::optional<Plan> finer = {};                             ///< which this makes of the scene
  std::vector<std::shared_ptr<const FactoredOtf>> otfs = {};  ///< of the modes of the image, on that grid
  std::vector<TileModes> tiles = {};                          ///< row by row
};

/// The interpolation, tiles and halo of least cost that keep `allowed`.
FieldTilesChoice choose_field_tiles(const FieldTilesTask& task);

class FieldTiles {
 public:
  /// How far OTFs have to be known, in units of the scene's Nyquist frequencies.
  static constexpr double kReach = 1.25;
  /// Pixels on a side of the smallest tiles, about.
  static constexpr std::int64_t kLeastSide = 128;

  FieldTiles(FieldTilesChoice choice, Border border, int threads);

  /// Adds what the deviations make of a scene to the image of the mean OTF.
  void add(ImageView<const float> scene, ImageView<float> image, double border_value, int threads) const;
  std::int64_t otf_bytes() const;
  std::int64_t run_bytes() const;

 private:
  void add_tile(std::size_t tile, ImageView<const float> samples, double border_value, ImageView<float> image) const;

  FieldTilesChoice choice_;
  Border border_;
  SpectralEngine<float> engine_;
  std::vector<std::vector<OtfBlocks<float>>> otfs_;  ///< [tile][mode]
};

}  // namespace mtf
