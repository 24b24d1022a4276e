// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the two engines of taps.h share: the rows of scene samples that a tile of the output needs, and weighted sums of
// rows.

#include <algorithm>
#include <cstdint>
#include <span>

#include "mtf/engines/taps.h"

namespace mtf::taps {

inline constexpr std::int64_t kTileColumns = 256;
inline constexpr std::int64_t kVector = 16;  ///< floats; rows are computed in whole vectors

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

/// The samples of canvas row `y` (any sign) that outputs x0 .. x0 + columns - 1 need, about the channel's mean and
/// scaled, sample i at out[(i % ratio) * phase_stride + i / ratio].
void load_row(const Channel& channel, const TapAxis& x, const TapAxis& y_axis, Border border, std::int64_t y,
              std::int64_t x0, std::int64_t columns, float* scratch, float* out);

/// Parts of a row of the canvas: positions 0 .. left - 1 and right .. n - 1 lie outside of the image.
struct RowParts {
  std::int64_t begin = 0, n = 0, left = 0, right = 0;
  const float* row = nullptr;  ///< of the image; null where the constant level stands
};

/// Of canvas row `y`, what outputs x0 .. x0 + columns - 1 need.
RowParts row_parts(const Channel& channel, const TapAxis& x, const TapAxis& y_axis, Border border, std::int64_t y,
                   std::int64_t x0, std::int64_t columns);
/// The sample at position `i` of parts outside of the image.
float outside(const RowParts& p, const Channel& channel, const TapAxis& x, Border border, std::int64_t i);

/// Floats of the scratch row of load_row.
inline std::int64_t scratch_size(const TapAxis& x) {
  return std::min(kTileColumns, x.outputs) * x.ratio + x.count + x.ratio + kVector;
}

/// Outputs that are made together.
struct TileArea {
  std::int64_t x0 = 0, y0 = 0, columns = 0, rows = 0;
};

/// Taps that equal themselves backwards, bit by bit.
bool mirrored(std::span<const float> taps);

}  // namespace mtf::taps
