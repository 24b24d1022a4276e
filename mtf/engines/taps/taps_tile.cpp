// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/taps/taps_tile.h"

#include "mtf/engines/kernels.h"
#include "mtf/math/clones.h"

namespace mtf::taps {
namespace {

using Wide = float __attribute__((vector_size(kVector * sizeof(float)), aligned(4), may_alias));

#define MTFKIT_INLINE inline __attribute__((always_inline))

MTFKIT_INLINE const Wide& wide(const float* p) { return *reinterpret_cast<const Wide*>(p); }
MTFKIT_INLINE Wide& wide(float* p) { return *reinterpret_cast<Wide*>(p); }

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

TileRows::TileRows(const Channel& channel, const TapAxis& x, const TapAxis& y, Border border, const TileArea& area)
    : channel_(channel),
      x_(x),
      y_(y),
      border_(border),
      first_row_(y.first + area.y0 * y.ratio),
      begin_(x.first + area.x0 * x.ratio),
      n_((area.columns - 1) * x.ratio + x.count),
      left_(std::clamp<std::int64_t>(-begin_, 0, n_)),
      right_(std::clamp<std::int64_t>(x.samples - begin_, left_, n_)) {
  for (std::int64_t i = 0; i < n_; ++i)
    if (i < left_ || i >= right_) outside_.push_back(border_source(border, begin_ + i, x.samples));
}

const float* TileRows::row(std::int64_t r) const {
  const std::int64_t source = border_source(border_, first_row_ + r, y_.samples);
  return source < 0 ? nullptr : channel_.in.row(source);
}

void TileRows::load(std::int64_t r, float* scratch, float* out) const {
  const float* samples = row(r);
  const std::int64_t inside = right_ - left_;
  if (const float* soon = row(r + 2); soon != nullptr) kernels::prefetch(soon + begin_ + left_, inside);
  float* centred = x_.ratio == 1 ? out : scratch;
  const auto value = [&](double v) { return static_cast<float>((v - channel_.mean) * channel_.scale); };
  if (samples == nullptr) {
    std::fill_n(centred, n_, value(channel_.border_value));
  } else {
    kernels::center(samples + begin_ + left_, inside, channel_.mean, channel_.scale, centred + left_);
    for (std::size_t k = 0; k < outside_.size(); ++k) {
      const auto i = static_cast<std::int64_t>(k);
      centred[i < left_ ? i : i + inside] = value(outside_[k] < 0 ? channel_.border_value : samples[outside_[k]]);
    }
  }
  if (x_.ratio == 1) return;
  const std::int64_t phases = (n_ + x_.ratio - 1) / x_.ratio;
  std::fill(scratch + n_, scratch + phases * x_.ratio, 0.0F);
  deinterleave(scratch, x_.ratio, phase_stride(x_), phases, out);
}

bool mirrored(std::span<const float> taps) { return std::equal(taps.begin(), taps.end(), taps.rbegin()); }

}  // namespace mtf::taps
