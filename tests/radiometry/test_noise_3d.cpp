// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "radiometry/stages/noise/noise_3d.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"

namespace radiometry {
namespace {

using test::flat;

constexpr std::array kComponents{&Noise3d::t,  &Noise3d::v,  &Noise3d::h,  &Noise3d::tv,
                                 &Noise3d::th, &Noise3d::vh, &Noise3d::tvh};

Noise3d mean_variances(const Noise3d& noise, int cubes, std::uint32_t frames, std::int64_t width, std::int64_t height) {
  Noise3d mean;
  for (int cube = 0; cube < cubes; ++cube) {
    Noise3dEstimator estimator(width, height);
    for (std::uint32_t frame = 0; frame < frames; ++frame) {
      mtf::Image image = flat(width, height, 1e4F);
      add_noise_3d(image.view(), noise, {static_cast<std::uint64_t>(cube) + 1, frame});
      estimator.add(image.view());
    }
    const Noise3d one = estimator.variances();
    for (const auto component : kComponents) mean.*component += one.*component / cubes;
  }
  return mean;
}

// Many small cubes: the average of the variances has no bias, although a cube of 6 x 8 x 10 hardly tells them apart.
TEST(Noise3d, components_come_back_within_one_percent) {
  const Noise3d put_in{.t = 5.0, .v = 8.0, .h = 7.0, .tv = 6.0, .th = 4.0, .vh = 9.0, .tvh = 10.0};
  const Noise3d got = mean_variances(put_in, 6000, 6, 10, 8);
  for (const auto component : kComponents)
    EXPECT_NEAR(std::sqrt(got.*component), put_in.*component, 0.01 * put_in.*component);
}

// Each component alone: the estimates of the others are 0 within their scatter.
TEST(Noise3d, one_component_at_a_time) {
  for (const auto component : kComponents) {
    Noise3d put_in;
    put_in.*component = 10.0;
    const Noise3d got = mean_variances(put_in, 1500, 6, 10, 8);
    for (const auto other : kComponents) {
      const double expected = other == component ? 100.0 : 0.0;
      EXPECT_NEAR(got.*other, expected, 4.0) << (other == component);
    }
  }
}

TEST(Noise3d, one_large_cube) {
  const Noise3d put_in{.t = 2.0, .v = 3.0, .h = 3.0, .tv = 2.0, .th = 2.0, .vh = 5.0, .tvh = 8.0};
  Noise3dEstimator estimator(320, 256);
  for (std::uint32_t frame = 0; frame < 40; ++frame) {
    mtf::Image image = flat(320, 256, 2e4F);
    add_noise_3d(image.view(), put_in, {3, frame});
    estimator.add(image.view());
  }
  const Noise3d got = estimator.estimate();
  // 81 919 and 3.2 million degrees of freedom: within 4.5 sigmas; the lines have few.
  EXPECT_NEAR(got.tvh, 8.0, 0.02);
  EXPECT_NEAR(got.vh, 5.0, 0.06);
  EXPECT_NEAR(got.tv, 2.0, 0.08);
  EXPECT_NEAR(got.th, 2.0, 0.08);
  EXPECT_NEAR(got.v, 3.0, 4.5 * 3.0 / std::sqrt(512.0));
  EXPECT_NEAR(got.h, 3.0, 4.5 * 3.0 / std::sqrt(640.0));
  EXPECT_NEAR(got.t, 2.0, 4.5 * 2.0 / std::sqrt(80.0));
  EXPECT_NEAR(put_in.total(), std::sqrt(4 + 9 + 9 + 4 + 4 + 25 + 64.0), 1e-12);
}

TEST(Noise3d, fixed_parts_stay_temporal_ones_change) {
  const auto frame_of = [](const Noise3d& noise, std::uint32_t frame) {
    mtf::Image image = flat(40, 30, 0.0F);
    add_noise_3d(image.view(), noise, {7, frame});
    return image;
  };
  for (const auto component : kComponents) {
    Noise3d noise;
    noise.*component = 1.0;
    const mtf::Image a = frame_of(noise, 0), b = frame_of(noise, 1);
    const bool fixed = component == &Noise3d::v || component == &Noise3d::h || component == &Noise3d::vh;
    EXPECT_EQ(std::equal(a.data(), a.data() + a.size(), b.data()), fixed);
  }
}

TEST(Noise3d, refusals) {
  expect_refused({"1 x 5"}, [] { Noise3dEstimator(1, 5); });
  expect_refused({"0 frames"}, [] { Noise3dEstimator(4, 5).variances(); });
  Noise3dEstimator estimator(4, 3);
  mtf::Image image = flat(3, 4, 0.0F), bad = flat(4, 3, std::nanf(""));
  expect_refused({"3 x 4", "4 x 3"}, [&] { estimator.add(image.view()); });
  expect_refused({"frame 0", "NaN"}, [&] { estimator.add(bad.view()); });
  expect_refused({"noise.tv = -1"}, [&] { add_noise_3d(image.view(), {.tv = -1.0}, {}); });
}

}  // namespace
}  // namespace radiometry
