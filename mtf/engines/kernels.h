// SPDX-License-Identifier: Apache-2.0
#pragma once

// Hot loops on plain arrays, compiled for several instruction sets in one binary (run-time dispatch).

#include <cstdint>

namespace mtf::kernels {

/// out[i] *= linear interpolation of `knots` at min(sqrt(x2[i] + y2) x per_unit, intervals); intervals + 2 knots.
void multiply_by_table(const float* knots, float intervals, float per_unit, const float* x2, float y2, std::int64_t n,
                       float* out);

/// out[i] *= linear interpolation of `knots` at min(|x[i] + y| x intervals, intervals); intervals + 2 knots.
void multiply_by_line_table(const float* knots, float intervals, const float* x, float y, std::int64_t n, float* out);

struct RowSummary {
  double sum = 0.0;
  float min = 0.0F, max = 0.0F;
};

/// Sum in a fixed order (the same on every machine), extremes; a NaN or infinity shows in the sum.
RowSummary summarise_row(const float* in, std::int64_t n);

}  // namespace mtf::kernels
