// SPDX-License-Identifier: Apache-2.0
// Poisson numbers of many pixels: single precision decides nearly all of them, double precision those that it leaves in
// doubt, and poisson_exact the few that are in doubt then; the numbers are those of poisson_exact.

#include <bit>
#include <cmath>

#include "mtf/device/quantiles.cl"
#include "mtf/math/clones.h"
#include "radiometry/stages/noise/noise_lanes.h"
#include "radiometry/stages/noise/poisson.h"

namespace radiometry {
namespace {

/// log(x) for normal x > 0, absolute error 1e-15 + 1e-15 |log x|.
MTFKIT_INLINE double log_double(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  double mantissa = std::bit_cast<double>((bits & 0x000fffffffffffffULL) | 0x3ff0000000000000ULL);
  double exponent = std::bit_cast<double>((bits >> 52) | 0x4330000000000000ULL) - (0x1p52 + 1023.0);
  const bool large = mantissa > 1.4142135623730951;
  mantissa = large ? 0.5 * mantissa : mantissa;
  exponent = large ? exponent + 1.0 : exponent;
  const double s = (mantissa - 1.0) / (mantissa + 1.0), q = s * s;  // log = 2 atanh(s), |s| < 0.1716
  constexpr double c[] = {2.0 / 19.0, 2.0 / 17.0, 2.0 / 15.0, 2.0 / 13.0, 2.0 / 11.0,
                          2.0 / 9.0,  2.0 / 7.0,  2.0 / 5.0,  2.0 / 3.0,  2.0};
  return exponent * 0.69314718055994530942 + s * polynomial(c, q);
}

/// exp(-x) for x in [0, 64], relative error 1e-15.
MTFKIT_INLINE double exp_minus(double x) {
  const double turns = x * 1.4426950408889634074 + 0x1.8p52;  // rounds to an integer in the low bits
  const double n = turns - 0x1.8p52;
  const double r = (n * 0.693147180369123816490 - x) + n * 1.90821492927058770002e-10;
  constexpr double c[] = {1.0 / 6227020800.0,
                          1.0 / 479001600.0,
                          1.0 / 39916800.0,
                          1.0 / 3628800.0,
                          1.0 / 362880.0,
                          1.0 / 40320.0,
                          1.0 / 5040.0,
                          1.0 / 720.0,
                          1.0 / 120.0,
                          1.0 / 24.0,
                          1.0 / 6.0,
                          0.5,
                          1.0,
                          1.0};
  const std::uint64_t exponent = 1023 - (std::bit_cast<std::uint64_t>(turns) & 0x7ff);  // n <= 93
  return polynomial(c, r) * std::bit_cast<double>(exponent << 52);
}

/// The largest -log(4 u (1 - u)) that quantile covers, |w| = 4.006.
constexpr double kMostT = 9.0;

/// sqrt(2) erfinv(x) / x with t = -log(1 - x^2), t in [0, 9]: a polynomial of least deviation, 1.1e-12.
MTFKIT_INLINE double quantile_over_x(double t) {
  constexpr double c[] = {DOUBLE_QUANTILE};
  return polynomial(c, t * (1.0 / 4.5) - 1.0);
}

/// A mean from kSmallMean on, by the expansion: the number, unless it lies next to an integer.
struct Guess {
  double count;
  bool doubt;
};
MTFKIT_INLINE Guess large_mean(double u, double rest, double mean) {
  const double root = std::sqrt(mean), t = -log_double(4.0 * u * rest);
  const double guess = poisson_guess(mean, root, (u - rest) * quantile_over_x(t)), n = std::floor(guess);
  const double part = guess - n, error = mean < kLargeMean ? poisson_guess_error(mean, root) : 0.0;
  return {n, part < error || part > 1.0 - error || t > kMostT};
}

struct PoissonBlock {
  alignas(64) double u[kNoiseLanes], rest[kNoiseLanes], mean[kNoiseLanes], count[kNoiseLanes], unsure[kNoiseLanes];
};

MTFKIT_INLINE void uniforms(const Words& words, PoissonBlock& b) {
  for (int i = 0; i < kPairs; ++i) {
    const std::int32_t a0 = upper31(words.w[0][i]), b0 = upper31(words.w[1][i]);
    const std::int32_t a1 = upper31(words.w[2][i]), b1 = upper31(words.w[3][i]);
    b.u[2 * i] = unit_interval<double>(a0, b0);
    b.u[2 * i + 1] = unit_interval<double>(a1, b1);
    b.rest[2 * i] = unit_interval<double>(mirrored(a0), mirrored(b0));
    b.rest[2 * i + 1] = unit_interval<double>(mirrored(a1), mirrored(b1));
  }
}

MTFKIT_INLINE void large_means(PoissonBlock& b) {
  for (int i = 0; i < kNoiseLanes; ++i) {
    const Guess guess = large_mean(b.u[i], b.rest[i], b.mean[i]);
    const bool mine = b.mean[i] >= kSmallMean;
    b.count[i] = mine ? guess.count : b.count[i];
    b.unsure[i] = mine && guess.doubt ? 1.0 : b.unsure[i];
  }
}

/// Means below kSmallMean: the distribution function summed upwards until all lanes have passed their u. A u
/// within 1e-12 of a step, a hundred times the error of the sum, is left to poisson_exact.
MTFKIT_INLINE void small_means(PoissonBlock& b) {
  constexpr double kDoubt = 1e-12;
  constexpr int kMost = 256, kBatch = 4;
  alignas(64) double sum[kNoiseLanes], term[kNoiseLanes], mean[kNoiseLanes];
  for (int i = 0; i < kNoiseLanes; ++i) {
    mean[i] = b.mean[i] < kSmallMean ? b.mean[i] : 0.0;
    sum[i] = term[i] = exp_minus(mean[i]);
    b.count[i] = 0.0;
  }
  for (int n = 1; n < kMost; n += kBatch) {
    double waiting = 0.0;
    for (int i = 0; i < kNoiseLanes; ++i) {
      for (int k = 0; k < kBatch; ++k) {
        const double ahead = b.u[i] - sum[i];
        b.count[i] = ahead > 0.0 ? b.count[i] + 1.0 : b.count[i];
        b.unsure[i] = ahead < kDoubt && ahead > -kDoubt && mean[i] > 0.0 ? 1.0 : b.unsure[i];
        term[i] *= mean[i] * (1.0 / (n + k));
        sum[i] += term[i];
      }
      waiting = b.u[i] - sum[i] > 0.0 && mean[i] > 0.0 ? 1.0 : waiting;
    }
    if (waiting == 0.0) {
      for (int i = 0; i < kNoiseLanes; ++i) {
        const double ahead = b.u[i] - sum[i];
        b.unsure[i] = ahead < kDoubt && ahead > -kDoubt && mean[i] > 0.0 ? 1.0 : b.unsure[i];
      }
      return;
    }
  }
  for (int i = 0; i < kNoiseLanes; ++i) b.unsure[i] = b.u[i] - sum[i] > 0.0 ? 1.0 : b.unsure[i];
}

/// All lanes in double precision. Returns whether any is unsure.
MTFKIT_CLONES bool double_block(const Words& words, const float* mean, PoissonBlock& b) {
  uniforms(words, b);
  for (int i = 0; i < kNoiseLanes; ++i) {
    const double m = static_cast<double>(mean[i]);
    b.unsure[i] = m < 4e38 ? 0.0 : 1.0;  // NaN and infinity are
    b.mean[i] = m > 0.0 && m < 4e38 ? m : 0.0;
  }
  double small = 0.0, large = 0.0;
  for (int i = 0; i < kNoiseLanes; ++i) small = b.mean[i] < kSmallMean ? 1.0 : small;
  for (int i = 0; i < kNoiseLanes; ++i) large = b.mean[i] < kSmallMean ? large : 1.0;
  if (small > 0.0) small_means(b);
  if (large > 0.0) large_means(b);
  double unsure = 0.0;
  for (int i = 0; i < kNoiseLanes; ++i) unsure = b.unsure[i] > 0.0 ? 1.0 : unsure;
  return unsure > 0.0;
}

/// sqrt(2) erfinv(x) / x as quantile_over_x has it, in single precision: a polynomial of least deviation, 3e-8.
MTFKIT_INLINE float single_quantile_over_x(float t) {
  constexpr float c[] = {SINGLE_QUANTILE};
  return polynomial(c, t * (1.0F / 4.5F) - 1.0F);
}

constexpr float kLeastSingle = static_cast<float>(kSmallMean);
constexpr float kMostSingle = 0x1p22F;  // from here on a float no longer holds quarters

/// Means from kLeastSingle to kMostSingle in single precision, whose error is some 1e-6 of the deviation from the mean.
/// `open` is set where that leaves the number in doubt, and of other means; returns how many are.
MTFKIT_CLONES int single_block(const Words& words, const float* means, float* count, std::int32_t* open) {
  alignas(64) std::int32_t upper[kNoiseLanes], lower[kNoiseLanes];
  for (int i = 0; i < kPairs; ++i) {
    upper[2 * i] = upper31(words.w[0][i]), lower[2 * i] = upper31(words.w[1][i]);
    upper[2 * i + 1] = upper31(words.w[2][i]), lower[2 * i + 1] = upper31(words.w[3][i]);
  }
  int all = 0;
  for (int i = 0; i < kNoiseLanes; ++i) {
    const bool mine = means[i] >= kLeastSingle && means[i] < kMostSingle;
    const float mean = mine ? means[i] : kLeastSingle, root = std::sqrt(mean), r = 1.0F / root;
    const float u = unit_interval<float>(upper[i], lower[i]),
                rest = unit_interval<float>(mirrored(upper[i]), mirrored(lower[i]));
    const float x = (static_cast<float>(upper[i] - 0x40000000) + 0.5F) * 0x1p-30F;  // u - rest
    const float t = minus_log(4.0F * (u * rest), x * x);
    const float w = x * single_quantile_over_x(t);
    const float whole = std::floor(mean), guess = (mean - whole) + poisson_shift(root, w), n = std::floor(guess),
                part = guess - n;
    const float error = 1.5e-6F * std::abs(root * w) + 4e-6F + 12.0F * (r * r) * (r * r) * r;
    const bool sure = mine && part > error && part < 1.0F - error && t < 0.99F * static_cast<float>(kMostT);
    count[i] = whole + n;
    open[i] = sure ? 0 : 1;
    all += open[i];
  }
  return all;
}

float one_number(const Words& words, const float* means, int i) {
  const int pair = i / 2, word = 2 * (i % 2);
  const std::int32_t a = upper31(words.w[word][pair]), b = upper31(words.w[word + 1][pair]);
  const double u = unit_interval<double>(a, b), rest = unit_interval<double>(mirrored(a), mirrored(b));
  const auto mean = static_cast<double>(means[i]);
  if (mean >= kSmallMean && mean < static_cast<double>(kMostSingle)) {
    const Guess guess = large_mean(u, rest, mean);
    if (!guess.doubt) return static_cast<float>(guess.count);
  }
  return static_cast<float>(poisson_exact({u, rest}, mean));
}

}  // namespace

void poisson_lanes(const RandomRow& row, std::uint32_t half_column, const float* mean, float* out) {
  constexpr int kFew = 16;  // that are faster one by one
  Words words;
  philox_lanes(row, half_column, words);
  int others = 0;
  for (int i = 0; i < kNoiseLanes; ++i) others += mean[i] >= kLeastSingle && mean[i] < kMostSingle ? 0 : 1;
  alignas(64) std::int32_t open[kNoiseLanes];
  if (others <= kFew && single_block(words, mean, out, open) <= 2 * kFew) {
    for (int i = 0; i < kNoiseLanes; ++i)
      if (open[i] != 0) out[i] = one_number(words, mean, i);
    return;
  }
  PoissonBlock b;
  if (double_block(words, mean, b))
    for (int i = 0; i < kNoiseLanes; ++i)
      if (b.unsure[i] > 0.0) b.count[i] = poisson_exact({b.u[i], b.rest[i]}, static_cast<double>(mean[i]));
  for (int i = 0; i < kNoiseLanes; ++i) out[i] = static_cast<float>(b.count[i]);
}

}  // namespace radiometry
