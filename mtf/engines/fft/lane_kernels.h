// SPDX-License-Identifier: Apache-2.0
#pragma once

// The hot loops of the spectral engine on rows of lanes (mtf/engines/fft/batched_fft.h): a row is kRow numbers, real
// parts first. All are instantiated for float and double.

#include <cstdint>
#include <span>

#include "mtf/engines/fft/batched_fft.h"

namespace mtf::lanes {

/// What a source row of a spread is.
enum class Source {
  plain,   ///< row `up`
  cosine,  ///< (t V_k + conj(t) V_{n-k}) / 2 of rows `up` and `down`, t = exp(-i pi k / 2n): the cosine coefficient of
           ///< k from the transform V of the sequence in Makhoul's order (even samples up, odd samples down; IEEE
           ///< Trans. ASSP 28, 27 (1980))
  pairs    ///< A + i B, or conj(A) + i conj(B): two real sequences in one, from their coefficients in rows `up`, `down`
};

/// How a row of the OTF multiplies its source row.
enum class Factor {
  none,
  real,    ///< number by number
  complex  ///< lane by lane
};

/// One source row that is added to a target row.
template <class S>
struct FoldTerm {
  std::int32_t up = 0, down = 0, target = 0;
  std::int32_t otf = 0;  ///< row of the OTF
  bool first = true;     ///< the target holds nothing yet
  S cos = 0, sin = 0;    ///< cosine: t / 2; pairs: sin is +1, or -1 for the conjugates
  S re = 1, im = 0;      ///< factor
};

/// target[term.target] += factor x otf[term.otf] x source over the terms.
template <class S>
void scatter_add(Source source, Factor factor, std::span<const FoldTerm<S>> terms, const S* from, const S* otf,
                 S* target);

/// Coefficients A, B (rows 2k, 2k + 1 of `to`) of two real sequences a, b from the transform of a + i b: terms k give
/// the rows of frequencies k and -k.
template <class S>
void separate(std::span<const FoldTerm<S>> terms, const S* from, S* to);

/// Back to the transform of the sequence in Makhoul's order: row place[k] = conj(t) (Y_k - i Y_{n-k}), Y_n = 0.
template <class S>
void unfold_cosine(const S* coefficients, const S* twiddles, std::span<const std::int32_t> place, S* to);

/// Row r times the complex number factors[r].
template <class S>
void multiply_rows(S* data, const S* factors, std::int64_t rows);

/// The number in row i and column j of a square of kLanes x kLanes goes to row j, column i. Strides count numbers.
template <class S>
void transpose(const S* from, std::int64_t from_stride, S* to, std::int64_t to_stride);

/// kRow lines of `count` numbers become lanes: number j of line l is number l of row j. Lines fill whole kLanes.
template <class S>
void lines_to_lanes(const S* lines, std::int64_t stride, std::int64_t count, S* data);
/// The inverse: number j of line l is number l of row rows[j].
template <class S>
void lanes_to_lines(const S* data, std::span<const std::int32_t> rows, S* lines, std::int64_t stride);

}  // namespace mtf::lanes
