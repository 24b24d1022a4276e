// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/taps_tile.h"

#include "mtf/engines/clones.h"
#include "mtf/engines/kernels.h"
#include "mtf/parallel.h"

namespace mtf::taps {
namespace {

using Wide = float __attribute__((vector_size(kVector * sizeof(float)), aligned(4), may_alias));

#define MTFKIT_INLINE inline __attribute__((always_inline))

MTFKIT_INLINE const Wide& wide(const float* p) { return *reinterpret_cast<const Wide*>(p); }
MTFKIT_INLINE Wide& wide(float* p) { return *reinterpret_cast<Wide*>(p); }

}  // namespace

// Four vectors at a time hide the latency of the additions.
MTFKIT_CLONES void weighted_sum(const float* const* a, const float* weights, std::int64_t count, std::int64_t n,
                                float* out) {
  std::int64_t i = 0;
  for (; i + 4 * kVector <= n; i += 4 * kVector) {
    Wide s0{}, s1{}, s2{}, s3{};
    for (std::int64_t c = 0; c < count; ++c) {
      const float* p = a[c] + i;
      const float w = weights[c];
      s0 += w * wide(p);
      s1 += w * wide(p + kVector);
      s2 += w * wide(p + 2 * kVector);
      s3 += w * wide(p + 3 * kVector);
    }
    wide(out + i) = s0;
    wide(out + i + kVector) = s1;
    wide(out + i + 2 * kVector) = s2;
    wide(out + i + 3 * kVector) = s3;
  }
  for (; i < n; i += kVector) {
    Wide s{};
    for (std::int64_t c = 0; c < count; ++c) s += weights[c] * wide(a[c] + i);
    wide(out + i) = s;
  }
}

MTFKIT_CLONES void weighted_pairs(const float* const* a, const float* const* b, const float* weights,
                                  std::int64_t count, std::int64_t n, float* out) {
  std::int64_t i = 0;
  for (; i + 4 * kVector <= n; i += 4 * kVector) {
    Wide s0{}, s1{}, s2{}, s3{};
    for (std::int64_t c = 0; c < count; ++c) {
      const float *p = a[c] + i, *q = b[c] + i;
      const float w = weights[c];
      s0 += w * (wide(p) + wide(q));
      s1 += w * (wide(p + kVector) + wide(q + kVector));
      s2 += w * (wide(p + 2 * kVector) + wide(q + 2 * kVector));
      s3 += w * (wide(p + 3 * kVector) + wide(q + 3 * kVector));
    }
    wide(out + i) = s0;
    wide(out + i + kVector) = s1;
    wide(out + i + 2 * kVector) = s2;
    wide(out + i + 3 * kVector) = s3;
  }
  for (; i < n; i += kVector) {
    Wide s{};
    for (std::int64_t c = 0; c < count; ++c) s += weights[c] * (wide(a[c] + i) + wide(b[c] + i));
    wide(out + i) = s;
  }
}

MTFKIT_CLONES void add_rows(const float* a, const float* b, std::int64_t n, float* out) {
  for (std::int64_t i = 0; i < n; ++i) out[i] = a[i] + b[i];
}

namespace {

MTFKIT_CLONES void deinterleave(const float* __restrict in, std::int64_t ratio, std::int64_t stride, std::int64_t n,
                                float* __restrict out) {
  if (ratio == 2) {
    for (std::int64_t i = 0; i < n; ++i) out[i] = in[2 * i], out[stride + i] = in[2 * i + 1];
    return;
  }
  if (ratio == 4) {
    for (std::int64_t i = 0; i < n; ++i) {
      out[i] = in[4 * i], out[stride + i] = in[4 * i + 1];
      out[2 * stride + i] = in[4 * i + 2], out[3 * stride + i] = in[4 * i + 3];
    }
    return;
  }
  for (std::int64_t p = 0; p < ratio; ++p)
    for (std::int64_t i = 0; i < n; ++i) out[p * stride + i] = in[i * ratio + p];
}

// Without a way out inside of the loop: a row of a tile is short, and whole vectors are compared.
MTFKIT_CLONES bool all_equal(const float* p, std::int64_t n, float level) {
  int different = 0;
  for (std::int64_t i = 0; i < n; ++i) different |= p[i] != level ? 1 : 0;
  return different == 0;
}

// Parts of a row of the canvas: positions 0 .. left - 1 and right .. n - 1 lie outside of the image.
struct RowParts {
  std::int64_t begin = 0, n = 0, left = 0, right = 0;
  const float* row = nullptr;  ///< of the image; null where the constant level stands
};

RowParts row_parts(const Channel& channel, const TapAxis& x, const TapAxis& y_axis, Border border, std::int64_t y,
                   std::int64_t x0, std::int64_t columns) {
  RowParts p;
  p.begin = x0 * x.ratio + x.first;
  p.n = (columns - 1) * x.ratio + x.count;
  const std::int64_t source = border_source(border, y, y_axis.samples);
  if (source >= 0) p.row = channel.in.row(source);
  p.left = source < 0 ? p.n : std::clamp<std::int64_t>(-p.begin, 0, p.n);
  p.right = source < 0 ? p.n : std::clamp<std::int64_t>(x.samples - p.begin, p.left, p.n);
  return p;
}

float outside(const RowParts& p, const Channel& channel, const TapAxis& x, Border border, std::int64_t i) {
  const std::int64_t sx = p.row == nullptr ? -1 : border_source(border, p.begin + i, x.samples);
  return sx < 0 ? static_cast<float>(channel.border_value) : p.row[sx];
}

}  // namespace

void load_row(const Channel& channel, const TapAxis& x, const TapAxis& y_axis, Border border, std::int64_t y,
              std::int64_t x0, std::int64_t columns, float* scratch, float* out) {
  const RowParts p = row_parts(channel, x, y_axis, border, y, x0, columns);
  float* centred = x.ratio == 1 ? out : scratch;
  const auto single = [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t i = from; i < to; ++i)
      centred[i] = static_cast<float>((outside(p, channel, x, border, i) - channel.mean) * channel.scale);
  };
  single(0, p.left);
  if (p.right > p.left)
    kernels::center(p.row + p.begin + p.left, p.right - p.left, channel.mean, channel.scale, centred + p.left);
  single(p.right, p.n);
  if (x.ratio == 1) return;
  const std::int64_t phases = (p.n + x.ratio - 1) / x.ratio;
  std::fill(scratch + p.n, scratch + phases * x.ratio, 0.0F);
  deinterleave(scratch, x.ratio, phase_stride(x), phases, out);
}

std::optional<float> flat_level(const Channel& channel, const TapAxis& x, const TapAxis& y, Border border,
                                std::int64_t x0, std::int64_t y0, std::int64_t columns, std::int64_t rows) {
  std::optional<float> level;
  const auto same = [&level](float v) { return v == level.value_or(v) && (level = v, true); };
  const std::int64_t first = y0 * y.ratio + y.first, needed = (rows - 1) * y.ratio + y.count;
  for (std::int64_t r = 0; r < needed; ++r) {
    const RowParts p = row_parts(channel, x, y, border, first + r, x0, columns);
    for (std::int64_t i = 0; i < p.left; ++i)
      if (!same(outside(p, channel, x, border, i))) return std::nullopt;
    if (p.right > p.left) {
      const float* inside = p.row + p.begin + p.left;
      if (!same(*inside) || !all_equal(inside, p.right - p.left, *inside)) return std::nullopt;
    }
    for (std::int64_t i = p.right; i < p.n; ++i)
      if (!same(outside(p, channel, x, border, i))) return std::nullopt;
  }
  return level;
}

void for_each_tile(const std::vector<Channel>& channels, const TapAxis& x, const TapAxis& y, std::int64_t rows,
                   int threads, const std::function<void(const Channel&, std::int64_t, std::int64_t)>& tile) {
  const std::int64_t across = (x.outputs + kTileColumns - 1) / kTileColumns, down = (y.outputs + rows - 1) / rows;
  const auto count = static_cast<std::int64_t>(channels.size());
  parallel_for(count * across * down, 1, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i)
      tile(channels[static_cast<std::size_t>(i / (across * down))], i % across * kTileColumns,
           i / across % down * rows);
  });
}

void fill_tile(const Channel& channel, std::int64_t x0, std::int64_t y0, std::int64_t columns, std::int64_t rows,
               float value) {
  for (std::int64_t y = y0; y < y0 + rows; ++y) std::fill_n(channel.out.row(y) + x0, columns, value);
}

bool mirrored(std::span<const float> taps) { return std::equal(taps.begin(), taps.end(), taps.rbegin()); }

}  // namespace mtf::taps
