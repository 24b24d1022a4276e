// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/stages/noise/noise.h"
#include "radiometry/stages/optics/distortion.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"

namespace radiometry {
namespace {

using test::flat;

mtf::Image noisy(std::int64_t width, std::int64_t height) {
  mtf::Image image = flat(width, height, 0.0F);
  add_gaussian(image.view(), 1.0, {8, 0}, Stream::read);
  return image;
}

// r + k r^3 = r' has one real root for k > 0, by Cardano's hyperbolic form.
TEST(Distortion, radius_is_the_root_of_the_cubic) {
  for (const double k : {1e-9, 0.01, 0.3, 50.0}) {
    const UndistortedRadius undistorted({.k1 = k}, 2.0);
    for (const double distorted : {1e-6, 0.1, 0.7, 1.0, 2.0}) {
      const double root = 2.0 / std::sqrt(3.0 * k) * std::sinh(std::asinh(1.5 * std::sqrt(3.0 * k) * distorted) / 3.0);
      EXPECT_NEAR(undistorted.part(distorted) * distorted / root, 1.0, 1e-14) << k << " " << distorted;
    }
    EXPECT_EQ(undistorted.part(0.0), 1.0);
  }
}

TEST(Distortion, radius_and_its_inverse_agree) {
  const Distortion lenses[] = {
      {.k1 = -0.12}, {.k1 = -0.3, .k2 = 0.1}, {.k1 = 0.1, .k2 = -0.2, .k3 = 0.12}, {.k3 = -0.05}};
  for (const Distortion& lens : lenses) {
    const UndistortedRadius undistorted(lens, 1.0);
    double before = 0.0;
    for (int i = 1; i <= 1000; ++i) {
      const double distorted = i / 1000.0, r = undistorted.part(distorted) * distorted;
      EXPECT_NEAR(r * distorted_part(lens, r), distorted, 1e-14);
      EXPECT_GT(r, before);
      before = r;
    }
  }
}

// Keys' cubic reproduces quadratics, so inside the scene the result is the polynomial at the undistorted place.
TEST(Distortion, a_quadratic_scene_is_moved_exactly) {
  const FocalPlane grid = focal_plane(120, 90, 4.0, 5.0, {.x_px = 6.0, .y_px = -3.0});
  const auto value = [](double x, double y) {
    return 3.0 + 0.02 * x - 0.05 * y + 1e-4 * x * x - 2e-4 * x * y + 3e-4 * y * y;
  };
  mtf::Image scene(120, 90), out(120, 90);
  for (std::int64_t y = 0; y < 90; ++y)
    for (std::int64_t x = 0; x < 120; ++x)
      scene.at(x, y) = static_cast<float>(value(static_cast<double>(x), static_cast<double>(y)));
  const double k = 0.1;
  distort(scene.view(), {.k1 = k}, grid, out.view());
  for (std::int64_t y = 2; y < 88; ++y)
    for (std::int64_t x = 2; x < 118; ++x) {
      const double dx = static_cast<double>(x) - 65.5, dy = static_cast<double>(y) - 41.5;
      const double distorted = std::hypot(4.0 * dx, 5.0 * dy) / std::hypot(240.0, 225.0);
      const double root = 2.0 / std::sqrt(3.0 * k) * std::sinh(std::asinh(1.5 * std::sqrt(3.0 * k) * distorted) / 3.0);
      const double part = root / distorted;
      ASSERT_NEAR(out.at(x, y), value(65.5 + part * dx, 41.5 + part * dy), 2e-6) << x << " " << y;
    }
}

// A barrel draws a point of the corner inwards: from r = 0.8 to 0.8 (1 - 0.1 x 0.64) of the half diagonal.
TEST(Distortion, sense) {
  mtf::Image scene = flat(301, 301, 0.0F), out(301, 301);
  const double half = 150.5;
  const auto corner = static_cast<std::int64_t>(150 + std::lround(0.8 * half));
  scene.at(corner, corner) = 1.0F;
  distort(scene.view(), {.k1 = -0.1}, focal_plane(301, 301, 1.0, 1.0), out.view());
  double sum = 0.0, centre = 0.0;
  for (std::int64_t y = 0; y < 301; ++y)
    for (std::int64_t x = 0; x < 301; ++x) {
      sum += static_cast<double>(out.at(x, y));
      centre += static_cast<double>(out.at(x, y)) * static_cast<double>(x);
    }
  const double r = static_cast<double>(corner - 150) / half;
  EXPECT_NEAR(centre / sum - 150.0, r * (1.0 - 0.1 * r * r) * half, 0.1);
  EXPECT_LT(centre / sum, static_cast<double>(corner));
}

TEST(Distortion, radiance_is_kept_and_nothing_is_no_change) {
  const FocalPlane grid = focal_plane(64, 48, 1.0, 1.0);
  mtf::Image out(64, 48);
  distort(flat(64, 48, 7.25F).view(), {.k1 = -0.1, .k2 = 0.02}, grid, out.view());
  for (const float value : test::samples(out)) ASSERT_FLOAT_EQ(value, 7.25F);
  mtf::Image scene = noisy(64, 48);
  scene.at(9, 9) = std::nanf("");
  distort(scene.view(), {}, grid, out.view());
  for (std::int64_t i = 0; i < scene.size(); ++i) {
    if (i == 9 * 64 + 9) continue;
    ASSERT_EQ(out.data()[i], scene.data()[i]);
  }
  EXPECT_TRUE(std::isnan(out.at(9, 9)));
  mtf::Image one(1, 1);
  distort(flat(1, 1, 3.0F).view(), {.k1 = -0.1}, focal_plane(1, 1, 1.0, 1.0), one.view());
  EXPECT_EQ(one.at(0, 0), 3.0F);
}

TEST(Distortion, regions_threads_and_borders) {
  const FocalPlane grid = focal_plane(200, 150, 4.0, 4.0);
  const mtf::Image scene = noisy(200, 150);
  const Distortion barrel{.k1 = -0.1};
  mtf::Image whole(200, 150), again(200, 150), part(31, 17);
  distort(scene.view(), barrel, grid, whole.view());
  distort(scene.view(), barrel, grid, again.view(), {}, mtf::Border::reflect, 0.0F, 2);
  EXPECT_TRUE(std::equal(whole.data(), whole.data() + whole.size(), again.data()));
  distort(scene.view(), barrel, grid, part.view(), {160, 130});
  for (std::int64_t y = 0; y < 17; ++y)
    for (std::int64_t x = 0; x < 31; ++x) ASSERT_EQ(part.at(x, y), whole.at(160 + x, 130 + y));
  // The corner of a barrel sees past the scene.
  distort(scene.view(), barrel, grid, whole.view(), {}, mtf::Border::constant, -77.0F);
  EXPECT_EQ(whole.at(0, 0), -77.0F);
  EXPECT_EQ(whole.at(199, 149), -77.0F);
}

TEST(Distortion, mtf_of_the_interpolation) {
  EXPECT_EQ(distortion_mtf(0.0), 1.0);
  EXPECT_NEAR(distortion_mtf(0.125), 0.9915, 5e-5);
  double before = 1.0;
  for (int i = 1; i <= 50; ++i) {
    // Half way between two samples the taps are -1/16, 9/16, 9/16, -1/16.
    const double f = 0.01 * i, half_way = 1.125 * std::cos(mtf::kPi * f) - 0.125 * std::cos(3.0 * mtf::kPi * f);
    EXPECT_NEAR(distortion_mtf(f), half_way, 1e-12);
    EXPECT_LT(distortion_mtf(f), before);
    before = distortion_mtf(f);
  }
  EXPECT_NEAR(distortion_mtf(0.5), 0.0, 1e-12);
}

TEST(Distortion, refusals) {
  // r (1 - 0.2 r^2) turns at r = 1.29 and comes to 0.86: the corners of the image would see nothing.
  expect_refused({"k1 = -0.2", "field over at 0.86"}, [] { UndistortedRadius({.k1 = -0.2}, 1.0); });
  EXPECT_NO_THROW(UndistortedRadius({.k1 = -0.148}, 1.0));  // 4/27 is the limit
  expect_refused({"fold"}, [] { UndistortedRadius({.k1 = -0.1482}, 1.0); });
  // Falls between two rises: slope 1 - 3 s + 2 s^2 is below 0 from s = 0.5 to 1.
  expect_refused({"fold"}, [] { UndistortedRadius({.k1 = -1.0, .k2 = 0.4}, 1.0); });
  EXPECT_NO_THROW(UndistortedRadius({.k1 = -1.0, .k2 = 0.4}, 0.4));
  // r (1 - r^4 / 20) turns at r = sqrt(2) and comes to 0.8 sqrt(2) = 1.1314; r (1 - r^6 / 56) 6/7 sqrt(2) = 1.2122.
  EXPECT_NO_THROW(UndistortedRadius({.k2 = -0.05}, 1.131));
  expect_refused({"field over at 1.131"}, [] { UndistortedRadius({.k2 = -0.05}, 1.132); });
  EXPECT_NO_THROW(UndistortedRadius({.k3 = -1.0 / 56}, 1.212));
  expect_refused({"field over at 1.212"}, [] { UndistortedRadius({.k3 = -1.0 / 56}, 1.213); });
  expect_refused({"distortion.k3 = inf"}, [] { UndistortedRadius({.k3 = INFINITY}, 1.0); });
  expect_refused({"reaches nan"}, [] { UndistortedRadius({}, std::nan("")); });
  mtf::Image scene = flat(4, 3, 1.0F), out = flat(4, 3, 1.0F);
  expect_refused({"scene of 4 x 3", "grid of 8 x 6"},
                 [&] { distort(scene.view(), {}, focal_plane(8, 6, 1.0, 1.0), out.view()); });
  expect_refused({"column 2, row 0"}, [&] {
    distort(scene.view(), {}, focal_plane(4, 3, 1.0, 1.0), out.view(), {2, 0});
  });
}

}  // namespace
}  // namespace radiometry
