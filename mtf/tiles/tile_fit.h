// SPDX-License-Identifier: Apache-2.0
#pragma once

// The largest tiles that a limit of memory allows.

#include <cstdint>
#include <optional>
#include <string>

#include "mtf/tiles/tile_layout.h"

namespace mtf {

/// Bytes that the plans of a run take, for one sample of what each works on: known when they are compiled.
struct TileNeeds {
  double otf = 4.1, buffers = 4.4;            ///< of the plan of a tile: here those of a real OTF, transformed in float
  double post_otf = 0.0, post_buffers = 0.0;  ///< of the filters after the sampling, for a pixel
  double coarse = 0.0;                        ///< of all that the coarse image needs
};

struct FitRequest {
  TileRequest x, y;  ///< but for most_samples, which is tried
  double limit = 0.0;
  double row_bytes = 0.0, more_rows = 0.0;  ///< of the reader: for each row of a canvas, and rows besides
  double coarse_samples = 0.0;
  double channels = 1.0;
  double receiver_bytes = 0.0;  ///< of the receiver of tiles, for a pixel of a tile
  double held_bytes = 0.0;      ///< of the caller
  int threads = 1;
  TileNeeds needs;
};

struct Fit {
  TileAxis x, y;
  int in_flight = 1;   ///< tiles at work at once
  double bytes = 0.0;  ///< of the run
  double overlap() const { return x.overlap() * y.overlap(); }
};

/// Largest ratio of the area of a tile's canvas to that of the tile: beyond it tiles cost too much.
inline constexpr double kMostOverlap = 4.0;

/// Samples of the longest side of a canvas: longer ones leave the caches.
inline constexpr std::int64_t kLongestSide = 4096;

/// Program, libraries, tables.
inline constexpr std::int64_t kFixedBytes = 40LL << 20;

/// The number of threads has no part in the layout: the same tiles, and so the same bits, for any. Nothing, and the
/// reason, where no tile fits.
std::optional<Fit> fit_tiles(const FitRequest& request, std::string& reason);

}  // namespace mtf
