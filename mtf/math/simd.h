// SPDX-License-Identifier: Apache-2.0
#pragma once

// Loops over lanes, written once in vectors of a width that is a template parameter and run in the widest that the
// machine has: one binary for any x86-64. (target_clones, mtf/math/clones.h, do not reach templates, and leave
// vectors wider than the machine's in memory.)
//
// A kernel is a struct with `template <int Bytes> static void run(arguments)` that inlines all it calls:
//   simd::run<Kernel>(arguments);

#include <cstdint>

#define MTFKIT_INLINE inline __attribute__((always_inline))

#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(MTFKIT_NO_CLONES)
#define MTFKIT_TARGET(name) __attribute__((target(name)))
#else
#define MTFKIT_TARGET(name)
#endif

// Vectors are passed to inlined functions only: no calling convention is at stake.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace mtf::simd {

template <class S, int Bytes>
struct VectorOf {
  using Type __attribute__((vector_size(Bytes), may_alias)) = S;
};
template <class S, int Bytes>
using Vector = typename VectorOf<S, Bytes>::Type;

/// From and to any place.
template <class V, class S>
MTFKIT_INLINE V load(const S* from) {
  V v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
template <class V, class S>
MTFKIT_INLINE void store(const V& v, S* to) {
  __builtin_memcpy(to, &v, sizeof v);
}

/// The bits of 16 floats at any place, to be compared: 0 and -0 differ, a NaN equals itself.
using Bits = std::uint32_t __attribute__((vector_size(64), aligned(4), may_alias));
inline constexpr std::int64_t kBits = 16;

MTFKIT_INLINE const Bits& bits(const float* p) { return *reinterpret_cast<const Bits*>(p); }
MTFKIT_INLINE Bits bits_of(float value) { return Bits{} + __builtin_bit_cast(std::uint32_t, value); }

MTFKIT_INLINE bool any_bit(const Bits& v) {
  std::uint64_t parts[sizeof(Bits) / sizeof(std::uint64_t)];
  __builtin_memcpy(parts, &v, sizeof(Bits));
  return ((parts[0] | parts[1]) | (parts[2] | parts[3]) | ((parts[4] | parts[5]) | (parts[6] | parts[7]))) != 0;
}

/// Complex numbers side by side, real and imaginary parts in a vector each.
template <class S, int Bytes>
struct Packet {
  static constexpr int size = Bytes / static_cast<int>(sizeof(S));
  Vector<S, Bytes> re, im;

  static MTFKIT_INLINE Packet load(const S* re, const S* im) {
    return {*reinterpret_cast<const Vector<S, Bytes>*>(re), *reinterpret_cast<const Vector<S, Bytes>*>(im)};
  }
  MTFKIT_INLINE void store(S* to_re, S* to_im) const {
    *reinterpret_cast<Vector<S, Bytes>*>(to_re) = re;
    *reinterpret_cast<Vector<S, Bytes>*>(to_im) = im;
  }
  friend MTFKIT_INLINE Packet operator+(const Packet& a, const Packet& b) { return {a.re + b.re, a.im + b.im}; }
  friend MTFKIT_INLINE Packet operator-(const Packet& a, const Packet& b) { return {a.re - b.re, a.im - b.im}; }
  friend MTFKIT_INLINE Packet operator*(const Packet& a, S factor) { return {a.re * factor, a.im * factor}; }
  /// times c + i s
  MTFKIT_INLINE Packet turned(S c, S s) const { return {re * c - im * s, re * s + im * c}; }
};

/// a + i b and a - i b
template <class S, int Bytes>
MTFKIT_INLINE Packet<S, Bytes> plus_i(const Packet<S, Bytes>& a, const Packet<S, Bytes>& b) {
  return {a.re - b.im, a.im + b.re};
}
template <class S, int Bytes>
MTFKIT_INLINE Packet<S, Bytes> minus_i(const Packet<S, Bytes>& a, const Packet<S, Bytes>& b) {
  return {a.re + b.im, a.im - b.re};
}

enum class Width { any, avx2, avx512 };

inline const Width kWidth = [] {
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(MTFKIT_NO_CLONES)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f")) return Width::avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return Width::avx2;
#endif
  return Width::any;
}();

template <class Kernel, class... A>
MTFKIT_TARGET("avx512f")
void run_avx512(A... a) {
  Kernel::template run<64>(a...);
}
template <class Kernel, class... A>
MTFKIT_TARGET("avx2,fma")
void run_avx2(A... a) {
  Kernel::template run<32>(a...);
}
template <class Kernel, class... A>
void run_any(A... a) {
  Kernel::template run<16>(a...);
}

template <class Kernel, class... A>
void run(A... a) {
  switch (kWidth) {
    case Width::avx512:
      return run_avx512<Kernel>(a...);
    case Width::avx2:
      return run_avx2<Kernel>(a...);
    case Width::any:
      return run_any<Kernel>(a...);
  }
}

}  // namespace mtf::simd
