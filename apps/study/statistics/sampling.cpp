// SPDX-License-Identifier: Apache-2.0
#include "apps/study/statistics/sampling.h"

#include <algorithm>
#include <bit>
#include <boost/random/sobol.hpp>

#include "radiometry/stages/noise/random.h"

namespace study {

std::uint64_t permuted(std::uint64_t i, std::uint64_t n, std::uint32_t axis, std::uint64_t seed) {
  constexpr std::uint32_t rounds = 6;
  if (n < 2) return i;
  const int bits = static_cast<int>(std::bit_width(n - 1)), low_bits = (bits + 1) / 2, high_bits = bits - low_bits;
  const std::uint64_t low_mask = (std::uint64_t{1} << low_bits) - 1, high_mask = (std::uint64_t{1} << high_bits) - 1;
  do {
    std::uint64_t low = i & low_mask, high = i >> low_bits;
    for (std::uint32_t round = 0; round < rounds; ++round) {
      std::uint64_t& changed = round % 2 == 0 ? low : high;
      const std::uint64_t kept = round % 2 == 0 ? high : low, mask = round % 2 == 0 ? low_mask : high_mask;
      // The halves have at most 32 bits: the counter holds one whole.
      const auto random = radiometry::philox(
          {static_cast<std::uint32_t>(kept), round, axis, static_cast<std::uint32_t>(Purpose::permutation)}, seed);
      changed ^= random[0] & mask;
    }
    i = high << low_bits | low;
  } while (i >= n);
  return i;
}

double latin_hypercube(std::uint64_t i, std::uint64_t n, std::uint32_t axis, std::uint64_t seed) {
  const std::uint64_t stratum = permuted(i, n, axis, seed);
  const auto random = radiometry::philox({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i >> 32), axis,
                                          static_cast<std::uint32_t>(Purpose::stratum)},
                                         seed);
  const double within = radiometry::uniform(random[0], random[1]).u;
  // Rounding could reach the next stratum.
  const double scale = static_cast<double>(n), next = (static_cast<double>(stratum) + 1.0) / scale;
  return std::min((static_cast<double>(stratum) + within) / scale, next * (1.0 - 0x1p-53));
}

std::vector<SobolAxis> sobol_axes(std::size_t axes) {
  std::vector<SobolAxis> directions(axes);
  if (axes == 0) return directions;
  using SobolEngine = boost::random::sobol_engine<std::uint_least32_t, 32, boost::random::default_sobol_table>;
  SobolEngine engine(axes);
  for (std::size_t bit = 0; bit < std::tuple_size_v<SobolAxis>; ++bit) {
    // Point 2^(bit + 1) - 1 has the Gray code 2^bit: it is the direction number itself. Boost leaves out point 0.
    engine.seed((std::uint32_t{2} << bit) - 2);
    for (SobolAxis& axis : directions) axis[bit] = engine();
  }
  return directions;
}

std::uint32_t sobol_bits(const SobolAxis& axis, std::uint64_t i) {
  std::uint32_t bits = 0;
  std::uint64_t gray = i ^ i >> 1;
  for (std::size_t bit = 0; gray != 0 && bit < axis.size(); ++bit, gray >>= 1)
    if ((gray & 1) != 0) bits ^= axis[bit];
  return bits;
}

double sobol(const SobolAxis& directions, std::uint64_t i, std::uint32_t axis, std::uint64_t seed) {
  const std::uint32_t shift =
      radiometry::philox({0, 0, axis, static_cast<std::uint32_t>(Purpose::sobol_shift)}, seed)[0];
  return (static_cast<double>(sobol_bits(directions, i) ^ shift) + 0.5) * 0x1p-32;
}

}  // namespace study
