// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the two engines of taps.h share: the rows of scene samples that a tile of the output needs, and weighted sums of
// rows.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
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

/// out[i] (+)= sum over c of weights[c] x a[c][i], i < n rounded up to whole vectors.
void weighted_sum(const float* const* a, const float* weights, std::int64_t count, std::int64_t n, float* out);
/// out[i] = sum over c of weights[c] x (a[c][i] + b[c][i]).
void weighted_pairs(const float* const* a, const float* const* b, const float* weights, std::int64_t count,
                    std::int64_t n, float* out);
/// out[i] = a[i] + b[i].
void add_rows(const float* a, const float* b, std::int64_t n, float* out);

/// The samples of canvas row `y` (any sign) that outputs x0 .. x0 + columns - 1 need, about the channel's mean and
/// scaled, sample i at out[(i % ratio) * phase_stride + i / ratio].
void load_row(const Channel& channel, const TapAxis& x, const TapAxis& y_axis, Border border, std::int64_t y,
              std::int64_t x0, std::int64_t columns, float* scratch, float* out);

/// The one value of all samples that a tile of the output needs; nothing when they differ.
std::optional<float> flat_level(const Channel& channel, const TapAxis& x, const TapAxis& y, Border border,
                                std::int64_t x0, std::int64_t y0, std::int64_t columns, std::int64_t rows);

/// Floats of the scratch row of load_row.
inline std::int64_t scratch_size(const TapAxis& x) {
  return std::min(kTileColumns, x.outputs) * x.ratio + x.count + x.ratio + kVector;
}

/// tile(channel, x0, y0) over all tiles of `rows` output rows of all channels, on `threads` threads.
void for_each_tile(const std::vector<Channel>& channels, const TapAxis& x, const TapAxis& y, std::int64_t rows,
                   int threads, const std::function<void(const Channel&, std::int64_t, std::int64_t)>& tile);

/// The tile at (x0, y0) of `columns` x `rows` outputs, all `value`.
void fill_tile(const Channel& channel, std::int64_t x0, std::int64_t y0, std::int64_t columns, std::int64_t rows,
               float value);

/// Taps that equal themselves backwards, bit by bit.
bool mirrored(std::span<const float> taps);

}  // namespace mtf::taps
