// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the engines of taps.h need not work out. Outputs of a row come in groups of kVector; a group whose samples, with
// all that the taps reach around them, are of one level is H(0) x level.

#include <functional>
#include <vector>

#include "mtf/engines/taps/taps_tile.h"
#include "mtf/survey/uniform_runs.h"

namespace mtf::taps {

class TapsFlat {
 public:
  using Kind = UniformRuns::Kind;
  static_assert(UniformRuns::kGroup == kVector && kTileColumns % kVector == 0);

  TapsFlat(const Channel& channel, const TapAxis& x, const TapAxis& y, Border border);

  /// The level behind a kind that is not 0.
  float level(Kind kind) const { return map_->level(kind); }
  /// Kinds of the groups of a row of outputs from column x0 on; null where all are to be worked out.
  const Kind* output(std::int64_t y, std::int64_t x0) const { return at(outputs_, y, x0); }
  /// The same by what the taps along x see in the samples of canvas row y.first + r.
  const Kind* samples(std::int64_t r, std::int64_t x0) const { return at(rows_, r, x0); }
  /// Writes H(0) x level to the outputs of row `y` that are flat.
  void fill_row(const Channel& channel, std::int64_t y) const;
  /// The least part of a tile, of whole groups, that holds the others; no rows where there are none.
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

/// Fills what is flat by H(0) x level, then tile(channel, flat, area) over all tiles of `rows` output rows of all
/// channels, on `threads` threads.
void for_each_tile(const std::vector<Channel>& channels, const TapAxis& x, const TapAxis& y, Border border,
                   std::int64_t rows, int threads,
                   const std::function<void(const Channel&, const TapsFlat&, const TileArea&)>& tile);

/// run(begin, end, kind) over the columns of each stretch of groups of one kind, in order, up to `columns`; all of kind
/// 0 where `kinds` is null.
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
