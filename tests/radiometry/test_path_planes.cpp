// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "radiometry/light/path_planes.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"
#include "tests/radiometry/path_cases.h"

namespace radiometry {
namespace {

using test::cooled_camera;
using test::flat;
using test::lines_of_air;

TEST(RangeTable, is_the_camera_equation_at_every_range) {
  const SpectralCamera mwir = cooled_camera();
  const PathTable table = lines_of_air();
  const double t = 310.0;
  const RangeTable ranges(scene_band(mwir), table, t);
  const double near = band_radiances(mwir, Surface{t}, Path{}, {}).scene;
  for (const double r : {1e-3, 1.0, 20.0, 99.9, 100.0, 101.0, 400.0, 1000.0, 1234.5, 4000.0, 5000.0}) {
    const BandRadiances<double> exact = band_radiances(mwir, Surface{t}, table.at(r), {});
    EXPECT_NEAR(ranges.transmission(r) * near, exact.scene, 1e-7 * exact.scene) << r;
    EXPECT_NEAR(ranges.radiance(r), exact.path, 1e-12 * exact.path) << r;
  }
  EXPECT_EQ(ranges.longest_m(), 5000.0);
  EXPECT_NEAR(ranges.transmission(0.0), 1.0, 1e-14);
  EXPECT_EQ(ranges.radiance(0.0), 0.0);
  for (const double r : {-1.0, 5000.1, std::nan("")}) {
    expect_refused({"air.csv", "from 0 to 5000 m"}, [&] { ranges.transmission(r); });
    expect_refused({"air.csv", "from 0 to 5000 m"}, [&] { ranges.radiance(r); });
  }
}

TEST(RangeTable, without_a_temperature_photons_are_spread_evenly) {
  const SceneBand scene = scene_band(cooled_camera());
  const RangeTable ranges(scene, lines_of_air(), {});
  std::vector<Spectrum> curves = scene.curves;
  const double whole = BandResponse(scene.band, curves).integral();
  curves.push_back(lines_of_air().at(700.0).transmission);
  EXPECT_NEAR(ranges.transmission(700.0), BandResponse(scene.band, curves).integral() / whole, 1e-7);
}

TEST(RangeTable, single_wavelengths_and_tables_that_cover_part_of_the_band) {
  const SceneBand scene = scene_band(cooled_camera());
  const RangeTable grey(scene, {"grey", {1000.0}, {4.0}, {{0.5}}, {{1e-3}}}, 300.0);
  EXPECT_NEAR(grey.transmission(500.0), std::sqrt(0.5), 1e-7);
  const RangeTable part(scene, {"part", {1000.0}, {3.0, 4.0}, {{1.0, 1.0}}, {{0.0, 0.0}}}, 300.0);
  EXPECT_GT(part.transmission(1000.0), 0.05);
  EXPECT_LT(part.transmission(1000.0), 0.5);
  expect_refused({"spectral channels", "8 um to 9 um"}, [&] {
    RangeTable(scene, {"lwir", {1000.0}, {8.0, 9.0}, {{1.0, 1.0}}, {{0.0, 0.0}}}, 300.0);
  });
  expect_refused({"air.csv", "1 K"}, [&] { RangeTable(scene, lines_of_air(), 1.0); });
}

TEST(RangeTable, pixel_by_pixel_and_both_terms) {
  const RangeTable ranges(scene_band(cooled_camera()), lines_of_air(), 300.0);
  mtf::Image light = flat(40, 30, 2e19F), depth(40, 30);
  light.at(1, 0) = std::nanf("");
  light.at(2, 0) = std::numeric_limits<float>::infinity();
  for (std::int64_t i = 0; i < depth.size(); ++i) depth.data()[i] = 1.0F + 4.1F * static_cast<float>(i);
  depth.at(39, 29) = 5000.0F;
  mtf::Image other = light.clone();
  ranges.apply(light.view(), depth.view());
  ranges.apply(other.view(), depth.view(), 2);
  EXPECT_TRUE(std::isnan(light.at(1, 0)));
  EXPECT_TRUE(std::isinf(light.at(2, 0)));
  for (const auto& [x, y] : {std::pair{0, 0}, {20, 3}, {39, 29}}) {
    const auto r = static_cast<double>(depth.at(x, y));
    const double exact = ranges.transmission(r) * static_cast<double>(2e19F) + ranges.radiance(r);
    EXPECT_NEAR(static_cast<double>(light.at(x, y)), exact, 6e-8 * exact);
    EXPECT_EQ(light.at(x, y), other.at(x, y));
  }
}

TEST(RangeTable, depth_that_is_missing_or_impossible) {
  const RangeTable ranges(scene_band(cooled_camera()), lines_of_air(), 300.0);
  mtf::Image light = flat(4, 3, 1.0F), depth = flat(4, 3, 10.0F);
  const auto apply = [&] { ranges.apply(light.view(), depth.view()); };
  for (const float bad : {0.0F, -1.0F, 5001.0F, std::nanf(""), std::numeric_limits<float>::infinity()}) {
    depth.at(2, 1) = bad;
    depth.at(3, 2) = bad;
    expect_refused({"depth", "2 pixels", "5000 m", "air.csv", "column 2, row 1"}, apply);
    EXPECT_EQ(light.at(0, 0), 1.0F);
  }
  const mtf::Image none;
  expect_refused({"depth", "0 x 0", "4 x 3"}, [&] { ranges.apply(light.view(), none.view()); });
}

}  // namespace
}  // namespace radiometry
