// SPDX-License-Identifier: Apache-2.0
#pragma once

// The hot loops of the spectral engine, compiled for several instruction sets in one binary (run-time dispatch).
// A block is `rows` rows of kLanes complex numbers (interleaved re, im): one cache line a row.

#include <cstdint>
#include <span>

#include "mtf/engines/axis.h"

namespace mtf {

namespace kernels {

/// row r *= factors[r] (complex) for `rows` rows of `lanes` lanes.
void multiply_rows(float* data, const float* factors, std::int64_t rows, int lanes);

/// target[term.target] += term.factor x otf[i] x source[term.source] over the terms i. `complex_otf`: otf rows hold
/// kLanes complex numbers, else kRowFloats real factors of the floats of the row. Target rows are zeroed first.
void spread_fourier(const float* source, const float* otf, bool complex_otf, std::span<const Term> terms, float* target,
                    std::int64_t target_rows);

/// The same for the cosine basis: the coefficient of k is (t_k V_k + conj(t_k) V_{n-k}) / 2, t_k = exp(-i pi k / 2n),
/// from the transform V of the sequence in Makhoul's order (even samples up, odd samples down; IEEE Trans. ASSP 28, 27
/// (1980)).
void spread_cosine(const float* source, const float* otf, bool complex_otf, std::span<const Term> terms,
                   const float* twiddles, std::int64_t n, float* target, std::int64_t target_rows);

/// Back to the transform of the Makhoul sequence: V_k = conj(t_k) (Y_k - i Y_{n-k}), Y_n = 0.
void unfold_cosine(const float* coefficients, const float* twiddles, std::int64_t n, float* out);

/// Real rows: C_k = Re(t_k V_k), C_{n-k} = -Im(t_k V_k) from the half spectrum V (n/2 + 1).
void cosine_from_half(const float* half, const float* twiddles, std::int64_t n, float* coefficients);

/// And back: V_k = conj(t_k) (Y_k - i Y_{n-k}) for k = 0 .. n/2.
void half_from_cosine(const float* coefficients, const float* twiddles, std::int64_t n, float* half);

/// out[i] = float((in[i] - mean) x scale); `ordered`: in Makhoul's order.
void center(const float* in, std::int64_t n, double mean, double scale, float* out);
void center_ordered(const float* in, std::int64_t n, double mean, double scale, float* out);
/// out[i] = float(in[i] x scale + mean); `ordered`: the first `count` samples of a sequence of n in Makhoul's order.
void restore(const float* in, std::int64_t n, double mean, double scale, float* out);
void restore_ordered(const float* in, std::int64_t n, std::int64_t count, double mean, double scale, float* out);

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

}  // namespace kernels
}  // namespace mtf
