// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "radiometry/stages/noise/noise.h"
#include "radiometry/stages/optics/veiling_glare.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"

namespace radiometry {
namespace {

using test::flat;

mtf::Image noisy(std::int64_t width, std::int64_t height) {
  mtf::Image image = flat(width, height, 1000.0F);
  add_gaussian(image.view(), 100.0, {3, 0}, Stream::read);
  return image;
}

double sum_of(const mtf::Image& image) {
  double sum = 0.0;
  for (const float value : test::samples(image)) sum += static_cast<double>(value);
  return sum;
}

// The measurement of ISO 9358: a black spot in a bright field. Its radiance relative to that of the field is the
// fraction.
TEST(VeilingGlare, black_spot_and_energy) {
  mtf::Image image = flat(200, 100, 500.0F);
  image.at(100, 50) = 0.0F;
  const double before = sum_of(image), mean = finite_mean(image.view());
  EXPECT_NEAR(mean, 500.0 * (1.0 - 1.0 / 20000), 1e-9);
  add_glare(image.view(), {.fraction = 0.03}, mean, 2);
  EXPECT_NEAR(static_cast<double>(image.at(100, 50)) / static_cast<double>(image.at(0, 0)), 0.03, 1e-5);
  EXPECT_NEAR(sum_of(image) / before, 1.0, 1e-7);
  // Light added from outside of the field.
  add_glare(image.view(), {.fraction = 0.0, .offset = 0.02}, mean);
  EXPECT_NEAR(sum_of(image) / before, 1.02, 1e-7);

  mtf::Image even = flat(7, 5, 12.5F);
  add_glare(even.view(), {.fraction = 0.4}, finite_mean(even.view()));
  for (const float value : test::samples(even)) EXPECT_FLOAT_EQ(value, 12.5F);
}

TEST(VeilingGlare, regions_and_pixels_that_are_not_finite) {
  mtf::Image image = noisy(60, 40);
  image.at(5, 5) = std::nanf("");
  const double mean = finite_mean(image.view());
  EXPECT_NEAR(mean, 1000.0, 10.0);
  mtf::Image part(10, 10);
  for (std::int64_t y = 0; y < 10; ++y)
    for (std::int64_t x = 0; x < 10; ++x) part.at(x, y) = image.at(x + 3, y + 4);
  add_glare(image.view(), {.fraction = 0.1}, mean);
  add_glare(part.view(), {.fraction = 0.1}, mean);
  EXPECT_TRUE(std::isnan(image.at(5, 5)));
  EXPECT_EQ(part.at(4, 4), image.at(7, 8));
  const mtf::Image nothing = flat(2, 2, std::nanf(""));
  EXPECT_EQ(finite_mean(nothing.view()), 0.0);
}

TEST(Ghost, is_the_image_turned_about_the_axis) {
  const mtf::Image image = noisy(31, 20);
  const mtf::Image ghosts = ghost_image(image.view(), {.fraction = 0.1}, focal_plane(31, 20, 15.0, 15.0));
  for (std::int64_t y = 0; y < 20; ++y)
    for (std::int64_t x = 0; x < 31; ++x) ASSERT_EQ(ghosts.at(x, y), image.at(30 - x, 19 - y));
  mtf::Image seen = image.clone();
  add_ghost(seen.view(), {.fraction = 0.1}, ghosts.view(), 2);
  EXPECT_NEAR(sum_of(seen) / sum_of(image), 1.0, 1e-7);
  EXPECT_FLOAT_EQ(seen.at(3, 4), 0.9F * image.at(3, 4) + 0.1F * image.at(27, 15));

  // An axis one pixel to the right and half a pixel down; what comes from outside has the mean.
  const mtf::Image shifted =
      ghost_image(image.view(), {.fraction = 0.1}, focal_plane(31, 20, 15.0, 15.0, {.x_px = 1.0, .y_px = 0.5}));
  EXPECT_EQ(shifted.at(10, 10), image.at(22, 10));
  EXPECT_FLOAT_EQ(shifted.at(0, 10), static_cast<float>(finite_mean(image.view())));
}

TEST(Ghost, out_of_focus_is_a_square) {
  mtf::Image image = flat(41, 31, 0.0F);
  image.at(20, 15) = 2500.0F;
  const mtf::Image ghosts =
      ghost_image(image.view(), {.fraction = 1.0, .width_px = 5.0}, focal_plane(41, 31, 15.0, 15.0));
  const double mean = 2500.0 / (41 * 31);
  EXPECT_NEAR(ghosts.at(20, 15), 100.0, 1e-3);
  EXPECT_NEAR(ghosts.at(22, 13), 100.0, 1e-3);
  EXPECT_NEAR(ghosts.at(23, 15), 0.0, 1e-3);
  EXPECT_NEAR(ghosts.at(0, 15), mean * 2 / 5, 1e-3);  // the two columns beyond the edge have the mean
  const mtf::Image wide =
      ghost_image(image.view(), {.fraction = 1.0, .width_px = 1e6}, focal_plane(41, 31, 15.0, 15.0));
  EXPECT_NEAR(wide.at(7, 7), mean, 1e-3);
  // A uniform image stays as it is.
  const mtf::Image even = ghost_image(flat(9, 8, 3e6F).view(), {.width_px = 7.0}, focal_plane(9, 8, 15.0, 15.0));
  for (const float value : test::samples(even)) EXPECT_FLOAT_EQ(value, 3e6F);
  mtf::Image one = flat(1, 1, std::numeric_limits<float>::infinity());
  EXPECT_EQ(ghost_image(one.view(), {}, focal_plane(1, 1, 15.0, 15.0)).at(0, 0), 0.0F);
}

TEST(StrayLight, refusals) {
  mtf::Image image = flat(4, 3, 1.0F), other = flat(3, 4, 1.0F);
  expect_refused({"veiling_glare.fraction = 1.5"}, [&] { add_glare(image.view(), {.fraction = 1.5}, 1.0); });
  expect_refused({"not finite"}, [&] { add_glare(image.view(), {.fraction = 0.5}, std::nan("")); });
  expect_refused({"ghost.width = 0.5 px"},
                 [&] { ghost_image(image.view(), {.width_px = 0.5}, focal_plane(4, 3, 1.0, 1.0)); });
  expect_refused({"image of 4 x 3", "detector of 3 x 4"},
                 [&] { ghost_image(image.view(), {}, focal_plane(3, 4, 1.0, 1.0)); });
  expect_refused({"3 x 4", "4 x 3"}, [&] { add_ghost(image.view(), {}, other.view()); });
}

}  // namespace
}  // namespace radiometry
