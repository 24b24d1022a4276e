// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/noise/noise_lanes.h"

#include <cmath>

#include "mtf/math/clones.h"

namespace radiometry {
namespace {

template <int Bytes>
using Wide = mtf::simd::Vector<std::uint64_t, Bytes>;

/// The products of the lower halves of the lanes. One instruction of x86, for which GCC 12 writes seven; other
/// compilers find it, or check its operands against a function that has no vectors of that width.
template <int Bytes>
MTFKIT_INLINE Wide<Bytes> product(const Wide<Bytes>& a, const Wide<Bytes>& b) {
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(MTFKIT_NO_CLONES)
  Wide<Bytes> result;
  if constexpr (Bytes == 16) {
    result = a;
    asm("pmuludq %1, %0" : "+x"(result) : "x"(b));
  } else {
    asm("vpmuludq %2, %1, %0" : "=v"(result) : "v"(a), "v"(b));
  }
  return result;
#else
  return (a & 0xffffffffU) * (b & 0xffffffffU);
#endif
}

/// Counters in 64-bit lanes. Only the lower halves count: what stands above them is never read.
template <int Bytes>
struct Counters {
  Wide<Bytes> c0, c1, c2, c3;

  MTFKIT_INLINE void rounds(std::uint32_t k0, std::uint32_t k1) {
    const Wide<Bytes> first = Wide<Bytes>{} + 0xD2511F53U, second = Wide<Bytes>{} + 0xCD9E8D57U;
#pragma GCC unroll 10
    for (std::uint32_t round = 0; round < 10; ++round) {
      const Wide<Bytes> p0 = product<Bytes>(c0, first), p1 = product<Bytes>(c2, second);
      c0 = (p1 >> 32) ^ c1 ^ (Wide<Bytes>{} + (k0 + round * 0x9E3779B9U));
      c2 = (p0 >> 32) ^ c3 ^ (Wide<Bytes>{} + (k1 + round * 0xBB67AE85U));
      c1 = p1;
      c3 = p0;
    }
  }
};

struct PhiloxLanes {
  template <int Bytes>
  static MTFKIT_INLINE void run(const RandomRow* row, std::uint32_t half_column, std::uint32_t (*out)[kPairs]) {
    constexpr int lanes = Bytes / 8;
    const auto k0 = static_cast<std::uint32_t>(row->key.seed), k1 = static_cast<std::uint32_t>(row->key.seed >> 32);
    Wide<Bytes> evens;
    for (int i = 0; i < lanes; ++i) evens[i] = std::uint64_t{half_column} + 2U * static_cast<unsigned>(i);
    const Wide<Bytes> c1 = Wide<Bytes>{} + row->y, c2 = Wide<Bytes>{} + row->key.frame,
                      c3 = Wide<Bytes>{} + static_cast<std::uint32_t>(row->stream);
    static_assert(std::endian::native == std::endian::little);
    for (int i = 0; i < kPairs; i += 2 * lanes, evens += 2 * lanes) {
      // Even and odd pairs, which are put together in lanes of half the width.
      Counters<Bytes> even{evens, c1, c2, c3}, odd{evens + 1, c1, c2, c3};
      even.rounds(k0, k1);
      odd.rounds(k0, k1);
      const auto put = [i](std::uint32_t* to, const Wide<Bytes>& low, const Wide<Bytes>& high) {
        mtf::simd::store((low & 0xffffffffU) | (high << 32), to + i);
      };
      put(out[0], even.c0, odd.c0);
      put(out[1], even.c1, odd.c1);
      put(out[2], even.c2, odd.c2);
      put(out[3], even.c3, odd.c3);
    }
  }
};

}  // namespace

void philox_lanes(const RandomRow& row, std::uint32_t half_column, Words& out) {
  mtf::simd::run<PhiloxLanes>(&row, half_column, out.w);
}

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

}  // namespace radiometry
