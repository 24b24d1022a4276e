// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random numbers for kNoiseLanes pixels at a time, in plain loops over lanes that the compiler turns into vectors.
// Each lane depends on its own pixel alone, and no operation is contracted or reordered, so that the numbers are the
// same wherever a block begins and on every machine.

#include <bit>

#include "mtf/math/simd.h"
#include "radiometry/stages/noise/random.h"

namespace radiometry {

inline constexpr int kNoiseLanes = 128;

/// Standard normal numbers of the pixels 2 half_column ... 2 half_column + kNoiseLanes - 1: by the transform of Box and
/// Muller, the radius from 62 bits, so that the tails extend to 9.2 sigma, the angle from 32.
void gaussian_lanes(const RandomRow& row, std::uint32_t half_column, float* out);

/// Poisson numbers of the same pixels for the means given; see poisson.h.
void poisson_lanes(const RandomRow& row, std::uint32_t half_column, const float* mean, float* out);

// What these loops share: random words, numbers between 0 and 1, the logarithm.

constexpr int kPairs = kNoiseLanes / 2;

/// 128 bits of each pair, word by word.
struct Words {
  alignas(64) std::uint32_t w[4][kPairs];
};

/// The bits of RandomRow::pair for the pairs from `half_column` on.
void philox_lanes(const RandomRow& row, std::uint32_t half_column, Words& out);

/// (a + (b + 1/2) 2^-31) 2^-31 in the precision of T.
template <class T>
MTFKIT_INLINE T unit_interval(std::int32_t a, std::int32_t b) {
  return (static_cast<T>(a) + (static_cast<T>(b) + T(0.5)) * T(0x1p-31)) * T(0x1p-31);
}
MTFKIT_INLINE std::int32_t upper31(std::uint32_t word) { return static_cast<std::int32_t>(word >> 1); }
MTFKIT_INLINE std::int32_t mirrored(std::int32_t a) { return 0x7fffffff - a; }

/// c[0] x^(N - 1) + ... + c[N - 1]
template <class T, int N>
MTFKIT_INLINE T polynomial(const T (&c)[N], T x) {
  T p = c[0];
#pragma GCC unroll 32
  for (int k = 1; k < N; ++k) p = p * x + c[k];
  return p;
}

/// -log(u), relative error 2e-7 also next to u = 1, where `rest` = 1 - u is used.
MTFKIT_INLINE float minus_log(float u, float rest) {
  const std::int32_t bits = std::bit_cast<std::int32_t>(u);
  const std::int32_t exponent = (bits - 0x3f3504f3) >> 23;  // of a mantissa in [sqrt(1/2), sqrt(2))
  const float mantissa = std::bit_cast<float>(bits - exponent * (1 << 23));
  const float f = exponent == 0 ? -rest : mantissa - 1.0F;
  // log(1 + f) / f by a polynomial of least deviation, 5e-9.
  constexpr float c[] = {-0.07451196828F, 0.1280662843F,  -0.1326603638F, 0.1419964791F, -0.1660836859F,
                         0.2000093951F,   -0.2500157913F, 0.3333334535F,  -0.499999885F, 1.0F};
  return -(static_cast<float>(exponent) * 0.69314718056F + f * polynomial(c, f));
}

}  // namespace radiometry
