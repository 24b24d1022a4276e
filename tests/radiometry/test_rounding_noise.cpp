// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/performance/sensitivity.h"

namespace radiometry {
namespace {

/// The other route: for each signal m the share of every count from the distribution function of the noise.
struct Moments {
  double mean = 0.0, variance = 0.0;
};
Moments rounded(double m, double s) {
  const auto below = [&](double edge) { return 0.5 * std::erfc((m - edge) / (s * std::sqrt(2.0))); };
  const int reach = 2 + static_cast<int>(std::ceil(10.0 * s));
  Moments moments;
  double square = 0.0;
  for (int count = -reach; count <= reach; ++count) {
    const double share = below(count + 0.5) - below(count - 0.5);
    moments.mean += share * count;
    square += share * count * count;
  }
  moments.variance = square - moments.mean * moments.mean;
  return moments;
}

// The mean over m by the midpoint rule, whose error on a periodic function is that of its 4000th harmonic: nothing but
// for the smallest s, where the edge is s wide and still has 40 points.
TEST(RoundingNoise, is_that_of_the_distribution_of_counts) {
  for (const double s : {0.01, 0.049, 0.051, 0.1, 0.2, 0.3, 0.4, 0.7, 1.5}) {
    constexpr int kPlaces = 4000;
    double variance = 0.0, bias2 = 0.0;
    for (int i = 0; i < kPlaces; ++i) {
      const double m = -0.5 + (i + 0.5) / kPlaces;
      const Moments counts = rounded(m, s);
      variance += counts.variance / kPlaces;
      bias2 += (counts.mean - m) * (counts.mean - m) / kPlaces;
    }
    const RoundingNoise noise = rounding_noise(s);
    EXPECT_NEAR(s * s + noise.temporal.value, variance, 3e-9) << s;
    EXPECT_NEAR(noise.fixed.value, bias2, 1e-7) << s;  // its sawtooth has corners
    EXPECT_NEAR(noise.response, (rounded(1e-4, s).mean - rounded(-1e-4, s).mean) / 2e-4, 2e-6) << s;
    const double step = 1e-5;
    EXPECT_NEAR(noise.temporal.slope,
                (rounding_noise(s + step).temporal.value - rounding_noise(s - step).temporal.value) / (2.0 * step),
                1e-8)
        << s;
    EXPECT_NEAR(noise_before_rounding(s * s + noise.temporal.value).value, s, 1e-14) << s;
  }
  EXPECT_EQ(rounding_noise(0.0).temporal.value, 0.0);
  EXPECT_NEAR(rounding_noise(0.0).fixed.value, 1.0 / 12.0, 1e-17);
  EXPECT_NEAR(rounding_noise(3.0).temporal.value, 1.0 / 12.0, 1e-17);  // Sheppard
  EXPECT_EQ(noise_before_rounding(0.0).value, 0.0);
}

// Temporal and fixed parts are all of the error of rounding, whatever the noise; a coarse converter is said.
TEST(RoundingNoise, of_a_budget_is_split_into_what_changes_and_what_stays) {
  const Pixel<double> pixel{
      .width_um = 15, .height_um = 15, .quantum_efficiency = 0.7, .integration_s = 1e-3, .full_well_e = 1e7};
  for (const double step_e : {100.0, 2000.0, 50000.0}) {
    const Budget<double> b = make_budget<double>(pixel, {.scene_e = 1e6}, {.read_e = 200, .step_e = step_e}, 3e4);
    EXPECT_NEAR(b.quantisation_e * b.quantisation_e + b.rounding_e * b.rounding_e, step_e * step_e / 12.0,
                1e-12 * step_e * step_e);
    EXPECT_NEAR(b.temporal_e * b.temporal_e, 1e6 + 4e4 + b.quantisation_e * b.quantisation_e, 1e-6);
    EXPECT_EQ(b.dither.dithered(), step_e < 2500.0);
    EXPECT_EQ(words(b.dither).empty(), b.dither.dithered());
    EXPECT_NEAR(b.dither.step_k, step_e / 3e4, 1e-15);
  }
}

}  // namespace
}  // namespace radiometry
