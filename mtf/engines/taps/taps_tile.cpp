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

// Sums of vectors, four at once where there are so many: `add(c, i, sum)` adds what row c has from i on.
template <class Add>
MTFKIT_INLINE void add_weighted(std::int64_t count, std::int64_t first, std::int64_t last, float* out, const Add& add) {
  const auto sums = [&]<int N>(std::int64_t i) __attribute__((always_inline)) {
    Wide sum[N]{};
    for (std::int64_t c = 0; c < count; ++c)
#pragma GCC unroll 4
      for (int k = 0; k < N; ++k) add(c, i + k * kVector, sum[k]);
#pragma GCC unroll 4
    for (int k = 0; k < N; ++k) wide(out + i + k * kVector) = sum[k];
  };
  std::int64_t i = first;
  for (; i + 4 * kVector <= last; i += 4 * kVector) sums.template operator()<4>(i);
  for (; i + 2 * kVector <= last; i += 2 * kVector) sums.template operator()<2>(i);
  for (; i < last; i += kVector) sums.template operator()<1>(i);
}

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
  add_weighted(
      count, first, last, out, [=](std::int64_t c, std::int64_t i, Wide & sum) __attribute__((always_inline)) {
        sum += weights[c] * wide(a[c] + i);
      });
}

MTFKIT_CLONES void weighted_pairs(const float* const* a, const float* const* b, const float* weights,
                                  std::int64_t count, std::int64_t first, std::int64_t last, float* out) {
  add_weighted(
      count, first, last, out, [=](std::int64_t c, std::int64_t i, Wide & sum) __attribute__((always_inline)) {
        sum += weights[c] * (wide(a[c] + i) + wide(b[c] + i));
      });
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
