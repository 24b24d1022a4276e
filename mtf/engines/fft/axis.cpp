// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/fft/axis.h"

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

}  // namespace mtf
