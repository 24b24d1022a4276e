// SPDX-License-Identifier: Apache-2.0
#pragma once

// How an output is cut into equal tiles along each axis. A tile starts at a whole number of pixels and of scene
// samples, so that one plan serves them all: with pitch / sample = p/q every q pixels are p samples.
//
//   |margin|      tile      |margin|     canvas of the plan, in pixels; all three are multiples of q
//          |post|    |post|              pixels that the filters after the sampling read

#include <cstdint>
#include <optional>

#include "mtf/grid.h"

namespace mtf {

struct PitchRatio {
  std::int64_t samples = 1, pixels = 1;  ///< p, q
};

/// The ratio of pitch to sample as p/q with q up to 64, exact to the rounding of a double; nothing for any other.
std::optional<PitchRatio> pitch_ratio(double pitch_um, double step_um);

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

/// What is asked of an axis. Halos in scene samples (presample) and pixels (after the sampling).
struct TileRequest {
  PitchRatio ratio;
  std::int64_t region_first = 0, outputs = 0;
  std::int64_t halo_samples = 0, post_pixels = 0;
  std::int64_t most_samples = 0;  ///< of the canvas
  std::int64_t side = 0;          ///< forced tile side in pixels, rounded up to a multiple of q; 0: by cost
};

/// The tile of least work for a pixel, length x (log2 length + 8) / tile: smooth lengths, as long as allowed. Nothing
/// when no tile fits `most_samples`.
std::optional<TileAxis> tile_axis(const TileRequest& request);

}  // namespace mtf
