// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/noise/noise_lanes.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "mtf/engines/clones.h"
#include "radiometry/stages/noise/poisson.h"

#define LANES_INLINE inline __attribute__((always_inline))

namespace radiometry {
namespace {

constexpr int kPairs = kNoiseLanes / 2;

/// 128 bits of each pair, word by word.
struct Words {
  alignas(64) std::uint32_t w[4][kPairs];
};

LANES_INLINE void philox_lanes(const RandomRow& row, std::uint32_t half_column, Words& out) {
  const auto k0 = static_cast<std::uint32_t>(row.key.seed), k1 = static_cast<std::uint32_t>(row.key.seed >> 32);
  const auto stream = static_cast<std::uint32_t>(row.stream);
  for (int i = 0; i < kPairs; ++i) {
    std::uint32_t c0 = half_column + static_cast<std::uint32_t>(i), c1 = row.y, c2 = row.key.frame, c3 = stream;
#pragma GCC unroll 10
    for (std::uint32_t round = 0; round < 10; ++round) {
      const std::uint64_t p0 = std::uint64_t{0xD2511F53} * c0, p1 = std::uint64_t{0xCD9E8D57} * c2;
      c0 = static_cast<std::uint32_t>(p1 >> 32) ^ c1 ^ (k0 + round * 0x9E3779B9);
      c2 = static_cast<std::uint32_t>(p0 >> 32) ^ c3 ^ (k1 + round * 0xBB67AE85);
      c1 = static_cast<std::uint32_t>(p1);
      c3 = static_cast<std::uint32_t>(p0);
    }
    out.w[0][i] = c0;
    out.w[1][i] = c1;
    out.w[2][i] = c2;
    out.w[3][i] = c3;
  }
}

/// (a + (b + 1/2) 2^-31) 2^-31 in the precision of T.
template <class T>
LANES_INLINE T unit_interval(std::int32_t a, std::int32_t b) {
  return (static_cast<T>(a) + (static_cast<T>(b) + T(0.5)) * T(0x1p-31)) * T(0x1p-31);
}
LANES_INLINE std::int32_t upper31(std::uint32_t word) { return static_cast<std::int32_t>(word >> 1); }
LANES_INLINE std::int32_t mirrored(std::int32_t a) { return 0x7fffffff - a; }

/// -log(u), relative error 2e-7 also next to u = 1, where `rest` = 1 - u is used.
LANES_INLINE float minus_log(float u, float rest) {
  const std::int32_t bits = std::bit_cast<std::int32_t>(u);
  const std::int32_t exponent = (bits - 0x3f3504f3) >> 23;  // of a mantissa in [sqrt(1/2), sqrt(2))
  const float mantissa = std::bit_cast<float>(bits - exponent * (1 << 23));
  const float f = exponent == 0 ? -rest : mantissa - 1.0F;
  // log(1 + f) / f by a polynomial of least deviation, 5e-9.
  float p = -0.07451196828F;
  p = p * f + 0.1280662843F;
  p = p * f - 0.1326603638F;
  p = p * f + 0.1419964791F;
  p = p * f - 0.1660836859F;
  p = p * f + 0.2000093951F;
  p = p * f - 0.2500157913F;
  p = p * f + 0.3333334535F;
  p = p * f - 0.499999885F;
  p = p * f + 1.0F;
  return -(static_cast<float>(exponent) * 0.69314718056F + f * p);
}

/// log(x) for normal x > 0, absolute error 1e-15 + 1e-15 |log x|.
LANES_INLINE double log_double(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  double mantissa = std::bit_cast<double>((bits & 0x000fffffffffffffULL) | 0x3ff0000000000000ULL);
  double exponent = std::bit_cast<double>((bits >> 52) | 0x4330000000000000ULL) - (0x1p52 + 1023.0);
  const bool large = mantissa > 1.4142135623730951;
  mantissa = large ? 0.5 * mantissa : mantissa;
  exponent = large ? exponent + 1.0 : exponent;
  const double s = (mantissa - 1.0) / (mantissa + 1.0), q = s * s;  // log = 2 atanh(s), |s| < 0.1716
  double p = 2.0 / 19.0;
  p = p * q + 2.0 / 17.0;
  p = p * q + 2.0 / 15.0;
  p = p * q + 2.0 / 13.0;
  p = p * q + 2.0 / 11.0;
  p = p * q + 2.0 / 9.0;
  p = p * q + 2.0 / 7.0;
  p = p * q + 2.0 / 5.0;
  p = p * q + 2.0 / 3.0;
  p = p * q + 2.0;
  return exponent * 0.69314718055994530942 + s * p;
}

/// exp(-x) for x in [0, 64], relative error 1e-15.
LANES_INLINE double exp_minus(double x) {
  const double turns = x * 1.4426950408889634074 + 0x1.8p52;  // rounds to an integer in the low bits
  const double n = turns - 0x1.8p52;
  const double r = (n * 0.693147180369123816490 - x) + n * 1.90821492927058770002e-10;
  double p = 1.0 / 6227020800.0;
  p = p * r + 1.0 / 479001600.0;
  p = p * r + 1.0 / 39916800.0;
  p = p * r + 1.0 / 3628800.0;
  p = p * r + 1.0 / 362880.0;
  p = p * r + 1.0 / 40320.0;
  p = p * r + 1.0 / 5040.0;
  p = p * r + 1.0 / 720.0;
  p = p * r + 1.0 / 120.0;
  p = p * r + 1.0 / 24.0;
  p = p * r + 1.0 / 6.0;
  p = p * r + 0.5;
  p = p * r + 1.0;
  p = p * r + 1.0;
  const std::uint64_t exponent = 1023 - (std::bit_cast<std::uint64_t>(turns) & 0x7ff);  // n <= 93
  return p * std::bit_cast<double>(exponent << 52);
}

/// The largest -log(4 u (1 - u)) that quantile covers, |w| = 4.006.
constexpr double kMostT = 9.0;

/// sqrt(2) erfinv(x) / x with t = -log(1 - x^2), t in [0, 9]: a polynomial of least deviation, 1.1e-12.
LANES_INLINE double quantile_over_x(double t) {
  constexpr double c[] = {-3.00455630725053981e-6,   2.63989426676429014e-6,    0.0000196994609146873524,
                          -0.0000301733728886916126, -0.0000347679085325622356, 0.000124034112558126002,
                          -0.000103125323658543611,  -0.000122021760702882347,  0.000544608835323060565,
                          -0.000794842866170302387,  -0.0000428920499485373818, 0.00264613187773460187,
                          -0.00550344652450229798,   0.00333866703179220183,    0.0105117634501789913,
                          -0.0348193395513713737,    0.0478730432098852384,     -0.00044538306811529229,
                          -0.210990227913001496,     1.40666032436943938,       2.78760252330192895};
  const double s = t * (1.0 / 4.5) - 1.0;
  double p = c[0];
#pragma GCC unroll 20
  for (int k = 1; k <= 20; ++k) p = p * s + c[k];
  return p;
}

struct PoissonBlock {
  alignas(64) double u[kNoiseLanes], rest[kNoiseLanes], mean[kNoiseLanes], count[kNoiseLanes], unsure[kNoiseLanes];
};

LANES_INLINE void uniforms(const Words& words, PoissonBlock& b) {
  for (int i = 0; i < kPairs; ++i) {
    const std::int32_t a0 = upper31(words.w[0][i]), b0 = upper31(words.w[1][i]);
    const std::int32_t a1 = upper31(words.w[2][i]), b1 = upper31(words.w[3][i]);
    b.u[2 * i] = unit_interval<double>(a0, b0);
    b.u[2 * i + 1] = unit_interval<double>(a1, b1);
    b.rest[2 * i] = unit_interval<double>(mirrored(a0), mirrored(b0));
    b.rest[2 * i + 1] = unit_interval<double>(mirrored(a1), mirrored(b1));
  }
}

/// Means from kSmallMean on, by the expansion.
LANES_INLINE void large_means(PoissonBlock& b) {
  for (int i = 0; i < kNoiseLanes; ++i) {
    const double mean = b.mean[i], root = std::sqrt(mean), t = -log_double(4.0 * b.u[i] * b.rest[i]);
    const double w = (b.u[i] - b.rest[i]) * quantile_over_x(t);
    const double guess = poisson_guess(mean, root, w), n = std::floor(guess), part = guess - n;
    const double error = mean < kLargeMean ? poisson_guess_error(mean, root) : 0.0;
    const bool doubt = part < error || part > 1.0 - error || t > kMostT;
    const bool mine = mean >= kSmallMean;
    b.count[i] = mine ? n : b.count[i];
    b.unsure[i] = mine && doubt ? 1.0 : b.unsure[i];
  }
}

/// Means below kSmallMean: the distribution function summed upwards until all lanes have passed their u. A u
/// within 1e-12 of a step, a hundred times the error of the sum, is left to poisson_exact.
LANES_INLINE void small_means(PoissonBlock& b) {
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

/// Returns whether any lane is unsure.
MTFKIT_CLONES bool poisson_block(const RandomRow& row, std::uint32_t half_column, const float* mean, PoissonBlock& b) {
  Words words;
  philox_lanes(row, half_column, words);
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

}  // namespace

MTFKIT_CLONES void gaussian_lanes(const RandomRow& row, std::uint32_t half_column, float* out) {
  Words words;
  philox_lanes(row, half_column, words);
  alignas(64) float first[kPairs], second[kPairs];
  for (int i = 0; i < kPairs; ++i) {
    const std::int32_t a = upper31(words.w[0][i]), b = upper31(words.w[1][i]);
    const float energy = minus_log(unit_interval<float>(a, b), unit_interval<float>(mirrored(a), mirrored(b)));
    const float radius = std::sqrt(2.0F * energy);
    // The angle: a quarter of the circle from the upper bits, the rest within +-1/8 of it.
    const std::uint32_t quarter = (words.w[2][i] + 0x20000000U) >> 30;
    const auto rest = static_cast<std::int32_t>(words.w[2][i] - (quarter << 30));
    const float x = (static_cast<float>(rest) + 0.5F) * 0x1p-30F, y = x * x;
    const float sine =
        x *
        (1.570796327F + y * (-0.6459640961F + y * (0.07969258273F + y * (-0.004681266257F + y * 0.0001582063036F))));
    const float cosine = 1.0F + y * (-1.233700541F + y * (0.2536692037F + y * (-0.0208600695F + y * 0.0009036280664F)));
    const bool odd = (quarter & 1U) != 0;
    const float c = odd ? sine : cosine, s = odd ? cosine : sine;
    first[i] = ((quarter + 1U) & 2U) != 0 ? -radius * c : radius * c;
    second[i] = (quarter & 2U) != 0 ? -radius * s : radius * s;
  }
  for (int i = 0; i < kPairs; ++i) {
    out[2 * i] = first[i];
    out[2 * i + 1] = second[i];
  }
}

void poisson_lanes(const RandomRow& row, std::uint32_t half_column, const float* mean, float* out) {
  PoissonBlock b;
  if (poisson_block(row, half_column, mean, b))
    for (int i = 0; i < kNoiseLanes; ++i)
      if (b.unsure[i] > 0.0) b.count[i] = poisson_exact({b.u[i], b.rest[i]}, static_cast<double>(mean[i]));
  for (int i = 0; i < kNoiseLanes; ++i) out[i] = static_cast<float>(b.count[i]);
}

}  // namespace radiometry
