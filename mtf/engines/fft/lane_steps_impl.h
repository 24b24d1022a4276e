// SPDX-License-Identifier: Apache-2.0
#pragma once

// The bodies of the radix steps. They are the longest functions of the library, 81 of each precision (nine radices,
// three passes, three widths of vectors) and unrolled whole: every precision is compiled in a source of its own.

#include <cassert>
#include <cstdint>

#include "mtf/engines/fft/lane_steps.h"
#include "mtf/math/simd.h"

// Discrete Fourier transforms of a few points, sign -1, in registers: z[k] <- sum_j z[j] exp(-2 pi i j k / R).
// Products of two lengths by the Cooley-Tukey step, odd primes by pairing j with R - j.
namespace mtf::simd {

/// cos and sin of 2 pi j / R, j = 1 .. (R-1)/2, for the odd primes; root_cos and root_sin for any j.
template <int R>
inline constexpr double kCos[(R - 1) / 2] = {};
template <int R>
inline constexpr double kSin[(R - 1) / 2] = {};
template <>
inline constexpr double kCos<3>[1] = {-0.50000000000000000000};
template <>
inline constexpr double kSin<3>[1] = {0.86602540378443864676};
template <>
inline constexpr double kCos<5>[2] = {0.30901699437494742410, -0.80901699437494742410};
template <>
inline constexpr double kSin<5>[2] = {0.95105651629515357212, 0.58778525229247312917};
template <>
inline constexpr double kCos<7>[3] = {0.62348980185873353053, -0.22252093395631440429, -0.90096886790241912624};
template <>
inline constexpr double kSin<7>[3] = {0.78183148246802980871, 0.97492791218182360702, 0.43388373911755812048};
template <>
inline constexpr double kCos<11>[5] = {0.84125353283118116886, 0.41541501300188642553, -0.14231483827328514044,
                                       -0.65486073394528506406, -0.95949297361449738989};
template <>
inline constexpr double kSin<11>[5] = {0.54064081745559758211, 0.90963199535451837141, 0.98982144188093273238,
                                       0.75574957435425828377, 0.28173255684142969771};
template <>
inline constexpr double kCos<13>[6] = {0.88545602565320989590,  0.56806474673115580251,  0.12053668025532305335,
                                       -0.35460488704253562597, -0.74851074817110109863, -0.97094181742605202716};
template <>
inline constexpr double kSin<13>[6] = {0.46472317204376854566, 0.82298386589365639458, 0.99270887409805399280,
                                       0.93501624268541482344, 0.66312265824079520238, 0.23931566428755776715};

template <int R>
constexpr double root_cos(int j) {
  j %= R;
  return j == 0 ? 1.0 : j <= R / 2 ? kCos<R>[j - 1] : kCos<R>[R - j - 1];
}
template <int R>
constexpr double root_sin(int j) {
  j %= R;
  return j == 0 ? 0.0 : j <= R / 2 ? kSin<R>[j - 1] : -kSin<R>[R - j - 1];
}

template <int R, class P>
MTFKIT_INLINE void dft(P (&z)[R]) {
  using S = decltype(z[0].re[0] + 0);
  constexpr int half = (R - 1) / 2;
  P sum[half], difference[half];
  const P first = z[0];
#pragma GCC unroll 8
  for (int j = 1; j <= half; ++j) {
    sum[j - 1] = z[j] + z[R - j];
    difference[j - 1] = z[j] - z[R - j];
    z[0] = z[0] + sum[j - 1];
  }
#pragma GCC unroll 8
  for (int k = 1; k <= half; ++k) {
    P even = first, odd = difference[0] * static_cast<S>(root_sin<R>(k));
#pragma GCC unroll 8
    for (int j = 1; j <= half; ++j) even = even + sum[j - 1] * static_cast<S>(root_cos<R>(j * k));
#pragma GCC unroll 8
    for (int j = 2; j <= half; ++j) odd = odd + difference[j - 1] * static_cast<S>(root_sin<R>(j * k));
    z[k] = minus_i(even, odd);
    z[R - k] = plus_i(even, odd);
  }
}

template <class P>
MTFKIT_INLINE void dft(P (&z)[2]) {
  const P a = z[0], b = z[1];
  z[0] = a + b;
  z[1] = a - b;
}

template <class P>
MTFKIT_INLINE void dft4(P& z0, P& z1, P& z2, P& z3) {
  const P a = z0 + z2, b = z0 - z2, c = z1 + z3, d = z1 - z3;
  z0 = a + c;
  z1 = minus_i(b, d);
  z2 = a - c;
  z3 = plus_i(b, d);
}

template <class P>
MTFKIT_INLINE void dft(P (&z)[4]) {
  dft4(z[0], z[1], z[2], z[3]);
}

template <class P>
MTFKIT_INLINE void dft(P (&z)[8]) {
  using S = decltype(z[0].re[0] + 0);
  constexpr S root = static_cast<S>(0.70710678118654752440);
  dft4(z[0], z[2], z[4], z[6]);
  dft4(z[1], z[3], z[5], z[7]);
  const P o1 = z[3], o2 = z[5], o3 = z[7];
  // exp(-i pi/4) and exp(-3 i pi/4) times the odd part
  const P t1 = minus_i(o1, o1) * root, t3 = plus_i(o3, o3) * -root;
  const P e0 = z[0], e1 = z[2], e2 = z[4], e3 = z[6], o0 = z[1];
  z[0] = e0 + o0;
  z[4] = e0 - o0;
  z[1] = e1 + t1;
  z[5] = e1 - t1;
  z[2] = minus_i(e2, o2);
  z[6] = plus_i(e2, o2);
  z[3] = e3 + t3;
  z[7] = e3 - t3;
}

template <class P>
MTFKIT_INLINE void dft(P (&z)[16]) {
  using S = decltype(z[0].re[0] + 0);
  constexpr S root = static_cast<S>(0.70710678118654752440);
  constexpr S c = static_cast<S>(0.92387953251128675613), s = static_cast<S>(0.38268343236508977173);
#pragma GCC unroll 4
  for (int j = 0; j < 4; ++j) dft4(z[j], z[4 + j], z[8 + j], z[12 + j]);
  // z[4 q + j] holds part q of column j: times exp(-2 pi i q j / 16).
  z[5] = z[5].turned(c, -s);
  z[6] = minus_i(z[6], z[6]) * root;
  z[7] = z[7].turned(s, -c);
  z[9] = minus_i(z[9], z[9]) * root;
  z[10] = P{z[10].im, -z[10].re};
  z[11] = plus_i(z[11], z[11]) * -root;
  z[13] = z[13].turned(s, -c);
  z[14] = plus_i(z[14], z[14]) * -root;
  z[15] = z[15].turned(-c, s);
#pragma GCC unroll 4
  for (int q = 0; q < 4; ++q) dft4(z[4 * q], z[4 * q + 1], z[4 * q + 2], z[4 * q + 3]);
  // z[4 q + r] is frequency q + 4 r.
  const P t1 = z[1], t2 = z[2], t3 = z[3], t6 = z[6], t7 = z[7], t11 = z[11];
  z[1] = z[4], z[2] = z[8], z[3] = z[12], z[6] = z[9], z[7] = z[13], z[11] = z[14];
  z[4] = t1, z[8] = t2, z[12] = t3, z[9] = t6, z[13] = t7, z[14] = t11;
}

}  // namespace mtf::simd

namespace mtf::lanes {

// Sign -1 on (re, im); sign +1 is the same with re and im exchanged.
template <class S, int R, Pass pass>
struct Radix {
  template <int Bytes>
  static MTFKIT_INLINE void run(S* re, S* im, std::int64_t stride, std::int64_t blocks, const S* twiddles,
                                const S* from, const std::int32_t* rows) {
    const std::int64_t size = R * stride;
    for (std::int64_t b = 0; b < blocks; ++b, re += size * kRow, im += size * kRow) {
      butterflies<Bytes, false>(re, im, stride, 0, nullptr, from, rows);
      const S* w = twiddles;
      for (std::int64_t p = 1; p < stride; ++p, w += 2 * (R - 1))
        butterflies<Bytes, true>(re, im, stride, p, w, from, rows);
    }
  }

  template <int Bytes, bool turned>
  static MTFKIT_INLINE void butterflies(S* re, S* im, std::int64_t stride, std::int64_t p, const S* w, const S* from,
                                        const std::int32_t* rows) {
    using P = simd::Packet<S, Bytes>;
    const std::int64_t apart = stride * kRow;
    for (int lane = 0; lane < kLanes; lane += P::size) {
      S *const re_p = re + p * kRow + lane, *const im_p = im + p * kRow + lane;
      P z[R];
#pragma GCC unroll 16
      for (int j = 0; j < R; ++j) {
        if constexpr (pass == Pass::gather) {
          const S* row = from + std::int64_t{rows[p + j * stride]} * kRow + lane;
          z[j] = P::load(row, row + kLanes);
        } else {
          z[j] = P::load(re_p + j * apart, im_p + j * apart);
        }
      }
      if constexpr (turned && pass == Pass::inverse)
#pragma GCC unroll 16
        for (int j = 1; j < R; ++j) z[j] = z[j].turned(w[2 * j - 2], w[2 * j - 1]);
      simd::dft(z);
      if constexpr (turned && pass != Pass::inverse)
#pragma GCC unroll 16
        for (int j = 1; j < R; ++j) z[j] = z[j].turned(w[2 * j - 2], w[2 * j - 1]);
#pragma GCC unroll 16
      for (int j = 0; j < R; ++j) z[j].store(re_p + j * apart, im_p + j * apart);
    }
  }
};

template <class S, Pass pass>
void run_step(const Step<S>& step, S* data, std::int64_t blocks, const S* from, const std::int32_t* rows) {
  S *const re = pass == Pass::inverse ? data + kLanes : data, *const im = pass == Pass::inverse ? data : data + kLanes;
  const auto run = [&]<int R>() {
    simd::run<Radix<S, R, pass>>(re, im, step.stride, blocks, step.twiddles.data(), from, rows);
  };
  switch (step.radix) {
    case 2:
      return run.template operator()<2>();
    case 3:
      return run.template operator()<3>();
    case 4:
      return run.template operator()<4>();
    case 5:
      return run.template operator()<5>();
    case 7:
      return run.template operator()<7>();
    case 8:
      return run.template operator()<8>();
    case 11:
      return run.template operator()<11>();
    case 13:
      return run.template operator()<13>();
    default:
      assert(step.radix == 16);
      return run.template operator()<16>();
  }
}

}  // namespace mtf::lanes
