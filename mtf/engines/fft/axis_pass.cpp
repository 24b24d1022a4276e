// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/fft/axis_pass.h"

#include <algorithm>
#include <cassert>

namespace mtf {
namespace {

// Rows of the first `count` of n samples: in order, or in Makhoul's order, even ones up, odd ones down.
std::vector<std::int32_t> sample_rows(std::int64_t count, std::int64_t n, bool makhoul) {
  std::vector<std::int32_t> rows(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i)
    rows[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(!makhoul ? i : i % 2 == 0 ? i / 2 : n - 1 - i / 2);
  return rows;
}

}  // namespace

template <class S>
AxisPass<S>::AxisPass(const AxisTransform& job, bool apart, fft::Rigor rigor)
    : job_(job), forward_(job.frequency.length, rigor) {
  assert(cosine() || !job.odd);
  const std::int64_t length = job.frequency.length, n = job.samples;
  if (cosine()) twiddles_ = cosine_twiddles<S>(length);
  if (cosine()) {
    canvas_.resize(static_cast<std::size_t>(n));
    const std::vector<std::int32_t> rows = sample_rows(n, n, true);
    for (std::int64_t i = 0; i < n; ++i)
      canvas_[static_cast<std::size_t>(rows[static_cast<std::size_t>(i)])] = static_cast<std::int32_t>(i);
  } else {
    for (const std::int64_t source : canvas_sources(job))
      canvas_.push_back(static_cast<std::int32_t>(source < 0 ? n : source));
  }

  if (job.resampling == Resampling::chirp) {
    chirp_ = Chirp<S>(job, rigor);
  } else {
    inverse_ = BatchedFft<S>(job.out_length, rigor);
    if (cosine()) out_twiddles_ = cosine_twiddles<S>(job.out_length);
  }
  const bool folded_cosine = cosine() && job.resampling == Resampling::fold;
  out_rows_ = sample_rows(job.outputs, job.out_length, folded_cosine);
  if (folded_cosine)
    for (std::int64_t k = 0; k < job.out_length; ++k) out_place_.push_back(inverse_.place(k));

  source_ = apart ? (cosine() ? lanes::Source::plain : lanes::Source::pairs)
                  : (cosine() ? lanes::Source::cosine : lanes::Source::plain);
  even_ = inverse_input(Parity::even, apart);
  if (job.odd) odd_ = inverse_input(Parity::odd, apart);
  if (!apart) return;
  for (std::int64_t k = 0; k < job.keep; ++k) {
    coefficients_.push_back(source_of(k));
    coefficients_.back().target = static_cast<std::int32_t>(k);
  }
}

template <class S>
auto AxisPass<S>::inverse_input(Parity parity, bool apart) const -> InverseInput {
  InverseInput input;
  std::vector<bool> used(static_cast<std::size_t>(inverse_length(job_)));
  for (const Term& part : axis_terms(job_, parity)) {
    lanes::FoldTerm<S> term;
    if (!apart) {
      term = source_of(part.source);
    } else if (cosine()) {
      term.up = part.source;
    } else {
      term.up = 2 * std::abs(part.k);
      term.down = term.up + 1;
      term.sin = part.k < 0 ? S(-1) : S(1);
    }
    // The chirp and the unfolding take their input in order, a transform at its places.
    const bool in_order = job_.resampling == Resampling::chirp || cosine();
    term.target = in_order ? part.target : inverse_.place(part.target);
    term.otf = part.otf;
    term.re = static_cast<S>(part.re);
    term.im = static_cast<S>(part.im);
    term.first = !used[static_cast<std::size_t>(term.target)];
    used[static_cast<std::size_t>(term.target)] = true;
    input.terms.push_back(term);
  }
  for (std::size_t r = 0; r < used.size(); ++r)
    if (!used[r]) input.zeros.push_back(static_cast<std::int32_t>(r));
  return input;
}

// Where the transform leaves frequency k, and the one it is combined with.
template <class S>
lanes::FoldTerm<S> AxisPass<S>::source_of(std::int64_t k) const {
  const std::int64_t length = job_.frequency.length;
  lanes::FoldTerm<S> term;
  term.up = forward_.place(k);
  term.down = forward_.place(k == 0 ? 0 : length - k);
  if (!cosine()) return term;
  term.cos = S(0.5) * twiddles_[2 * static_cast<std::size_t>(k)];
  term.sin = S(0.5) * twiddles_[2 * static_cast<std::size_t>(k) + 1];
  return term;
}

template <class S>
void AxisPass<S>::coefficients(const S* work, S* to) const {
  if (cosine())
    lanes::scatter_add<S>(lanes::Source::cosine, lanes::Factor::none, coefficients_, work, nullptr, to);
  else
    lanes::separate<S>(coefficients_, work, to);
}

template <class S>
S* AxisPass<S>::inverse(Parity parity, const S* from, const S* otf, bool complex_otf, S* target, S* work) const {
  using lanes::Factor;
  const InverseInput& input = parity == Parity::even ? even_ : odd_;
  for (const std::int32_t row : input.zeros) std::fill_n(target + std::int64_t{row} * kRow, kRow, S(0));
  const Factor factor = otf == nullptr ? Factor::none : complex_otf ? Factor::complex : Factor::real;
  lanes::scatter_add<S>(source_, factor, input.terms, from, otf, target);
  if (job_.resampling == Resampling::chirp) {
    chirp_.run(target);
    return target;
  }
  if (!cosine()) {
    inverse_.inverse(target);
    return target;
  }
  lanes::unfold_cosine<S>(target, out_twiddles_.data(), out_place_, work);
  inverse_.inverse(work);
  if (parity == Parity::odd) {
    // The signs alternate; the samples of odd number follow the even ones.
    S* const odd = work + (job_.out_length + 1) / 2 * kRow;
    std::transform(odd, odd + job_.out_length / 2 * kRow, odd, [](S v) { return -v; });
  }
  return work;
}

template class AxisPass<float>;
template class AxisPass<double>;

}  // namespace mtf
