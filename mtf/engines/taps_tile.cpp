// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/taps_tile.h"

#include "mtf/engines/clones.h"
#include "mtf/engines/kernels.h"

namespace mtf::taps {
namespace {

using Wide = float __attribute__((vector_size(kVector * sizeof(float)), aligned(4), may_alias));

#define MTFKIT_INLINE inline __attribute__((always_inline))

MTFKIT_INLINE const Wide& wide(const float* p) { return *reinterpret_cast<const Wide*>(p); }
MTFKIT_INLINE Wide& wide(float* p) { return *reinterpret_cast<Wide*>(p); }

}  // namespace

// Four vectors at a time, or two, hide the latency of the additions.
MTFKIT_CLONES void weighted_sum(const float* const* a, const float* weights, std::int64_t count, std::int64_t first,
                                std::int64_t last, float* out) {
  std::int64_t i = first;
  for (; i + 4 * kVector <= last; i += 4 * kVector) {
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
  for (; i + 2 * kVector <= last; i += 2 * kVector) {
    Wide s0{}, s1{};
    for (std::int64_t c = 0; c < count; ++c) {
      const float* p = a[c] + i;
      s0 += weights[c] * wide(p);
      s1 += weights[c] * wide(p + kVector);
    }
    wide(out + i) = s0;
    wide(out + i + kVector) = s1;
  }
  for (; i < last; i += kVector) {
    Wide s{};
    for (std::int64_t c = 0; c < count; ++c) s += weights[c] * wide(a[c] + i);
    wide(out + i) = s;
  }
}

MTFKIT_CLONES void weighted_pairs(const float* const* a, const float* const* b, const float* weights,
                                  std::int64_t count, std::int64_t first, std::int64_t last, float* out) {
  std::int64_t i = first;
  for (; i + 4 * kVector <= last; i += 4 * kVector) {
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
  for (; i + 2 * kVector <= last; i += 2 * kVector) {
    Wide s0{}, s1{};
    for (std::int64_t c = 0; c < count; ++c) {
      const float *p = a[c] + i, *q = b[c] + i;
      s0 += weights[c] * (wide(p) + wide(q));
      s1 += weights[c] * (wide(p + kVector) + wide(q + kVector));
    }
    wide(out + i) = s0;
    wide(out + i + kVector) = s1;
  }
  for (; i < last; i += kVector) {
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

}  // namespace

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

bool mirrored(std::span<const float> taps) { return std::equal(taps.begin(), taps.end(), taps.rbegin()); }

}  // namespace mtf::taps
