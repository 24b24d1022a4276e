// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/fft/axis.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>

#include "mtf/engines/fft/lane_kernels.h"
#include "mtf/math/special.h"

namespace mtf {
namespace {

std::int64_t modulo(std::int64_t a, std::int64_t m) { return (a % m + m) % m; }

// Chirp exp(i pi turns k^2): k^2 x turns exceeds what a double resolves, so the product is reduced in long double.
Complex<double> chirp(std::int64_t k, double turns, double sign) {
  const long double square = static_cast<long double>(k) * static_cast<long double>(k);
  return rotation(static_cast<long double>(sign) * 0.5L * square * static_cast<long double>(turns));
}

Term term(std::int64_t k, std::int64_t source, std::int64_t target, std::size_t otf, Complex<double> factor) {
  return {static_cast<std::int32_t>(k),
          static_cast<std::int32_t>(source),
          static_cast<std::int32_t>(target),
          static_cast<std::int32_t>(otf),
          factor.re,
          factor.im};
}

// cos(pi k (j + 1/2) / n) for any k is +-cos of some k' < n, or zero at k = n, 3n, ...; sin(pi k (j + 1/2) / n) is
// +-(-1)^j cos of some k' < n, or zero at k = 0, 2n, ...
struct Folded {
  std::int64_t target;
  double sign;
};
Folded fold(Parity parity, std::int64_t k, std::int64_t n) {
  const std::int64_t turns = k / (2 * n), m = k % (2 * n);
  const double sign = turns % 2 == 0 ? 1.0 : -1.0;
  if (parity == Parity::odd) return m == 0 ? Folded{0, 0.0} : Folded{std::abs(n - m), sign};
  if (m == n) return {0, 0.0};
  return m < n ? Folded{m, sign} : Folded{2 * n - m, -sign};
}

// Rows of the first `count` of n samples: in order, or in Makhoul's order, even ones up, odd ones down.
std::vector<std::int32_t> sample_rows(std::int64_t count, std::int64_t n, bool makhoul) {
  std::vector<std::int32_t> rows(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i)
    rows[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(!makhoul ? i : i % 2 == 0 ? i / 2 : n - 1 - i / 2);
  return rows;
}

}  // namespace

Complex<double> rotation(long double turns) {
  const double reduced = static_cast<double>(turns - std::floor(turns));
  return {cos_pi(2.0 * reduced), sin_pi(2.0 * reduced)};
}

double AxisTransform::turns_at_first() const {
  // Cosines are measured from the corner; transforms of samples from the centre of sample 0.
  const double centre = 0.5 * pitch_um - (frequency.basis == Basis::fourier ? 0.5 * frequency.step_um : 0.0);
  return centre / frequency.period_um();
}

std::int64_t inverse_length(const AxisTransform& job) {
  return job.resampling == Resampling::fold ? job.out_length : next_smooth(2 * job.keep - 1 + job.outputs - 1);
}

std::vector<std::int64_t> canvas_sources(const AxisTransform& job) {
  const std::int64_t length = job.frequency.length, n = job.samples, right = n + (length - n + 1) / 2;
  std::vector<std::int64_t> sources(static_cast<std::size_t>(length));
  for (std::int64_t i = 0; i < length; ++i)
    sources[static_cast<std::size_t>(i)] = border_source(job.border, i < right ? i : i - length, n);
  return sources;
}

std::vector<std::int64_t> otf_frequencies(const AxisTransform& job) {
  std::vector<std::int64_t> frequencies;
  const std::int64_t length = job.frequency.length;
  const bool cosine = job.frequency.basis == Basis::cosine;
  const std::int64_t rows = cosine ? job.keep : length + (length % 2 == 0 ? 1 : 0);
  for (std::int64_t r = 0; r < rows; ++r)
    if (const std::int64_t k = job.frequency.signed_index(r); std::abs(k) < job.keep) frequencies.push_back(k);
  return frequencies;
}

double rounding_units(const AxisTransform& x, const AxisTransform& y) {
  double units = 2.0;
  for (const AxisTransform* job : {&x, &y}) {
    const double stages = std::log2(1.0 + static_cast<double>(job->frequency.length));
    const bool chirps = job->resampling == Resampling::chirp;
    const bool small = in_small_steps(job->frequency.length) && in_small_steps(inverse_length(*job));
    units += 0.5 * stages * (chirps ? 4.0 : small ? 1.0 : 3.0);
  }
  return units;
}

std::vector<Term> axis_terms(const AxisTransform& job, Parity parity) {
  std::vector<Term> terms;
  const std::int64_t length = job.frequency.length;
  const auto chirped = [&](std::int64_t k, double weight) {
    const Complex<double> start =
        rotation(static_cast<long double>(k) * static_cast<long double>(job.turns_at_first()));
    const Complex<double> c = start * chirp(k, job.turns_per_output(), 1.0);
    return Complex<double>{weight * c.re, weight * c.im};
  };
  const std::vector<std::int64_t> frequencies = otf_frequencies(job);
  for (std::size_t row = 0; row < frequencies.size(); ++row) {
    const std::int64_t k = frequencies[row];
    if (job.frequency.basis == Basis::fourier) {
      const double weight = length % 2 == 0 && std::abs(k) == length / 2 ? 0.5 : 1.0;
      const std::int64_t source = modulo(k, length);
      if (job.resampling == Resampling::chirp) {
        terms.push_back(term(k, source, k + job.keep - 1, row, chirped(k, weight)));
      } else {
        const Complex<double> c =
            rotation(static_cast<long double>(k) * static_cast<long double>(job.turns_at_first()));
        terms.push_back(term(k, source, modulo(k, job.out_length), row, {weight * c.re, weight * c.im}));
      }
    } else if (job.resampling == Resampling::fold) {
      const auto [target, sign] = fold(parity, k, job.out_length);
      // The inverse doubles every frequency but the zeroth, where an alias therefore counts twice.
      if (sign != 0.0) terms.push_back(term(k, k, target, row, {k != 0 && target == 0 ? 2.0 * sign : sign, 0.0}));
    } else if (k == 0) {
      if (parity == Parity::even) terms.push_back(term(0, 0, job.keep - 1, row, {1.0, 0.0}));
    } else {
      // Doubled as well: 2 cos t = exp(i t) + exp(-i t), 2 sin t = -i exp(i t) + i exp(-i t).
      const auto exponential = [&](std::int64_t signed_k, Complex<double> odd) {
        const Complex<double> factor = parity == Parity::even ? Complex<double>{1.0, 0.0} : odd;
        terms.push_back(term(k, k, signed_k + job.keep - 1, row, factor * chirped(signed_k, 1.0)));
      };
      exponential(k, {0.0, -1.0});
      exponential(-k, {0.0, 1.0});
    }
  }
  return terms;
}

template <class S>
std::vector<S> cosine_twiddles(std::int64_t n) {
  std::vector<S> t(2 * static_cast<std::size_t>(n));
  for (std::int64_t k = 0; k < n; ++k) {
    const double half_turns = static_cast<double>(k) / (2.0 * static_cast<double>(n));
    t[2 * static_cast<std::size_t>(k)] = static_cast<S>(cos_pi(half_turns));
    t[2 * static_cast<std::size_t>(k) + 1] = static_cast<S>(-sin_pi(half_turns));
  }
  return t;
}
template std::vector<float> cosine_twiddles<float>(std::int64_t);
template std::vector<double> cosine_twiddles<double>(std::int64_t);

template <class S>
Chirp<S>::Chirp(const AxisTransform& job, fft::Rigor rigor)
    : outputs_(job.outputs),
      transform_(inverse_length(job), rigor),
      kernel_(2 * static_cast<std::size_t>(inverse_length(job))),
      after_(2 * static_cast<std::size_t>(job.outputs)) {
  // k j = (k^2 + j^2 - (j - k)^2) / 2 turns the sum into a convolution with exp(-i pi t n^2); row k + keep - 1 holds k.
  const std::int64_t length = inverse_length(job);
  std::vector<Complex<double>> kernel(static_cast<std::size_t>(length));
  const double t = job.turns_per_output();
  const std::int64_t shift = job.keep - 1;
  for (std::int64_t n = -shift; n <= job.outputs - 1 + shift; ++n) {
    // Row r of the input contributes to output j at lag j - (r - shift); the convolution index is j - r.
    kernel[static_cast<std::size_t>(modulo(n - shift, length))] = chirp(n, t, -1.0);
  }
  // fft::inverse has sign +1; conjugating before and after gives the forward transform.
  for (auto& c : kernel) c.im = -c.im;
  fft::inverse(kernel);
  const double scale = 1.0 / static_cast<double>(length);
  for (std::size_t i = 0; i < kernel.size(); ++i) {
    const auto row = 2 * static_cast<std::size_t>(transform_.place(static_cast<std::int64_t>(i)));
    kernel_[row] = static_cast<S>(kernel[i].re * scale);
    kernel_[row + 1] = static_cast<S>(-kernel[i].im * scale);
  }
  for (std::int64_t j = 0; j < job.outputs; ++j) {
    const Complex<double> c = chirp(j, t, 1.0);
    after_[2 * static_cast<std::size_t>(j)] = static_cast<S>(c.re);
    after_[2 * static_cast<std::size_t>(j) + 1] = static_cast<S>(c.im);
  }
}

template <class S>
void Chirp<S>::run(S* data) const {
  transform_.forward(data);
  lanes::multiply_rows(data, kernel_.data(), transform_.length());
  transform_.inverse(data);
  lanes::multiply_rows(data, after_.data(), outputs_);
}

template class Chirp<float>;
template class Chirp<double>;

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
