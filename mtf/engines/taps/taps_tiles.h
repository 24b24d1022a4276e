// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the two engines of taps.h share: rows of scene samples that a tile of the output needs, weighted sums of rows,
// and the outputs that need not be computed. Outputs of a row come in groups of kVector. Where all samples that the
// taps read for a group have one value, the group is uniform: H(0) times that value.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "mtf/engines/taps/taps.h"
#include "mtf/engines/uniform_runs.h"

namespace mtf::taps {

inline constexpr std::int64_t kTileColumns = 320;  ///< at most
inline constexpr std::int64_t kVector = 16;        ///< floats; rows are computed in whole vectors

inline std::int64_t whole_vectors(std::int64_t n) { return (n + kVector - 1) / kVector * kVector; }

/// Floats from one phase of a tile's row to the next: outputs, taps, and room to read whole vectors.
inline std::int64_t phase_stride(const TapAxis& x) {
  return whole_vectors(std::min(kTileColumns, x.outputs) + x.count / x.ratio + 1) + kVector;
}

/// out[i] = sum over c of weights[c] x a[c][i], first <= i < last, whole vectors.
void weighted_sum(const float* const* a, const float* weights, std::int64_t count, std::int64_t first,
                  std::int64_t last, float* out);
/// out[i] = sum over c of weights[c] x (a[c][i] + b[c][i]).
void weighted_pairs(const float* const* a, const float* const* b, const float* weights, std::int64_t count,
                    std::int64_t first, std::int64_t last, float* out);
/// out[i] = a[i] + b[i].
void add_rows(const float* a, const float* b, std::int64_t n, float* out);

/// Outputs that are computed together.
struct TileArea {
  std::int64_t x0 = 0, y0 = 0, columns = 0, rows = 0;
};

/// Floats of the scratch row of TileRows.
inline std::int64_t scratch_size(const TapAxis& x) {
  return std::min(kTileColumns, x.outputs) * x.ratio + x.count + x.ratio + kVector;
}

/// The samples that a tile of outputs needs: canvas rows y.first + area.y0 x ratio + r, r = 0 ..
class TileRows {
 public:
  TileRows(const Channel& channel, const TapAxis& x, const TapAxis& y, Border border, const TileArea& area);
  /// Row r about the channel's mean and scaled, sample i at out[(i % ratio) * phase_stride + i / ratio].
  void load(std::int64_t r, float* scratch, float* out) const;

 private:
  const float* row(std::int64_t r) const;

  const Channel& channel_;
  const TapAxis &x_, &y_;
  Border border_;
  std::int64_t first_row_;             ///< of the canvas
  std::int64_t begin_, n_;             ///< samples of a row
  std::int64_t left_, right_;          ///< of them, left .. right - 1 lie in the image
  std::vector<std::int64_t> outside_;  ///< where the others come from, in order; -1: the value of a constant border
};

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
