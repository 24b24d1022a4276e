// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/kernels.h"

#include <algorithm>

#include "mtf/engines/clones.h"

namespace mtf::kernels {

MTFKIT_CLONES RowSummary summarise_row(const float* in, std::int64_t n) {
  constexpr int kStep = 16;
  using Loose = float __attribute__((vector_size(64), aligned(4), may_alias));
  using Sums = double __attribute__((vector_size(128)));
  RowSummary result{0.0, in[0], in[0]};
  std::int64_t i = 0;
  if (n >= kStep) {
    Loose low = *reinterpret_cast<const Loose*>(in), high = low;
    Sums sums{};
    for (; i + kStep <= n; i += kStep) {
      const Loose v = *reinterpret_cast<const Loose*>(in + i);
      low = v < low ? v : low;
      high = v > high ? v : high;
      sums += __builtin_convertvector(v, Sums);
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
