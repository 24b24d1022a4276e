// SPDX-License-Identifier: Apache-2.0
#pragma once

// The bodies of the radix steps. They are the longest functions of the library, 81 of each precision (nine radices,
// three passes, three widths of vectors) and unrolled whole: every precision is compiled in a source of its own.

#include <cassert>
#include <cstdint>

#include "mtf/engines/fft/butterfly.h"
#include "mtf/engines/fft/lane_steps.h"
#include "mtf/math/simd.h"

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
