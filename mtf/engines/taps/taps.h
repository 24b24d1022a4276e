// SPDX-License-Identifier: Apache-2.0
#pragma once

// Filtering in the space domain, for point spreads of a few samples: detector sample j along an axis is a weighted sum
// of the scene samples j x ratio + first + t, t = 0 .. count - 1, whole ratios only. Both engines walk over tiles of
// the output that fit the cache; a group of 16 outputs of a row is H(0) times one value where all
// samples that the taps read for them have this value. Taps that equal their mirror image bit by bit let mirrored
// samples be added before they are multiplied.

#include <vector>

#include "mtf/border.h"
#include "mtf/engines/buffer_pool.h"
#include "mtf/engines/engine.h"

namespace mtf {
namespace taps {
class TapsFlat;
struct TileArea;
}  // namespace taps

struct TapAxis {
  std::int64_t samples = 0;  ///< of the scene
  std::int64_t outputs = 0;  ///< detector samples, from the shared corner
  std::int64_t ratio = 1;    ///< scene samples a detector sample
  std::int64_t first = 0;    ///< of the taps of output 0, may be negative
  std::int64_t count = 1;    ///< taps
};

/// sum over rank of (taps along the columns) x (taps along the rows): rows first, then columns.
class SeparableEngine final : public Engine {
 public:
  /// x_taps[r], y_taps[r]: the pairs, of x.count and y.count taps.
  SeparableEngine(const TapAxis& x, const TapAxis& y, Border border, std::vector<std::vector<float>> x_taps,
                  std::vector<std::vector<float>> y_taps);
  void run(const std::vector<Channel>& channels, int threads) const override;
  std::int64_t run_bytes(std::int64_t channels, int threads) const override;
  std::int64_t filter_bytes() const override;

 private:
  void tile(const Channel& channel, const taps::TapsFlat& flat, const taps::TileArea& area) const;

  TapAxis x_, y_;
  Border border_;
  std::vector<std::vector<float>> x_taps_, y_taps_;
  std::vector<double> x_gains_;  ///< sums of the x taps
  bool mirrored_x_, mirrored_y_;
  std::int64_t tile_rows_;
  mutable BufferPool pool_;
};

/// One two-dimensional kernel; taps that are zero cost nothing.
class DirectEngine final : public Engine {
 public:
  /// taps: y.count rows of x.count.
  DirectEngine(const TapAxis& x, const TapAxis& y, Border border, std::vector<float> taps);
  void run(const std::vector<Channel>& channels, int threads) const override;
  std::int64_t run_bytes(std::int64_t channels, int threads) const override;
  std::int64_t filter_bytes() const override { return static_cast<std::int64_t>(taps_.size()) * 4; }

 private:
  void tile(const Channel& channel, const taps::TapsFlat& flat, const taps::TileArea& area) const;

  TapAxis x_, y_;
  Border border_;
  std::vector<float> taps_;
  bool mirrored_;  ///< along both axes
  mutable BufferPool pool_;
};

}  // namespace mtf
