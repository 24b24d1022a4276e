// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/fft/lane_kernels.h"

#include <utility>

#include "mtf/math/simd.h"

namespace mtf::lanes {
namespace {

template <class S, int Bytes>
MTFKIT_INLINE simd::Packet<S, Bytes> row_at(const S* p, std::int64_t row, int lane) {
  return simd::Packet<S, Bytes>::load(p + row * kRow + lane, p + row * kRow + kLanes + lane);
}

template <class S, int Bytes>
MTFKIT_INLINE void put(const simd::Packet<S, Bytes>& v, S* p, std::int64_t row, int lane) {
  v.store(p + row * kRow + lane, p + row * kRow + kLanes + lane);
}

template <class S, Source source, Factor factor>
struct ScatterAdd {
  template <int Bytes>
  static MTFKIT_INLINE void run(const FoldTerm<S>* terms, std::int64_t count, const S* from, const S* otf, S* target) {
    using P = simd::Packet<S, Bytes>;
    for (std::int64_t i = 0; i < count; ++i) {
      const FoldTerm<S> term = terms[i];
      for (int lane = 0; lane < kLanes; lane += P::size) {
        P v = row_at<S, Bytes>(from, term.up, lane);
        if constexpr (source != Source::plain) {
          const P w = row_at<S, Bytes>(from, term.down, lane);
          if constexpr (source == Source::cosine)  // Re(t) (u + d) / 2 + i Im(t) (u - d) / 2
            v = simd::plus_i((v + w) * term.cos, (v - w) * term.sin);
          else
            v = {v.re - w.im * term.sin, v.im * term.sin + w.re};
        }
        if constexpr (factor != Factor::none) {
          const P h = row_at<S, Bytes>(otf, term.otf, lane);
          if constexpr (factor == Factor::real)
            v = {v.re * h.re, v.im * h.im};
          else
            v = {v.re * h.re - v.im * h.im, v.re * h.im + v.im * h.re};
        }
        v = term.im == S(0) ? v * term.re : v.turned(term.re, term.im);
        if (!term.first) v = v + row_at<S, Bytes>(target, term.target, lane);
        put<S, Bytes>(v, target, term.target, lane);
      }
    }
  }
};

template <class S>
struct Separate {
  template <int Bytes>
  static MTFKIT_INLINE void run(const FoldTerm<S>* terms, std::int64_t count, const S* from, S* to) {
    using P = simd::Packet<S, Bytes>;
    for (std::int64_t k = 0; k < count; ++k)
      for (int lane = 0; lane < kLanes; lane += P::size) {
        const P u = row_at<S, Bytes>(from, terms[k].up, lane), d = row_at<S, Bytes>(from, terms[k].down, lane);
        const P a{u.re + d.re, u.im - d.im}, b{u.im + d.im, d.re - u.re};
        put<S, Bytes>(a * S(0.5), to, 2 * k, lane);
        put<S, Bytes>(b * S(0.5), to, 2 * k + 1, lane);
      }
  }
};

template <class S>
struct UnfoldCosine {
  template <int Bytes>
  static MTFKIT_INLINE void run(const S* from, const S* twiddles, const std::int32_t* place, std::int64_t n, S* to) {
    using P = simd::Packet<S, Bytes>;
    for (int lane = 0; lane < kLanes; lane += P::size)
      put<S, Bytes>(row_at<S, Bytes>(from, 0, lane), to, place[0], lane);
    for (std::int64_t k = 1; k < n; ++k)
      for (int lane = 0; lane < kLanes; lane += P::size) {
        const P v = simd::minus_i(row_at<S, Bytes>(from, k, lane), row_at<S, Bytes>(from, n - k, lane));
        put<S, Bytes>(v.turned(twiddles[2 * k], -twiddles[2 * k + 1]), to, place[k], lane);
      }
  }
};

template <class S>
struct MultiplyRows {
  template <int Bytes>
  static MTFKIT_INLINE void run(S* data, const S* factors, std::int64_t rows) {
    using P = simd::Packet<S, Bytes>;
    for (std::int64_t r = 0; r < rows; ++r)
      for (int lane = 0; lane < kLanes; lane += P::size)
        put<S, Bytes>(row_at<S, Bytes>(data, r, lane).turned(factors[2 * r], factors[2 * r + 1]), data, r, lane);
  }
};

// a0 b0 a1 b1 ... of the lower or upper halves
template <bool upper, class V, int... i>
MTFKIT_INLINE V zip(const V& a, const V& b, std::integer_sequence<int, i...>) {
  constexpr int n = sizeof...(i);
  return __builtin_shufflevector(a, b, ((i % 2) * n + i / 2 + (upper ? n / 2 : 0))...);
}

// A square of vectors: every round of zipping moves one bit of the row number into the column number.
template <class S, int Bytes>
struct Square {
  static constexpr int n = Bytes / static_cast<int>(sizeof(S));
  simd::Vector<S, Bytes> v[n];

  MTFKIT_INLINE void transpose() {
    constexpr auto lanes = std::make_integer_sequence<int, n>{};
#pragma GCC unroll 4
    for (int bit = 1; bit < n; bit *= 2) {
      const Square old = *this;
#pragma GCC unroll 8
      for (int i = 0; i < n / 2; ++i) {
        v[2 * i] = zip<false>(old.v[i], old.v[i + n / 2], lanes);
        v[2 * i + 1] = zip<true>(old.v[i], old.v[i + n / 2], lanes);
      }
    }
  }
  MTFKIT_INLINE void load(int i, const S* p) { v[i] = *reinterpret_cast<const simd::Vector<S, Bytes>*>(p); }
  MTFKIT_INLINE void store(int i, S* p) const { *reinterpret_cast<simd::Vector<S, Bytes>*>(p) = v[i]; }
};

template <class S>
struct Transpose {
  template <int Bytes>
  static MTFKIT_INLINE void run(const S* from, std::int64_t from_stride, S* to, std::int64_t to_stride) {
    using Q = Square<S, Bytes>;
    for (int row = 0; row < kLanes; row += Q::n)
      for (int column = 0; column < kLanes; column += Q::n) {
        Q q;
#pragma GCC unroll 16
        for (int i = 0; i < Q::n; ++i) q.load(i, from + (row + i) * from_stride + column);
        q.transpose();
#pragma GCC unroll 16
        for (int i = 0; i < Q::n; ++i) q.store(i, to + (column + i) * to_stride + row);
      }
  }
};

template <class S>
struct LinesToLanes {
  template <int Bytes>
  static MTFKIT_INLINE void run(const S* lines, std::int64_t stride, std::int64_t count, S* data) {
    using Q = Square<S, Bytes>;
    for (std::int64_t first = 0; first < count; first += Q::n)
      for (int line = 0; line < kRow; line += Q::n) {
        Q q;
#pragma GCC unroll 16
        for (int i = 0; i < Q::n; ++i) q.load(i, lines + (line + i) * stride + first);
        q.transpose();
        for (int i = 0; i < Q::n && first + i < count; ++i) q.store(i, data + (first + i) * kRow + line);
      }
  }
};

template <class S>
struct LanesToLines {
  template <int Bytes>
  static MTFKIT_INLINE void run(const S* data, const std::int32_t* rows, std::int64_t count, S* lines,
                                std::int64_t stride) {
    using Q = Square<S, Bytes>;
    for (std::int64_t first = 0; first < count; first += Q::n)
      for (int line = 0; line < kRow; line += Q::n) {
        Q q;
#pragma GCC unroll 16
        for (int i = 0; i < Q::n; ++i) {
          const std::int64_t at = first + i < count ? first + i : count - 1;
          q.load(i, data + rows[at] * std::int64_t{kRow} + line);
        }
        q.transpose();
#pragma GCC unroll 16
        for (int i = 0; i < Q::n; ++i) q.store(i, lines + (line + i) * stride + first);
      }
  }
};

template <class S, Source source>
void scatter_add_with(Factor factor, std::span<const FoldTerm<S>> terms, const S* from, const S* otf, S* target) {
  const auto count = static_cast<std::int64_t>(terms.size());
  if (factor == Factor::none)
    return simd::run<ScatterAdd<S, source, Factor::none>>(terms.data(), count, from, otf, target);
  if (factor == Factor::real)
    return simd::run<ScatterAdd<S, source, Factor::real>>(terms.data(), count, from, otf, target);
  simd::run<ScatterAdd<S, source, Factor::complex>>(terms.data(), count, from, otf, target);
}

}  // namespace

template <class S>
void scatter_add(Source source, Factor factor, std::span<const FoldTerm<S>> terms, const S* from, const S* otf,
                 S* target) {
  if (source == Source::plain) return scatter_add_with<S, Source::plain>(factor, terms, from, otf, target);
  if (source == Source::cosine) return scatter_add_with<S, Source::cosine>(factor, terms, from, otf, target);
  scatter_add_with<S, Source::pairs>(factor, terms, from, otf, target);
}

template <class S>
void separate(std::span<const FoldTerm<S>> terms, const S* from, S* to) {
  simd::run<Separate<S>>(terms.data(), static_cast<std::int64_t>(terms.size()), from, to);
}

template <class S>
void unfold_cosine(const S* coefficients, const S* twiddles, std::span<const std::int32_t> place, S* to) {
  simd::run<UnfoldCosine<S>>(coefficients, twiddles, place.data(), static_cast<std::int64_t>(place.size()), to);
}

template <class S>
void multiply_rows(S* data, const S* factors, std::int64_t rows) {
  simd::run<MultiplyRows<S>>(data, factors, rows);
}

template <class S>
void transpose(const S* from, std::int64_t from_stride, S* to, std::int64_t to_stride) {
  simd::run<Transpose<S>>(from, from_stride, to, to_stride);
}

template <class S>
void lines_to_lanes(const S* lines, std::int64_t stride, std::int64_t count, S* data) {
  simd::run<LinesToLanes<S>>(lines, stride, count, data);
}

template <class S>
void lanes_to_lines(const S* data, std::span<const std::int32_t> rows, S* lines, std::int64_t stride) {
  simd::run<LanesToLines<S>>(data, rows.data(), static_cast<std::int64_t>(rows.size()), lines, stride);
}

#define MTFKIT_INSTANTIATE(S)                                                                         \
  template void scatter_add<S>(Source, Factor, std::span<const FoldTerm<S>>, const S*, const S*, S*); \
  template void separate<S>(std::span<const FoldTerm<S>>, const S*, S*);                              \
  template void unfold_cosine<S>(const S*, const S*, std::span<const std::int32_t>, S*);              \
  template void multiply_rows<S>(S*, const S*, std::int64_t);                                         \
  template void transpose<S>(const S*, std::int64_t, S*, std::int64_t);                               \
  template void lines_to_lanes<S>(const S*, std::int64_t, std::int64_t, S*);                          \
  template void lanes_to_lines<S>(const S*, std::span<const std::int32_t>, S*, std::int64_t);
MTFKIT_INSTANTIATE(float)
MTFKIT_INSTANTIATE(double)
#undef MTFKIT_INSTANTIATE

}  // namespace mtf::lanes
