// SPDX-License-Identifier: Apache-2.0
#include <bit>

#include "mtf/math/simd.h"
#include "radiometry/stages/noise/lane_words.h"

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

}  // namespace radiometry
