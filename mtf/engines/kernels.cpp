// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/kernels.h"

#include <algorithm>
#include <cmath>
#include <cstring>

// One binary for any x86-64: the dynamic linker picks the version of the machine. Other architectures get the plain
// one.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(MTFKIT_NO_CLONES)
#define MTFKIT_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define MTFKIT_CLONES
#endif

namespace mtf::kernels {
namespace {

// One row of a block, kLanes complex numbers: the compiler cuts it into the registers that the machine has. Passed by
// reference only, because the calling convention of wide vectors differs between instruction sets.
using Row = float __attribute__((vector_size(kRowFloats * sizeof(float)), may_alias));
using Mask = std::int32_t __attribute__((vector_size(kRowFloats * sizeof(float))));

constexpr Mask kSwap{1, 0, 3, 2, 5, 4, 7, 6, 9, 8, 11, 10, 13, 12, 15, 14};
constexpr Mask kReal{0, 0, 2, 2, 4, 4, 6, 6, 8, 8, 10, 10, 12, 12, 14, 14};
constexpr Mask kImaginary{1, 1, 3, 3, 5, 5, 7, 7, 9, 9, 11, 11, 13, 13, 15, 15};
constexpr Row kSigns{-1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1};

#define MTFKIT_INLINE inline __attribute__((always_inline))

MTFKIT_INLINE Row& row_at(float* p, std::int64_t r) { return *reinterpret_cast<Row*>(p + r * kRowFloats); }
MTFKIT_INLINE const Row& row_at(const float* p, std::int64_t r) {
  return *reinterpret_cast<const Row*>(p + r * kRowFloats);
}

// out = v x (c + i s), lane by lane.
MTFKIT_INLINE void rotate(const Row& v, float c, float s, Row& out) {
  out = v * c + __builtin_shuffle(v, kSwap) * (kSigns * s);
}

// v *= h: complex lanes, or plain factors.
MTFKIT_INLINE void apply_otf(Row& v, const Row& h, bool complex_otf) {
  if (complex_otf)
    v = v * __builtin_shuffle(h, kReal) + __builtin_shuffle(v, kSwap) * (kSigns * __builtin_shuffle(h, kImaginary));
  else
    v = v * h;
}

MTFKIT_INLINE void accumulate(const Row& v, const Term& term, Row& out) {
  if (term.im == 0.0F) {
    out += v * term.re;
  } else {
    Row turned;
    rotate(v, term.re, term.im, turned);
    out += turned;
  }
}

}  // namespace

MTFKIT_CLONES void multiply_rows(float* data, const float* factors, std::int64_t rows, int lanes) {
  for (std::int64_t r = 0; r < rows; ++r) {
    const float c = factors[2 * r], s = factors[2 * r + 1];
    float* row = data + 2 * r * lanes;
    for (int l = 0; l < lanes; ++l) {
      const float re = row[2 * l], im = row[2 * l + 1];
      row[2 * l] = re * c - im * s;
      row[2 * l + 1] = re * s + im * c;
    }
  }
}

MTFKIT_CLONES void spread_fourier(const float* source, const float* otf, bool complex_otf, std::span<const Term> terms,
                                  float* target, std::int64_t target_rows) {
  std::memset(target, 0, static_cast<std::size_t>(target_rows) * kRowFloats * sizeof(float));
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const Term& term = terms[i];
    Row v = row_at(source, term.source);
    apply_otf(v, row_at(otf, static_cast<std::int64_t>(i)), complex_otf);
    accumulate(v, term, row_at(target, term.target));
  }
}

MTFKIT_CLONES void spread_cosine(const float* source, const float* otf, bool complex_otf, std::span<const Term> terms,
                                 const float* twiddles, std::int64_t n, float* target, std::int64_t target_rows) {
  std::memset(target, 0, static_cast<std::size_t>(target_rows) * kRowFloats * sizeof(float));
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const Term& term = terms[i];
    const std::int64_t k = term.source;
    const Row& up = row_at(source, k);
    const Row& down = row_at(source, k == 0 ? 0 : n - k);
    // (t u + conj(t) d) / 2 = Re(t) (u + d) / 2 + i Im(t) (u - d) / 2
    const Row difference = up - down;
    Row v = (up + down) * (0.5F * twiddles[2 * k]) +
            __builtin_shuffle(difference, kSwap) * (kSigns * (0.5F * twiddles[2 * k + 1]));
    apply_otf(v, row_at(otf, static_cast<std::int64_t>(i)), complex_otf);
    accumulate(v, term, row_at(target, term.target));
  }
}

MTFKIT_CLONES void unfold_cosine(const float* coefficients, const float* twiddles, std::int64_t n, float* out) {
  row_at(out, 0) = row_at(coefficients, 0);
  for (std::int64_t k = 1; k < n; ++k) {
    // Y_k - i Y_{n-k}, then times conj(t_k)
    const Row v = row_at(coefficients, k) - __builtin_shuffle(row_at(coefficients, n - k), kSwap) * kSigns;
    rotate(v, twiddles[2 * k], -twiddles[2 * k + 1], row_at(out, k));
  }
}

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

MTFKIT_CLONES void half_from_cosine(const float* __restrict coefficients, const float* __restrict twiddles,
                                    std::int64_t n, float* __restrict half) {
  half[0] = coefficients[0];
  half[1] = 0.0F;
  const int count = static_cast<int>(n / 2), last = static_cast<int>(n);
  for (int k = 1; k <= count; ++k) {
    const float c = twiddles[2 * k], s = -twiddles[2 * k + 1], a = coefficients[k], b = coefficients[last - k];
    half[2 * k] = a * c + b * s;
    half[2 * k + 1] = a * s - b * c;
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

MTFKIT_CLONES void center(const float* in, std::int64_t n, double mean, double scale, float* out) {
  for (std::int64_t i = 0; i < n; ++i) out[i] = static_cast<float>((in[i] - mean) * scale);
}

MTFKIT_CLONES void restore(const float* in, std::int64_t n, double mean, double scale, float* out) {
  for (std::int64_t i = 0; i < n; ++i) out[i] = static_cast<float>(in[i] * scale + mean);
}

MTFKIT_CLONES void restore_ordered(const float* __restrict in, std::int64_t n, std::int64_t count, double mean,
                                   double scale, float* __restrict out) {
  const int pairs = static_cast<int>(count / 2), last = static_cast<int>(n - 1);
  for (int i = 0; i < pairs; ++i) {
    out[2 * i] = static_cast<float>(in[i] * scale + mean);
    out[2 * i + 1] = static_cast<float>(in[last - i] * scale + mean);
  }
  if (count % 2 == 1) out[count - 1] = static_cast<float>(in[pairs] * scale + mean);
}

MTFKIT_CLONES RowSummary summarise_row(const float* in, std::int64_t n) {
  using Loose = float __attribute__((vector_size(64), aligned(4), may_alias));
  using Sums = double __attribute__((vector_size(128)));
  RowSummary result{0.0, in[0], in[0]};
  std::int64_t i = 0;
  if (n >= kRowFloats) {
    Loose low = *reinterpret_cast<const Loose*>(in), high = low;
    Sums sums{};
    for (; i + kRowFloats <= n; i += kRowFloats) {
      const Loose v = *reinterpret_cast<const Loose*>(in + i);
      low = v < low ? v : low;
      high = v > high ? v : high;
      sums += __builtin_convertvector(v, Sums);
    }
    for (int j = 0; j < kRowFloats; ++j) {
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

// Plain int, restrict and the float builtin: with anything else GCC 12 does not turn this into gathers.
MTFKIT_CLONES void multiply_by_table(const float* __restrict knots, float intervals, float per_unit,
                                     const float* __restrict x2, float y2, std::int64_t n, float* __restrict out) {
  const int count = static_cast<int>(n);
  for (int i = 0; i < count; ++i) {
    const float r = __builtin_sqrtf(x2[i] + y2) * per_unit;
    const float t = r < intervals ? r : intervals;
    const int knot = static_cast<int>(t);
    const float a = knots[knot], b = knots[knot + 1];
    out[i] *= a + (t - static_cast<float>(knot)) * (b - a);
  }
}

MTFKIT_CLONES void multiply_by_line_table(const float* __restrict knots, float intervals, const float* __restrict x,
                                          float y, std::int64_t n, float* __restrict out) {
  const int count = static_cast<int>(n);
  for (int i = 0; i < count; ++i) {
    const float r = __builtin_fabsf(x[i] + y) * intervals;
    const float t = r < intervals ? r : intervals;
    const int knot = static_cast<int>(t);
    const float a = knots[knot], b = knots[knot + 1];
    out[i] *= a + (t - static_cast<float>(knot)) * (b - a);
  }
}

}  // namespace mtf::kernels
