// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/tracing/zenith_rings.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace radiometry::scene {

double cap_share(double cos_tilt, double zenith_rad) {
  const double b = std::clamp(cos_tilt, -1.0, 1.0), sin_tilt = std::sqrt((1.0 - b) * (1.0 + b));
  const double s = std::sin(zenith_rad), c = std::cos(zenith_rad);
  if (b >= s) return b * s * s;
  if (b <= -s) return 0.0;
  const double meets = std::clamp(-(c * b) / (s * sin_tilt), -1.0, 1.0);
  const double share = 0.5 + (-std::asin(std::min(1.0, c / sin_tilt)) + b * s * s * std::acos(meets) -
                              c * std::sqrt(std::max(0.0, (s - b) * (s + b)))) /
                                 std::numbers::pi;
  return std::clamp(share, 0.0, 1.0);
}

ZenithRings::ZenithRings(int rings) {
  for (int r = 1; r <= rings; ++r) {
    zenith_rad_.push_back(0.5 * std::numbers::pi * r / rings);
    cosine_.push_back(r == rings ? 0.0 : std::cos(zenith_rad_.back()));
  }
}

int ZenithRings::zone(double up) const {
  // The horizon itself is sky.
  return static_cast<int>(std::ranges::partition_point(cosine_, [up](double c) { return c > up; }) - cosine_.begin());
}

void ZenithRings::add_shares(double cos_tilt, double weight, std::span<double> zones) const {
  double within = 0.0;
  for (std::size_t r = 0; r < cosine_.size(); ++r) {
    const double share = std::max(within, cap_share(cos_tilt, zenith_rad_[r]));
    zones[r] += weight * (share - within);
    within = share;
  }
  zones[cosine_.size()] += weight * (1.0 - within);
}

}  // namespace radiometry::scene
