// SPDX-License-Identifier: Apache-2.0

// What a tilted plane sees of the rings of the sky, against an integral over solid angle.

#include "radiometry/scene/views.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

namespace radiometry::scene {
namespace {

constexpr double kPi = std::numbers::pi;

/// Midpoint rule in azimuth and zenith angle, 4e6 points.
double cap_by_integral(double tilt, double zenith) {
  constexpr int n = 2000;
  double sum = 0.0;
  for (int i = 0; i < n; ++i) {
    const double z = zenith * (i + 0.5) / n;
    for (int j = 0; j < n; ++j) {
      const double a = kPi * (j + 0.5) / n;  // half of the azimuths, by symmetry
      sum += std::sin(z) * std::max(0.0, std::sin(tilt) * std::sin(z) * std::cos(a) + std::cos(tilt) * std::cos(z));
    }
  }
  return 2.0 * sum * (zenith / n) * (kPi / n) / kPi;
}

TEST(ZenithRings, ShareOfACapIsItsIntegral) {
  for (const double tilt : {0.0, 10.0, 45.0, 60.0, 89.0, 90.0, 91.0, 120.0, 170.0, 180.0})
    for (const double zenith : {5.0, 30.0, 50.0, 80.0, 90.0})
      EXPECT_NEAR(cap_share(std::cos(tilt * kPi / 180), zenith * kPi / 180),
                  cap_by_integral(tilt * kPi / 180, zenith * kPi / 180), 1e-6)
          << tilt << " " << zenith;
}

TEST(ZenithRings, KnownShares) {
  EXPECT_EQ(cap_share(1.0, 0.5 * kPi), 1.0);
  EXPECT_EQ(cap_share(-1.0, 0.5 * kPi), 0.0);
  EXPECT_NEAR(cap_share(0.0, 0.5 * kPi), 0.5, 1e-15);
  EXPECT_NEAR(cap_share(0.3, 0.5 * kPi), 0.65, 1e-15);  // (1 + cos b) / 2
  EXPECT_NEAR(cap_share(1.0, kPi / 6), 0.25, 1e-15);
}

TEST(ZenithRings, SharesSumToOneAndAreNotNegative) {
  for (const int rings : {1, 9, 12, 90}) {
    const ZenithRings zones(rings);
    for (double c = -1.0; c <= 1.0; c += 0.01) {
      std::vector<double> shares(static_cast<std::size_t>(rings) + 1, 0.0);
      zones.add_shares(c, 1.0, shares);
      EXPECT_NEAR(std::accumulate(shares.begin(), shares.end(), 0.0), 1.0, 1e-14);
      EXPECT_NEAR(shares.back(), 0.5 * (1.0 - c), 1e-14);
      for (const double share : shares) EXPECT_GE(share, 0.0);
    }
  }
}

TEST(ZenithRings, ZonesOfDirections) {
  const ZenithRings zones(9);
  EXPECT_EQ(zones.zone(1.0), 0);
  EXPECT_EQ(zones.zone(std::cos(9.9 * kPi / 180)), 0);
  EXPECT_EQ(zones.zone(std::cos(10.1 * kPi / 180)), 1);
  EXPECT_EQ(zones.zone(std::cos(89.9 * kPi / 180)), 8);
  EXPECT_EQ(zones.zone(0.0), 8);
  EXPECT_EQ(zones.zone(-1e-9), 9);
  EXPECT_EQ(zones.zone(-1.0), 9);
}

}  // namespace
}  // namespace radiometry::scene
