// SPDX-License-Identifier: Apache-2.0
#pragma once

// The outputs that the engines of taps.h need not compute. Outputs of a row come in groups of kVector. Where all
// samples that the taps read for a group have one value, the group is uniform: H(0) times that value.

#include <functional>
#include <vector>

#include "mtf/engines/taps/taps_tile.h"
#include "mtf/engines/uniform_runs.h"

namespace mtf::taps {

class TapsFlat {
 public:
  using Kind = UniformRuns::Kind;
  static_assert(UniformRuns::kGroup == kVector && kTileColumns % kVector == 0);

  TapsFlat(const Channel& channel, const TapAxis& x, const TapAxis& y, Border border);

  /// The value of the samples of a kind other than 0.
  float value(Kind kind) const { return map_->value(kind); }
  /// Kinds of the groups of a row of outputs from column x0 on; null where all groups have to be computed.
  const Kind* output(std::int64_t y, std::int64_t x0) const { return at(outputs_, y, x0); }
  /// The same for the taps along x alone, on the samples of canvas row y.first + r.
  const Kind* samples(std::int64_t r, std::int64_t x0) const { return at(rows_, r, x0); }
  /// Writes the uniform groups of outputs of row `y`.
  void fill_row(const Channel& channel, std::int64_t y) const;
  /// The smallest part of a tile, in whole groups, that holds all other groups; it has no rows where there are none.
  TileArea rest(const TileArea& area) const;

  static std::int64_t bytes(const TapAxis& x, const TapAxis& y);

 private:
  const Kind* at(const std::vector<Kind>& kinds, std::int64_t y, std::int64_t x0) const {
    return kinds.empty() ? nullptr : kinds.data() + y * groups_ + x0 / kVector;
  }

  const UniformRuns* map_;
  std::int64_t groups_;
  std::vector<Kind> rows_, outputs_;
};

/// Writes all uniform groups, then calls tile(channel, flat, area) for all tiles of `rows` output rows of all
/// channels, on `threads` threads.
void for_each_tile(const std::vector<Channel>& channels, const TapAxis& x, const TapAxis& y, Border border,
                   std::int64_t rows, int threads,
                   const std::function<void(const Channel&, const TapsFlat&, const TileArea&)>& tile);

/// Calls run(begin, end, kind) for the columns of each stretch of groups of one kind, in order, up to `columns`; all
/// groups are of kind 0 where `kinds` is null.
template <class Run>
void for_stretches(const UniformRuns::Kind* kinds, std::int64_t columns, const Run& run) {
  if (kinds == nullptr) return run(std::int64_t{0}, columns, UniformRuns::Kind{0});
  const std::int64_t groups = (columns + kVector - 1) / kVector;
  for (std::int64_t g = 0, end = 0; g < groups; g = end) {
    for (end = g + 1; end < groups && kinds[end] == kinds[g];) ++end;
    run(g * kVector, std::min(end * kVector, columns), kinds[g]);
  }
}

}  // namespace mtf::taps
