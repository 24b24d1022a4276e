// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "radiometry/raw_counts.h"
#include "tests/radiometry/expect_refused.h"
#include "tests/radiometry/frames.h"

namespace radiometry {
namespace {

using test::expect_refused;

// Constants of a handheld camera, a FLIR E60.
const CountCamera kCamera{
    .r1 = 14985.9296875, .b_k = 1398.09997558594, .f = 1.0, .o = -6233.0, .r2 = 0.0112832169979811};

TEST(RawCounts, there_and_back) {
  for (const double t : {200.0, 250.0, 293.15, 300.0, 400.0, 1500.0, 1e6})
    EXPECT_NEAR(kCamera.temperature_k(kCamera.count(t)), t, 1e-11 * t) << t;
  EXPECT_TRUE(std::isnan(kCamera.temperature_k(6233.0)));
  EXPECT_TRUE(std::isnan(kCamera.temperature_k(0.0)));
}

TEST(RawCounts, reflection_is_taken_off) {
  // A surface at 310 K of emissivity 0.8 before surroundings at 280 K.
  const double signal = 0.8 * kCamera.count(310.0) + 0.2 * kCamera.count(280.0);
  mtf::Image plane = test::flat(3, 2, static_cast<float>(signal));
  temperature_of_counts(plane.view(), kCamera, {.emissivity = 0.8, .reflected_k = 280.0});
  for (const float t : test::samples(plane)) EXPECT_NEAR(t, 310.0F, 1e-3F);  // half a count of float
}

TEST(RawCounts, counts_without_a_temperature) {
  mtf::Image plane = test::flat(5, 4, 15000.0F);
  plane.at(4, 1) = std::nanf("");
  mtf::Image good = plane.clone();
  temperature_of_counts(good.view(), kCamera);
  EXPECT_TRUE(std::isnan(good.at(4, 1)));
  EXPECT_NEAR(static_cast<double>(good.at(0, 0)), kCamera.temperature_k(15000.0), 2e-5);
  for (const float bad : {6233.0F, 0.0F, -1e30F, std::numeric_limits<float>::infinity()}) {
    plane.at(3, 2) = bad;
    plane.at(0, 3) = bad;
    expect_refused({"counts", "2 pixels", "column 3, row 2"},
                   [&] { temperature_of_counts(plane.view(), kCamera, {}, 2); });
    EXPECT_EQ(plane.at(0, 0), 15000.0F);
  }
  CountCamera low = kCamera;
  low.f = 0.5;  // no temperature above R1 / (R2 (1 - F)) - O
  plane = test::flat(2, 2, 1e9F);
  expect_refused({"4 pixels", "column 0, row 0"}, [&] { temperature_of_counts(plane.view(), low); });
}

TEST(RawCounts, refusals) {
  mtf::Image plane = test::flat(2, 2, 15000.0F);
  const auto with = [&](const Reflection& reflection) { temperature_of_counts(plane.view(), kCamera, reflection); };
  expect_refused({"emissivity of 0;"}, [&] { with({.emissivity = 0.0}); });
  expect_refused({"emissivity of 1.1"}, [&] { with({.emissivity = 1.1}); });
  expect_refused({"emissivity of nan"}, [&] { with({.emissivity = std::nan("")}); });
  expect_refused({"-3 K"}, [&] { with({.emissivity = 0.9, .reflected_k = -3.0}); });
  expect_refused({"nan K"}, [&] { with({.emissivity = 0.9, .reflected_k = std::nan("")}); });
  with({.emissivity = 0.9, .reflected_k = 0.0});
  expect_refused({"counts.R1", "counts.B"}, [&] { temperature_of_counts(plane.view(), CountCamera{}); });
}

}  // namespace
}  // namespace radiometry
