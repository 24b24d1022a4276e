// SPDX-License-Identifier: Apache-2.0
#include "radiometry/performance/rounding_noise.h"

#include <cmath>

#include "radiometry/performance/implicit_root.h"

namespace radiometry {

RoundingNoise rounding_noise(double noise_steps) {
  constexpr double kPi = mtf::kPi, kWhole = 1.0 / 12.0;
  const double s = noise_steps;
  if (s < 0.05) {  // one edge between steps is in reach; what others add is below 1e-40
    const double added = s / std::sqrt(kPi) - s * s, slope = 1.0 / std::sqrt(kPi) - 2.0 * s;
    return {{added, slope}, {kWhole - added, -slope}, 0.0};
  }
  double fixed = 0.0, slope = 0.0, response = 1.0;
  for (int k = 1; k <= 20; ++k) {
    const double part = std::exp(-2.0 * kPi * kPi * k * k * s * s);
    fixed += part * part / (2.0 * kPi * kPi * k * k);
    slope -= 4.0 * s * part * part;
    response += k % 2 == 0 ? 2.0 * part : -2.0 * part;
  }
  return {{kWhole - fixed, -slope}, {fixed, slope}, std::max(0.0, response)};
}

mtf::ValueSlope noise_before_rounding(double temporal_steps2) {
  const auto surplus = [&](double s) { return s * s + rounding_noise(s).temporal.value - temporal_steps2; };
  const double most = std::sqrt(temporal_steps2), s = find_root(surplus, 0.0, most, -temporal_steps2, surplus(most));
  return {s, 1.0 / (2.0 * s + rounding_noise(s).temporal.slope)};
}

}  // namespace radiometry
