// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/kernels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

#include "mtf/math/clones.h"
#include "mtf/math/simd.h"

namespace mtf::kernels {

MTFKIT_CLONES void cosine_from_half(const float* __restrict half, const float* __restrict twiddles, std::int64_t n,
                                    float* __restrict coefficients) {
  coefficients[0] = half[0];
  const int count = static_cast<int>(n / 2), last = static_cast<int>(n);
  for (int k = 1; k <= count; ++k) {
    const float c = twiddles[2 * k], s = twiddles[2 * k + 1], re = half[2 * k], im = half[2 * k + 1];
    coefficients[k] = re * c - im * s;
    coefficients[last - k] = -(re * s + im * c);
  }
}

MTFKIT_CLONES void center_ordered(const float* __restrict in, std::int64_t n, double mean, double scale,
                                  float* __restrict out) {
  const int pairs = static_cast<int>(n / 2), last = static_cast<int>(n - 1);
  for (int i = 0; i < pairs; ++i) {
    out[i] = static_cast<float>((in[2 * i] - mean) * scale);
    out[last - i] = static_cast<float>((in[2 * i + 1] - mean) * scale);
  }
  if (n % 2 == 1) out[pairs] = static_cast<float>((in[last] - mean) * scale);
}

MTFKIT_CLONES void standardise(const float* __restrict in, std::int64_t n, double mean, double scale,
                               float* __restrict out) {
  for (std::int64_t i = 0; i < n; ++i) out[i] = static_cast<float>((in[i] - mean) * scale);
}

MTFKIT_CLONES void center(const float* __restrict in, std::int64_t n, double mean, double scale,
                          float* __restrict out) {
  const float factor = static_cast<float>(scale), offset = static_cast<float>(mean * scale);
  for (std::int64_t i = 0; i < n; ++i) out[i] = in[i] * factor - offset;
}

MTFKIT_CLONES void center(const float* __restrict in, std::int64_t n, double mean, double scale,
                          double* __restrict out) {
  for (std::int64_t i = 0; i < n; ++i) out[i] = (in[i] - mean) * scale;
}

namespace {

// A change may lie beyond float where its sum with the mean does not.
bool near_the_end_of_float(double mean, double scale) { return !(std::abs(mean) < 0x1p120 && scale < 0x1p120); }

constexpr std::int64_t kSoon = 8;  // rows ahead that a walk down columns asks for

// One value at a time: `value` is inlined into loops over a whole row of kColumns, which become vectors.
template <class To, class Value>
MTFKIT_INLINE void fill_row(std::int64_t count, To* __restrict out, const Value& value) {
  if (count == kColumns)
    for (std::int64_t l = 0; l < kColumns; ++l) out[l] = value(l);
  else
    for (std::int64_t l = 0; l < count; ++l) out[l] = value(l);
}

// Each number of a lane is a sum of few: they are summed on in double.
template <class S>
MTFKIT_INLINE void add_moments(const S* __restrict in, std::int64_t n, MomentSums& to) {
  constexpr int kStep = MomentSums::kStep;
  constexpr std::int64_t kStretch = 512 * kStep;
  for (std::int64_t first = 0; first < n; first += kStretch) {
    const std::int64_t last = std::min(n, first + kStretch);
    std::array<S, kStep> sums{}, squares{};
    std::int64_t i = first;
    for (; i + kStep <= last; i += kStep)
      for (int j = 0; j < kStep; ++j) {
        sums[j] += in[i + j];
        squares[j] += in[i + j] * in[i + j];
      }
    for (int j = 0; i < last; ++i, ++j) {
      sums[j] += in[i];
      squares[j] += in[i] * in[i];
    }
    for (int j = 0; j < kStep; ++j) {
      to.sums[j] += sums[j];
      to.squares[j] += squares[j];
    }
  }
}

using simd::any_bit, simd::Bits, simd::bits, simd::kBits;

// Vectors of places, then single loads of the knots there, then vectors again: faster than a gather instruction, and
// than what GCC 12 makes of one loop.
template <class Place>
MTFKIT_INLINE void multiply_at(const Knot* __restrict knots, float intervals, std::int64_t n, float* __restrict out,
                               const Place& place) {
  constexpr int kTogether = 256;
  alignas(64) std::array<int, kTogether> index;
  alignas(64) std::array<float, kTogether> rest;
  alignas(64) std::array<Knot, kTogether> knot;
  for (std::int64_t first = 0; first < n; first += kTogether) {
    const int count = static_cast<int>(std::min<std::int64_t>(kTogether, n - first));
    for (int i = 0; i < count; ++i) {
      const float r = place(first + i) * intervals;
      const float t = r < intervals ? r : intervals;
      index[i] = static_cast<int>(t);
      rest[i] = t - static_cast<float>(index[i]);
    }
    for (int i = 0; i < count; ++i) knot[i] = knots[index[i]];
    for (int i = 0; i < count; ++i) out[first + i] *= knot[i][0] + rest[i] * knot[i][1];
  }
}

}  // namespace

MTFKIT_CLONES void add_weighted(const float* __restrict in, std::int64_t n, std::span<const Scaled> terms,
                                float* __restrict out) {
  constexpr std::int64_t kBlock = 64;  // weights that stay in registers
  std::int64_t first = 0;
  for (; first + kBlock <= n; first += kBlock) {
    float weight[kBlock] = {};
    for (const Scaled& term : terms) {
      const float* const values = term.values + first;
      for (std::int64_t i = 0; i < kBlock; ++i) weight[i] += term.factor * values[i];
    }
    for (std::int64_t i = 0; i < kBlock; ++i) out[first + i] += weight[i] * in[first + i];
  }
  for (; first < n; ++first) {
    float weight = 0.0F;
    for (const Scaled& term : terms) weight += term.factor * term.values[first];
    out[first] += weight * in[first];
  }
}

MTFKIT_CLONES void restore(const float* __restrict in, std::int64_t n, double mean, double scale,
                           float* __restrict out) {
  if (near_the_end_of_float(mean, scale)) {
    for (std::int64_t i = 0; i < n; ++i) out[i] = static_cast<float>(in[i] * scale + mean);
    return;
  }
  const float factor = static_cast<float>(scale), high = static_cast<float>(mean),
              low = static_cast<float>(mean - high);
  for (std::int64_t i = 0; i < n; ++i) out[i] = (in[i] * factor + low) + high;
}

MTFKIT_CLONES void restore(const double* __restrict in, std::int64_t n, double mean, double scale,
                           float* __restrict out) {
  for (std::int64_t i = 0; i < n; ++i) out[i] = static_cast<float>(in[i] * scale + mean);
}

MTFKIT_CLONES void center_columns(const float* in, std::int64_t stride, std::int64_t rows, std::int64_t count,
                                  double mean, double scale, float* out) {
  const float factor = static_cast<float>(scale), offset = static_cast<float>(mean * scale);
  for (std::int64_t i = 0; i < rows; ++i, in += stride, out += kColumns) {
    if (i + kSoon < rows) prefetch(in + kSoon * stride, count);
    fill_row(count, out, [&](std::int64_t l) { return in[l] * factor - offset; });
    std::fill_n(out + count, kColumns - count, 0.0F);
  }
}

MTFKIT_CLONES void center_columns(const float* in, std::int64_t stride, std::int64_t rows, std::int64_t count,
                                  double mean, double scale, double* out) {
  for (std::int64_t i = 0; i < rows; ++i, in += stride, out += kColumns) {
    if (i + kSoon < rows) prefetch(in + kSoon * stride, count);
    fill_row(count, out, [&](std::int64_t l) { return (in[l] - mean) * scale; });
    std::fill_n(out + count, kColumns - count, 0.0);
  }
}

MTFKIT_CLONES void restore_columns(const float* in, std::span<const std::int32_t> order, std::int64_t count,
                                   double mean, double scale, std::int64_t stride, float* out) {
  const bool wide = near_the_end_of_float(mean, scale);
  const float factor = static_cast<float>(scale), high = static_cast<float>(mean),
              low = static_cast<float>(mean - high);
  for (const std::int32_t row : order) {
    const float* from = in + std::int64_t{row} * kColumns;
    if (wide)
      fill_row(count, out, [&](std::int64_t l) { return static_cast<float>(from[l] * scale + mean); });
    else
      fill_row(count, out, [&](std::int64_t l) { return (from[l] * factor + low) + high; });
    out += stride;
  }
}

MTFKIT_CLONES void restore_columns(const double* in, std::span<const std::int32_t> order, std::int64_t count,
                                   double mean, double scale, std::int64_t stride, float* out) {
  for (const std::int32_t row : order) {
    const double* from = in + std::int64_t{row} * kColumns;
    fill_row(count, out, [&](std::int64_t l) { return static_cast<float>(from[l] * scale + mean); });
    out += stride;
  }
}

MTFKIT_CLONES RowSummary summarise_row(const float* in, std::int64_t n) {
  constexpr int kStep = 16;
  RowSummary result{0.0, in[0], in[0]};
  std::int64_t i = 0;
  if (n >= kStep) {
    // Arrays of lanes: vectors wider than the machine's would stay in memory.
    std::array<float, kStep> low, high;
    std::array<double, kStep> sums{};
    std::copy_n(in, kStep, low.begin());
    std::copy_n(in, kStep, high.begin());
    for (; i + kStep <= n; i += kStep)
      for (int j = 0; j < kStep; ++j) {
        const float v = in[i + j];
        low[j] = v < low[j] ? v : low[j];
        high[j] = v > high[j] ? v : high[j];
        sums[j] += static_cast<double>(v);
      }
    for (int j = 0; j < kStep; ++j) {
      result.sum += sums[j];
      result.min = std::min(result.min, low[j]);
      result.max = std::max(result.max, high[j]);
    }
  }
  for (; i < n; ++i) {
    result.sum += in[i];
    result.min = std::min(result.min, in[i]);
    result.max = std::max(result.max, in[i]);
  }
  return result;
}

MTFKIT_CLONES double squares_about(const float* in, std::int64_t n, double about) {
  constexpr int kStep = 16;
  std::array<double, kStep> sums{};
  std::int64_t i = 0;
  for (; i + kStep <= n; i += kStep)
    for (int j = 0; j < kStep; ++j) {
      const double d = static_cast<double>(in[i + j]) - about;
      sums[j] += d * d;
    }
  for (; i < n; ++i) sums[0] += (static_cast<double>(in[i]) - about) * (static_cast<double>(in[i]) - about);
  double sum = 0.0;
  for (const double part : sums) sum += part;
  return sum;
}

MTFKIT_CLONES void add(const float* in, std::int64_t n, MomentSums& sums) { add_moments(in, n, sums); }
MTFKIT_CLONES void add(const double* in, std::int64_t n, MomentSums& sums) { add_moments(in, n, sums); }

Moments MomentSums::total() const {
  return {std::accumulate(sums.begin(), sums.end(), 0.0), std::accumulate(squares.begin(), squares.end(), 0.0)};
}

MTFKIT_CLONES bool all_alike(const float* in, std::int64_t n) {
  constexpr std::int64_t kTogether = 8;
  const Bits first = simd::bits_of(in[0]);
  std::int64_t i = 0;
  for (; i + kTogether * kBits <= n; i += kTogether * kBits) {
    prefetch(in + i + 2 * kTogether * kBits, kTogether * kBits);
    Bits differ{};
    for (std::int64_t j = 0; j < kTogether; ++j) differ |= bits(in + i + j * kBits) ^ first;
    if (any_bit(differ)) return false;
  }
  for (; i < n; ++i)
    if (std::bit_cast<std::uint32_t>(in[i]) != first[0]) return false;
  return true;
}

MTFKIT_CLONES bool same(const float* a, const float* b, std::int64_t n) {
  Bits differ{};
  std::int64_t i = 0;
  for (; i + kBits <= n; i += kBits) differ |= bits(a + i) ^ bits(b + i);
  return !any_bit(differ) && std::memcmp(a + i, b + i, static_cast<std::size_t>(n - i) * sizeof(float)) == 0;
}

MTFKIT_CLONES void multiply_by_table(const Knot* knots, float intervals, const float* __restrict x2, float y2,
                                     std::int64_t n, float* __restrict out) {
  multiply_at(knots, intervals, n, out, [=](std::int64_t i) { return __builtin_sqrtf(x2[i] + y2); });
}

MTFKIT_CLONES void multiply_by_line_table(const Knot* knots, float intervals, const float* __restrict x, float y,
                                          std::int64_t n, float* __restrict out) {
  multiply_at(knots, intervals, n, out, [=](std::int64_t i) { return __builtin_fabsf(x[i] + y); });
}

}  // namespace mtf::kernels
