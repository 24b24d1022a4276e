// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/stages/optics/narcissus.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"

namespace radiometry {
namespace {

using test::flat;

// 6 x 8 pixels of 1 um: half the diagonal is 5 um. The axis on the centre of a pixel.
TEST(Narcissus, depth_on_the_axis_and_half_of_it_at_the_radius) {
  const FocalPlane detector = focal_plane(6, 8, 1.0, 1.0, {.x_px = -0.5, .y_px = -0.5});
  for (const NarcissusProfile profile : {NarcissusProfile::gaussian, NarcissusProfile::flat_top}) {
    mtf::Image map(6, 8);
    narcissus_map(map.view(), {.depth = 0.2, .radius = 0.4, .profile = profile}, detector);
    EXPECT_FLOAT_EQ(map.at(2, 3), 0.2F);
    EXPECT_FLOAT_EQ(map.at(4, 3), 0.1F);
    EXPECT_FLOAT_EQ(map.at(2, 5), 0.1F);
    const bool is_flat = profile == NarcissusProfile::flat_top;
    EXPECT_NEAR(map.at(3, 3), 0.2 * (is_flat ? std::exp2(-1.0 / 256) : std::exp2(-0.25)), 1e-7);
    EXPECT_NEAR(map.at(2, 0), 0.2 * std::exp2(-std::pow(1.5, is_flat ? 8 : 2)), 1e-7);

    mtf::Image part(3, 2);
    narcissus_map(part.view(), {.depth = 0.2, .radius = 0.4, .profile = profile}, detector, {2, 4});
    EXPECT_EQ(part.at(1, 1), map.at(3, 5));
  }
}

// The whole that is missing is that of the profile's integral, pi w^2 / ln 2 and pi w^2 Gamma(5/4) / (ln 2)^(1/4).
TEST(Narcissus, total) {
  const FocalPlane detector = focal_plane(600, 600, 1.0, 1.0);
  const double w = 40.0, ln2 = std::log(2.0);
  const double expected[] = {mtf::kPi * w * w / ln2, mtf::kPi * w * w * std::tgamma(1.25) / std::pow(ln2, 0.25)};
  for (const NarcissusProfile profile : {NarcissusProfile::gaussian, NarcissusProfile::flat_top}) {
    mtf::Image map(600, 600);
    narcissus_map(map.view(), {.depth = 1.0, .radius = w / detector.half_diagonal_um(), .profile = profile}, detector);
    double sum = 0.0;
    for (const float value : test::samples(map)) sum += static_cast<double>(value);
    EXPECT_NEAR(sum / expected[static_cast<int>(profile)], 1.0, 2e-6);
  }
}

TEST(Narcissus, extremes_and_refusals) {
  const FocalPlane detector = focal_plane(4, 3, 1.0, 1.0);
  mtf::Image map(4, 3), other = flat(3, 4, 1.0F);
  narcissus_map(map.view(), {.depth = 1.0, .radius = 1e-6, .profile = NarcissusProfile::flat_top}, detector);
  for (const float value : test::samples(map)) EXPECT_EQ(value, 0.0F);
  expect_refused({"narcissus.depth = 2"}, [&] { narcissus_map(map.view(), {.depth = 2.0}, detector); });
  expect_refused({"outside", "4 x 3"}, [&] { narcissus_map(other.view(), {}, detector); });
}

}  // namespace
}  // namespace radiometry
