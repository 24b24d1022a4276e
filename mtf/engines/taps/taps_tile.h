// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the two engines of taps.h share: rows of scene samples that a tile of the output needs, weighted sums of rows.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "mtf/engines/taps/taps.h"

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

/// Taps that equal themselves backwards, bit by bit.
bool mirrored(std::span<const float> taps);

}  // namespace mtf::taps
