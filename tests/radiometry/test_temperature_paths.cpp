// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "radiometry/light/path_planes.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"
#include "tests/radiometry/path_cases.h"

// Surfaces of any temperature behind paths of any length, against the integral over the band of each pixel by itself.

namespace radiometry {
namespace {

using test::cooled_camera;
using test::flat;
using test::lines_of_air;

double exact(const Surface& surface, double range_m) {
  const BandRadiances<double> light = band_radiances(cooled_camera(), surface, lines_of_air().at(range_m), {});
  return light.scene + light.path;
}

const std::vector<float> kRanges{1e-2F, 50.0F, 100.0F, 420.0F, 1000.0F, 2345.6F, 5000.0F},
    kTemperatures{235.0F, 288.4F, 300.0F, 351.7F, 700.0F, 1100.0F};

TEST(TemperaturePaths, are_the_camera_equation_for_every_pixel) {
  const auto width = static_cast<std::int64_t>(kRanges.size()),
             height = static_cast<std::int64_t>(kTemperatures.size());
  const Spectrum paint = make_spectrum("paint", {3.0, 4.0, 5.0}, {0.95, 0.5, 0.8}, 1.0);
  for (const bool black : {true, false}) {
    mtf::Image plane(width, height), range(width, height);
    for (std::int64_t y = 0; y < height; ++y)
      for (std::int64_t x = 0; x < width; ++x) {
        plane.at(x, y) = kTemperatures[static_cast<std::size_t>(y)];
        range.at(x, y) = kRanges[static_cast<std::size_t>(x)];
      }
    const SurfaceFinish finish{.emissivity = black ? constant_spectrum("blackbody", 1.0) : paint,
                               .plane = {},
                               .surroundings_k = black ? 0.0 : 270.0};
    const double error =
        radiance_at_ranges(plane.view(), range.view(), scene_band(cooled_camera()), finish, lines_of_air());
    EXPECT_LE(error, 1e-6);  // of 17 temperatures from 235 to 1100 K
    for (std::int64_t y = 0; y < height; ++y)
      for (std::int64_t x = 0; x < width; ++x) {
        const double t = static_cast<double>(kTemperatures[static_cast<std::size_t>(y)]);
        const double r = static_cast<double>(kRanges[static_cast<std::size_t>(x)]);
        const double expected = exact(Surface{t, finish.emissivity, finish.surroundings_k}, r);
        // Two roundings to float32, and 1e-7 of the table of a blackbody and of the transmission each.
        EXPECT_NEAR(static_cast<double>(plane.at(x, y)), expected, 5e-7 * expected) << t << " K, " << r << " m";
      }
  }
}

// The transmission of one spectrum for all temperatures would be off by this much; that is what the table is for.
TEST(TemperaturePaths, differ_from_one_spectrum_for_all) {
  const TemperatureRangeTable table(scene_band(cooled_camera()), lines_of_air(), 250.0, 400.0);
  const RangeTable one(scene_band(cooled_camera()), lines_of_air(), 300.0);
  EXPECT_NEAR(table.transmission(300.0, 1000.0), one.transmission(1000.0), 1e-7);
  EXPECT_GT(std::abs(table.transmission(400.0, 1000.0) - one.transmission(1000.0)), 0.005);
}

TEST(TemperaturePaths, take_the_emissivity_of_each_pixel) {
  mtf::Image plane = flat(2, 1, 310.0F), range = flat(2, 1, 1000.0F), emissivity = flat(2, 1, 0.25F);
  emissivity.at(1, 0) = 1.0F;
  radiance_at_ranges(plane.view(), range.view(), scene_band(cooled_camera()),
                     {.plane = emissivity.view(), .surroundings_k = 280.0}, lines_of_air());
  const double grey = exact(Surface{310.0, constant_spectrum("grey", 0.25), 280.0}, 1000.0),
               black = exact(Surface{310.0}, 1000.0);
  EXPECT_NEAR(static_cast<double>(plane.at(0, 0)), grey, 5e-7 * grey);
  EXPECT_NEAR(static_cast<double>(plane.at(1, 0)), black, 5e-7 * black);
}

// One temperature needs no polynomial, and temperatures that give nothing beside the hottest make none worse.
TEST(TemperaturePaths, ends_of_what_there_is) {
  mtf::Image plane = flat(3, 1, 300.0F);
  const mtf::Image range = flat(3, 1, 420.0F);
  EXPECT_EQ(radiance_at_ranges(plane.view(), range.view(), scene_band(cooled_camera()), {}, lines_of_air()), 0.0);
  EXPECT_NEAR(static_cast<double>(plane.at(1, 0)), exact(Surface{300.0}, 420.0), 5e-7 * exact(Surface{300.0}, 420.0));
  mtf::Image mixed = flat(3, 1, 300.0F);
  mixed.at(0, 0) = 0.0F;
  mixed.at(2, 0) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_LE(radiance_at_ranges(mixed.view(), range.view(), scene_band(cooled_camera()), {}, lines_of_air()), 1e-6);
  const double path = exact(Surface{0.0}, 420.0);
  EXPECT_NEAR(static_cast<double>(mixed.at(0, 0)), path, 1e-6 * path);
  EXPECT_NEAR(static_cast<double>(mixed.at(1, 0)), static_cast<double>(plane.at(1, 0)),
              5e-7 * static_cast<double>(plane.at(1, 0)));
  EXPECT_TRUE(std::isnan(mixed.at(2, 0)));
}

// Mirrors, and scenes so cold that they give nothing: what is left is reflected and added.
TEST(TemperaturePaths, surfaces_that_emit_nothing) {
  const mtf::Image range = flat(2, 1, 420.0F);
  mtf::Image mirror = flat(2, 1, 300.0F), cold = flat(2, 1, 0.0F), cool = flat(2, 1, 4.0F);
  const SurfaceFinish finish{.emissivity = constant_spectrum("mirror", 0.0), .plane = {}, .surroundings_k = 310.0};
  radiance_at_ranges(mirror.view(), range.view(), scene_band(cooled_camera()), finish, lines_of_air());
  const double reflected = exact(Surface{310.0}, 420.0), path = exact(Surface{0.0}, 420.0);
  EXPECT_NEAR(static_cast<double>(mirror.at(0, 0)), reflected, 5e-7 * reflected);
  for (mtf::Image* plane : {&cold, &cool}) {
    radiance_at_ranges(plane->view(), range.view(), scene_band(cooled_camera()), {}, lines_of_air());
    EXPECT_NEAR(static_cast<double>(plane->at(1, 0)), path, 1e-6 * path);
  }
}

TEST(TemperaturePaths, refusals_change_no_pixel) {
  mtf::Image plane = flat(2, 2, 300.0F), range = flat(2, 2, 420.0F);
  const auto run = [&] {
    radiance_at_ranges(plane.view(), range.view(), scene_band(cooled_camera()), {}, lines_of_air());
  };
  range.at(1, 0) = 0.0F;
  expect_refused({"depth: 1 pixel", "column 1, row 0", "air.csv"}, run);
  range.at(1, 0) = 6000.0F;
  expect_refused({"depth: 1 pixel", "5000 m"}, run);
  range.at(1, 0) = 100.0F;
  plane.at(0, 1) = -3.0F;
  expect_refused({"temperature: 1 pixel", "below 0 K"}, run);
  EXPECT_EQ(plane.at(0, 0), 300.0F);
  const SceneBand scene = scene_band(cooled_camera());
  expect_refused({"kelvin"}, [&] { TemperatureRangeTable(scene, lines_of_air(), -1.0, 300.0); });
}

}  // namespace
}  // namespace radiometry
