// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/stages/noise/fixed_pattern.h"
#include "radiometry/stages/processing/correction.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"
#include "tests/radiometry/statistics.h"

namespace radiometry {
namespace {

using test::flat;
using test::samples;

/// A flat scene seen by pixels of unlike response and offset; two of them defective.
mtf::Image seen(float electrons) {
  mtf::Image image = flat(160, 120, electrons), map(160, 120);
  responsivity_map(map.view(), {0.03}, 6);
  multiply_by(image.view(), map.view());
  offset_map(map.view(), 200.0, 6);
  add_map(image.view(), map.view());
  image.at(17, 30) = 50.0F;  // dead
  image.at(159, 119) = electrons > 2e4F ? std::nanf("") : 3e4F;
  return image;
}

TEST(TwoPoint, linear_pixels_come_out_flat_at_every_level) {
  const mtf::Image cold = seen(1e4F), hot = seen(3e4F);
  const TwoPoint correction = two_point_correction(cold.view(), hot.view());
  ASSERT_EQ(correction.bad.size(), 2U);
  EXPECT_EQ(correction.bad[0].x, 17);
  EXPECT_EQ(correction.bad[0].y, 30);
  EXPECT_EQ(correction.bad[1].x, 159);
  for (const float level : {0.0F, 1e4F, 2e4F, 3e4F, 6e4F}) {
    mtf::Image image = seen(level);
    EXPECT_GT(std::sqrt(test::moments(samples(image).first(1000)).variance), 150.0);
    correct(image.view(), correction);
    replace_bad(image.view(), correction.bad);
    const auto m = test::moments(samples(image));
    EXPECT_LT(std::sqrt(m.variance), 0.02) << level;  // rounding of floats
    EXPECT_NEAR(m.mean, static_cast<double>(level), 30.0 + 1e-3 * static_cast<double>(level));
  }
}

TEST(BadPixels, take_the_mean_of_their_good_neighbours) {
  mtf::Image image = flat(20, 10, 0.0F);
  for (std::int64_t y = 0; y < 10; ++y)
    for (std::int64_t x = 0; x < 20; ++x) image.at(x, y) = static_cast<float>(3 * x + 100 * y);
  const mtf::Image before = image.clone();
  std::vector<Place> bad{{5, 5}, {0, 0}, {19, 9}};
  for (const Place& place : bad) image.at(place.x, place.y) = -1e30F;
  replace_bad(image.view(), bad);
  EXPECT_EQ(image.at(5, 5), before.at(5, 5));  // a plane is its own mean
  EXPECT_FLOAT_EQ(image.at(0, 0), (3 + 100 + 103) / 3.0F);
  for (std::int64_t y = 0; y < 10; ++y)
    for (std::int64_t x = 0; x < 20; ++x)
      if (!(x == 5 && y == 5) && !(x == 0 && y == 0) && !(x == 19 && y == 9)) {
        ASSERT_EQ(image.at(x, y), before.at(x, y));
      }
}

TEST(BadPixels, clusters_and_a_single_good_pixel) {
  mtf::Image image = flat(64, 64, -9.0F);
  std::vector<Place> bad;
  for (std::int64_t y = 0; y < 64; ++y)
    for (std::int64_t x = 0; x < 64; ++x)
      if (x != 3 || y != 4) bad.push_back({x, y});
  image.at(3, 4) = 7.0F;
  replace_bad(image.view(), bad);
  for (const float value : samples(image)) ASSERT_EQ(value, 7.0F);
}

TEST(Correction, refusals) {
  const mtf::Image cold = flat(4, 3, 1.0F), hot = flat(4, 3, 2.0F), other = flat(3, 4, 2.0F);
  expect_refused({"4 x 3", "3 x 4"}, [&] { two_point_correction(cold.view(), other.view()); });
  expect_refused({"not brighter"}, [&] { two_point_correction(hot.view(), cold.view()); });
  const mtf::Image nothing = flat(4, 3, std::nanf("")), none;
  expect_refused({"not brighter"}, [&] { two_point_correction(nothing.view(), hot.view()); });
  expect_refused({"0 x 0"}, [&] { two_point_correction(none.view(), none.view()); });
  expect_refused({"limit of 0"}, [&] { two_point_correction(cold.view(), hot.view(), 0.0); });
  const TwoPoint correction = two_point_correction(cold.view(), hot.view());
  mtf::Image image = flat(3, 4, 1.0F);
  expect_refused({"maps of 4 x 3", "3 x 4"}, [&] { correct(image.view(), correction); });
  expect_refused({"3, 0", "3 x 4"}, [&] { replace_bad(image.view(), std::vector<Place>{{3, 0}}); });
  mtf::Image one = flat(1, 1, 1.0F);
  expect_refused({"all 1 x 1"}, [&] { replace_bad(one.view(), std::vector<Place>{{0, 0}}); });
}

}  // namespace
}  // namespace radiometry
