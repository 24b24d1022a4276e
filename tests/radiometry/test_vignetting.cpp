// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/stages/optics/vignetting.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"

namespace radiometry {
namespace {

using test::flat;

mtf::Image factors_of(const Vignetting& vignetting, const FocalPlane& detector, double focal_length_mm) {
  mtf::Image map(detector.columns, detector.rows);
  vignetting_map(map.view(), vignetting, detector, focal_length_mm);
  return map;
}

// 4 x 2 pixels of 1 x 2 mm at a focal length of 2 mm: the corner pixel is 1.5 and 1 mm off the axis, half the diagonal
// is 2 sqrt(2).
TEST(Vignetting, cos4_and_polynomial) {
  const FocalPlane detector = focal_plane(4, 2, 1000.0, 2000.0);
  EXPECT_NEAR(detector.half_diagonal_um(), 2000.0 * std::sqrt(2.0), 1e-9);
  const double tangent2 = 3.25 / 4.0, r2 = 3.25 / 8.0;
  EXPECT_FLOAT_EQ(factors_of({}, detector, 2.0).at(0, 0), static_cast<float>(1.0 / std::pow(1.0 + tangent2, 2)));
  EXPECT_FLOAT_EQ(factors_of({.cos4 = false, .a2 = -0.5, .a4 = 0.25, .a6 = -0.125}, detector, 2.0).at(3, 1),
                  static_cast<float>(1.0 - 0.5 * r2 + 0.25 * r2 * r2 - 0.125 * r2 * r2 * r2));
  EXPECT_EQ(factors_of({.a2 = -3.0}, detector, 2.0).at(0, 0), 0.0F);  // never below 0
  EXPECT_NEAR(cos4_factor(1.0 / 16.0), std::pow(16.0 / 17.0, 2), 1e-15);
  EXPECT_NEAR(cos4_factor(1.0 / 16.0), std::pow(std::cos(std::atan(0.25)), 4), 1e-15);
}

TEST(Vignetting, symmetric_about_the_axis) {
  const mtf::Image centred = factors_of({.a2 = -0.2}, focal_plane(9, 7, 15.0, 15.0), 0.2);
  for (std::int64_t y = 0; y < 7; ++y)
    for (std::int64_t x = 0; x < 9; ++x) {
      EXPECT_EQ(centred.at(x, y), centred.at(8 - x, y));
      EXPECT_EQ(centred.at(x, y), centred.at(x, 6 - y));
      EXPECT_LE(centred.at(x, y), centred.at(4, 3));
    }
  EXPECT_EQ(centred.at(4, 3), 1.0F);
  const mtf::Image shifted = factors_of({.a2 = -0.2}, focal_plane(9, 7, 15.0, 15.0, {.x_px = 2.0, .y_px = -1.0}), 0.2);
  EXPECT_EQ(shifted.at(6, 2), 1.0F);
  EXPECT_FLOAT_EQ(shifted.at(8, 3), centred.at(6, 4));
}

TEST(Vignetting, regions_and_maps) {
  const FocalPlane detector = focal_plane(400, 300, 15.0, 12.0, {.x_px = 20.0, .y_px = 5.0});
  const Vignetting vignetting{.a2 = -0.1, .a4 = -0.05};
  const mtf::Image whole = factors_of(vignetting, detector, 6.0);
  mtf::Image part(50, 40);
  vignetting_map(part.view(), vignetting, detector, 6.0, {300, 111});
  for (std::int64_t y = 0; y < 40; ++y)
    for (std::int64_t x = 0; x < 50; ++x) ASSERT_EQ(part.at(x, y), whole.at(300 + x, 111 + y));

  // A map takes the place of the polynomial; cos^4 stays.
  const mtf::Image given = flat(50, 40, 0.5F);
  vignetting_map(part.view(), {.map = "m.exr"}, detector, 6.0, {300, 111}, given.view());
  mtf::Image cos4(50, 40);
  vignetting_map(cos4.view(), {}, detector, 6.0, {300, 111});
  EXPECT_FLOAT_EQ(part.at(7, 8), 0.5F * cos4.at(7, 8));

  // So do the shares of a pupil.
  mtf::Image of_pupil(50, 40);
  vignetting_map(of_pupil.view(), {.of = VignettingOf::wavefront}, detector, 6.0, {300, 111}, given.view());
  EXPECT_EQ(of_pupil.at(7, 8), part.at(7, 8));

  // A small region of a detector that no memory holds; a single pixel.
  mtf::Image tiny(2, 1);
  vignetting_map(tiny.view(), vignetting, focal_plane(std::int64_t{1} << 31, std::int64_t{1} << 31, 1.0, 1.0), 1e9,
                 {(std::int64_t{1} << 30) - 1, std::int64_t{1} << 30});
  EXPECT_FLOAT_EQ(tiny.at(0, 0), 1.0F);
  EXPECT_EQ(factors_of(vignetting, focal_plane(1, 1, 15.0, 15.0), 6.0).at(0, 0), 1.0F);
}

TEST(Vignetting, refusals) {
  mtf::Image map = flat(4, 3, 1.0F), other = flat(3, 4, 1.0F), negative = flat(4, 3, -0.5F);
  const FocalPlane detector = focal_plane(4, 3, 15.0, 15.0);
  expect_refused({"vignetting.a2 = 1000"}, [&] { vignetting_map(map.view(), {.a2 = 1e3}, detector, 50.0); });
  expect_refused({"focal length of 0"}, [&] { vignetting_map(map.view(), {}, detector, 0.0); });
  expect_refused({"focal length of nan"}, [&] { vignetting_map(map.view(), {}, detector, std::nan("")); });
  expect_refused({"m.exr", "not given"}, [&] { vignetting_map(map.view(), {.map = "m.exr"}, detector, 50.0); });
  const Vignetting of_pupil{.of = VignettingOf::wavefront};
  expect_refused({"vignetting.of", "not given"}, [&] { vignetting_map(map.view(), of_pupil, detector, 50.0); });
  expect_refused({"either of = \"wavefront\" or"}, [&] {
    vignetting_map(map.view(), {.of = VignettingOf::wavefront, .a2 = 0.1}, detector, 50.0, {}, map.view());
  });
  expect_refused({"either a map or"},
                 [&] { vignetting_map(map.view(), {.a2 = 0.1, .map = "m.exr"}, detector, 50.0, {}, map.view()); });
  expect_refused({"m.exr has 3 x 4", "4 x 3"},
                 [&] { vignetting_map(map.view(), {.map = "m.exr"}, detector, 50.0, {}, other.view()); });
  expect_refused({"-0.5 at pixel 0, 0"},
                 [&] { vignetting_map(map.view(), {.map = "m.exr"}, detector, 50.0, {}, negative.view()); });
  const mtf::Image part = flat(2, 2, -0.5F);
  expect_refused({"-0.5 at pixel 2, 1"}, [&] {  // of the detector, not of the part
    mtf::Image factors(2, 2);
    vignetting_map(factors.view(), {.map = "m.exr"}, detector, 50.0, {2, 1}, part.view());
  });
  expect_refused({"column 1, row 0", "4 x 3"}, [&] { vignetting_map(map.view(), {}, detector, 50.0, {1, 0}); });
  expect_refused({"focal plane of 0 x 3"}, [] { focal_plane(0, 3, 15.0, 15.0); });
  expect_refused({"inf"}, [] { focal_plane(4, 3, 15.0, INFINITY); });
  expect_refused({"optical_axis.x = nan px"}, [] { focal_plane(4, 3, 15.0, 15.0, {.x_px = std::nan("")}); });
}

}  // namespace
}  // namespace radiometry
