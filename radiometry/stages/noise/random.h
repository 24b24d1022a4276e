// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random numbers by counter: each is a function of (seed, frame, stream, pixel), of nothing that came before. So any
// region, order or number of threads gives the same ones. The generator is Philox4x32-10 (Salmon, Moraes, Dror and
// Shaw, SC11, 2011), a bijection of 128 bits under a key of 64: the seed is the key; the pixel's column / 2, its row,
// the frame and the stream are the counter; a pair of pixels shares the 128 bits.

#include <array>
#include <cstdint>

namespace radiometry {

using Bits128 = std::array<std::uint32_t, 4>;

/// One block of Philox4x32-10; the key's low half is the first word.
inline Bits128 philox(Bits128 counter, std::uint64_t key) {
  auto k0 = static_cast<std::uint32_t>(key), k1 = static_cast<std::uint32_t>(key >> 32);
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = std::uint64_t{0xD2511F53} * counter[0], p1 = std::uint64_t{0xCD9E8D57} * counter[2];
    counter = {static_cast<std::uint32_t>(p1 >> 32) ^ counter[1] ^ k0, static_cast<std::uint32_t>(p1),
               static_cast<std::uint32_t>(p0 >> 32) ^ counter[3] ^ k1, static_cast<std::uint32_t>(p0)};
    k0 += 0x9E3779B9;
    k1 += 0xBB67AE85;
  }
  return counter;
}

/// What random numbers are for; each purpose has its own, also where two share a frame. The values are part of the
/// meaning of a seed: they never change.
enum class Stream : std::uint32_t {
  shot = 1,
  read = 2,
  prnu = 3,
  dsnu = 4,
  defects = 5,
  temporal_row = 6,  ///< changes from frame to frame, one number a row
  temporal_column = 7,
  fixed_row = 8,  ///< the same in all frames
  fixed_column = 9,
  frame = 10,  ///< one number a frame
  temporal_pixel = 11,
  fixed_pixel = 12,
  blinking = 13,  ///< + 2^8 i: further numbers of a pixel
  flicker = 14,   ///< + 2^8 i: octave i
  cube_v = 15,    ///< of 3-D noise: fixed rows, fixed columns, temporal rows and columns
  cube_h = 16,
  cube_tv = 17,
  cube_th = 18,
  frame_flicker = 19,  ///< + 2^8 i: octave i
  dcnu = 20,
  prnu_row = 21,
  prnu_column = 22,
};

/// A seed and the number of a frame. Fixed patterns take frame 0.
struct NoiseKey {
  std::uint64_t seed = 0;
  std::uint32_t frame = 0;
};

/// The random numbers of one purpose in one row of pixels.
struct RandomRow {
  NoiseKey key;
  Stream stream = Stream::shot;
  std::uint32_t y = 0;

  Bits128 pair(std::uint32_t half_column) const {
    return philox({half_column, y, key.frame, static_cast<std::uint32_t>(stream)}, key.seed);
  }
};

/// A number between 0 and 1, uniform in steps of 2^-62, never 0 or 1, and its distance from 1: both to the full
/// precision of a double.
struct Uniform {
  double u = 0.5, rest = 0.5;
};

inline Uniform uniform(std::uint32_t high, std::uint32_t low) {
  const auto value = [](std::uint32_t a, std::uint32_t b) {
    return (static_cast<double>(a) + (static_cast<double>(b) + 0.5) * 0x1p-31) * 0x1p-31;
  };
  const std::uint32_t a = high >> 1, b = low >> 1;
  return {value(a, b), value(0x7fffffffU - a, 0x7fffffffU - b)};
}

/// The number of one pixel.
inline Uniform uniform_at(const RandomRow& row, std::uint64_t x) {
  const Bits128 bits = row.pair(static_cast<std::uint32_t>(x / 2));
  return x % 2 == 0 ? uniform(bits[0], bits[1]) : uniform(bits[2], bits[3]);
}

}  // namespace radiometry
