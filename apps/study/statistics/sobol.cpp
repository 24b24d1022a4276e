// SPDX-License-Identifier: Apache-2.0
#include <boost/random/sobol.hpp>

#include "apps/study/statistics/sampling.h"
#include "radiometry/stages/noise/random.h"

namespace study {

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
