// SPDX-License-Identifier: Apache-2.0
#pragma once

// Zenith rings: the sky divided at equal steps of the zenith angle, and what a tilted plane sees of them.

#include <span>
#include <vector>

namespace radiometry::scene {

/// The view factor from a small plane whose normal is tilted from the zenith (cosine of the tilt `cos_tilt`) to the
/// part of the sky within the angle `zenith_rad` of the zenith, up to a right angle; what lies behind the plane is not
/// seen. It is that of a sphere that subtends this angle (Juul, "View factors in radiation between two parallel
/// oriented cylinders and spheres", and Howell, Catalog of Radiation Heat Transfer Configuration Factors, B-17):
///   cos(b) sin^2(t)                                                                              b <= pi/2 - t
///   1/2 - asin(cos t / sin b) / pi
///     + [cos(b) sin^2(t) acos(-cot t cot b) - cos(t) sqrt(sin^2 t - cos^2 b)] / pi               between
///   0                                                                                            b >= pi/2 + t
double cap_share(double cos_tilt, double zenith_rad);

/// The rings of a table: 90 deg / rings wide each.
class ZenithRings {
 public:
  explicit ZenithRings(int rings);
  int rings() const { return static_cast<int>(cosine_.size()); }
  /// The zone of a direction of length 1 with this upward component: its ring, or rings() for below the horizon.
  int zone(double up) const;
  /// View factors from a plane to the zones, rings first, then the ground; they sum to 1. Times `weight` onto `zones`.
  void add_shares(double cos_tilt, double weight, std::span<double> zones) const;

 private:
  std::vector<double> zenith_rad_, cosine_;  // outer limit of each ring
};

}  // namespace radiometry::scene
