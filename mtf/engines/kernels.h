// SPDX-License-Identifier: Apache-2.0
#pragma once

// Hot loops on plain arrays, compiled for several instruction sets in one binary (run-time dispatch).

#include <array>
#include <cstdint>
#include <span>

namespace mtf::kernels {

/// out[i] = (in[i] - mean) x scale. Into float: for a mean that is a float and a scale that is a power of two, which
/// leaves one rounding of the difference.
void center(const float* in, std::int64_t n, double mean, double scale, float* out);
void center(const float* in, std::int64_t n, double mean, double scale, double* out);
/// The same for any mean and scale, rounded once.
void standardise(const float* in, std::int64_t n, double mean, double scale, float* out);
/// The same in Makhoul's order, even samples up, odd samples down (IEEE Trans. ASSP 28, 27 (1980)).
void center_ordered(const float* in, std::int64_t n, double mean, double scale, float* out);

/// out[i] = in[i] x scale + mean, scale a power of two. In float, what mean has beyond float is added first: rounded
/// there to 2^-24 of the change, then to float.
void restore(const float* in, std::int64_t n, double mean, double scale, float* out);
void restore(const double* in, std::int64_t n, double mean, double scale, float* out);

struct Scaled {
  float factor = 0.0F;
  const float* values = nullptr;
};
/// out[i] += in[i] x sum over the terms of factor x values[i].
void add_weighted(const float* in, std::int64_t n, std::span<const Scaled> terms, float* out);

inline constexpr std::int64_t kColumns = 32;  ///< columns that are loaded or stored together

/// `center` for `rows` rows of `count` <= kColumns samples, `stride` apart, to rows of kColumns, filled up with zeros.
void center_columns(const float* in, std::int64_t stride, std::int64_t rows, std::int64_t count, double mean,
                    double scale, float* out);
void center_columns(const float* in, std::int64_t stride, std::int64_t rows, std::int64_t count, double mean,
                    double scale, double* out);
/// The inverse, as `restore` is: row i of the result is row order[i] of `in`.
void restore_columns(const float* in, std::span<const std::int32_t> order, std::int64_t count, double mean,
                     double scale, std::int64_t stride, float* out);
void restore_columns(const double* in, std::span<const std::int32_t> order, std::int64_t count, double mean,
                     double scale, std::int64_t stride, float* out);

/// Cosine coefficients of a real row from the half spectrum V (n/2 + 1) of its Makhoul order: C_k = Re(t_k V_k),
/// C_{n-k} = -Im(t_k V_k), t_k = exp(-i pi k / 2n).
void cosine_from_half(const float* half, const float* twiddles, std::int64_t n, float* coefficients);

/// One value of a table that is interpolated linearly, and the difference of the next value from it.
using Knot = std::array<float, 2>;

/// out[i] *= the table at min(sqrt(x2[i] + y2) x intervals, intervals); intervals + 1 knots.
void multiply_by_table(const Knot* knots, float intervals, const float* x2, float y2, std::int64_t n, float* out);

/// out[i] *= the table at min(|x[i] + y| x intervals, intervals); intervals + 1 knots.
void multiply_by_line_table(const Knot* knots, float intervals, const float* x, float y, std::int64_t n, float* out);

struct RowSummary {
  double sum = 0.0;
  float min = 0.0F, max = 0.0F;
};

/// Fetches samples into the cache before they are needed. The processor predicts no row by itself where each row lies
/// in a memory page of its own.
inline void prefetch(const float* in, std::int64_t n) {
  for (std::int64_t i = 0; i < n; i += 16) __builtin_prefetch(in + i);
}

/// Sum in a fixed order (the same on every machine), extremes; a NaN or infinity shows in the sum.
RowSummary summarise_row(const float* in, std::int64_t n);

/// sum of (in[i] - about)^2 in a fixed order.
double squares_about(const float* in, std::int64_t n, double about);

struct Moments {
  double sum = 0.0, squares = 0.0;
  void operator+=(const Moments& other) { sum += other.sum, squares += other.squares; }
};
/// Moments of numbers of about 1 that arrive in pieces, added in a fixed order. A number that is not finite, or far too
/// large for its type, makes the sum of squares infinite or NaN.
struct MomentSums {
  static constexpr int kStep = 32;
  std::array<double, kStep> sums{}, squares{};
  Moments total() const;
};
void add(const float* in, std::int64_t n, MomentSums& sums);
void add(const double* in, std::int64_t n, MomentSums& sums);

/// Whether all samples have the same bits.
bool all_alike(const float* in, std::int64_t n);
/// Whether both arrays have the same bits.
bool same(const float* a, const float* b, std::int64_t n);

}  // namespace mtf::kernels
