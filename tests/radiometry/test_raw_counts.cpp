// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "mtf/io/image_io.h"
#include "radiometry/light/raw_counts.h"
#include "tests/expect_error.h"
#include "tests/mtf/reference_table.h"
#include "tests/radiometry/frames.h"

namespace radiometry {
namespace {

using mtf::test::number;
using mtf::test::reference_table;
using mtf::test::Row;

// Constants of a handheld camera, a FLIR E60.
const CountCamera kCamera{
    .r1 = 14985.9296875, .b_k = 1398.09997558594, .f = 1.0, .o = -6233.0, .r2 = 0.0112832169979811};

TEST(RawCounts, there_and_back) {
  for (const double t : {200.0, 250.0, 293.15, 300.0, 400.0, 1500.0, 1e6})
    EXPECT_NEAR(kCamera.temperature_k(kCamera.count(t)), t, 1e-11 * t) << t;
  EXPECT_TRUE(std::isnan(kCamera.temperature_k(6233.0)));
  EXPECT_TRUE(std::isnan(kCamera.temperature_k(0.0)));
}

CountCamera camera_of(const Row& row) {
  return {.r1 = number(row, "r1"),
          .b_k = number(row, "b_k"),
          .f = number(row, "f"),
          .o = number(row, "o"),
          .r2 = number(row, "r2")};
}

Reflection reflection_of(const Row& row) {
  return {.emissivity = number(row, "emissivity"), .reflected_k = number(row, "reflected_k")};
}

TEST(RawCounts, against_40_digits) {
  for (const Row& row : reference_table("camera_counts.csv")) {
    const double exact = number(row, "apparent_k"), count = number(row, "count");
    EXPECT_NEAR(camera_of(row).temperature_k(count), exact, 1e-14 * exact) << row.where;
    EXPECT_NEAR(camera_of(row).count(exact), count, 1e-11 * count) << row.where;
    mtf::Image plane = test::flat(1, 1, static_cast<float>(count));
    temperature_of_counts(plane.view(), camera_of(row), reflection_of(row));
    EXPECT_FLOAT_EQ(plane.at(0, 0), static_cast<float>(number(row, "surface_k"))) << row.where;
  }
}

TEST(RawCounts, published_thermal_images) {
  const char* chosen = std::getenv("MTFKIT_SHARED");
  const std::filesystem::path shared =
      chosen != nullptr ? chosen : std::filesystem::path(MTFKIT_SOURCE_DIR) / "../shared";
  const std::filesystem::path folder = shared / "data" / "thermal";
  if (!std::filesystem::exists(folder / "ducks.png")) GTEST_SKIP() << "no shared data";
  for (const Row& row : reference_table("camera_counts.csv")) {
    mtf::io::ImageFile file = mtf::io::read_image((folder / row.at("file")).string());
    const auto x = static_cast<std::int64_t>(number(row, "x")), y = static_cast<std::int64_t>(number(row, "y"));
    EXPECT_EQ(static_cast<double>(file.planes[0].at(x, y)), number(row, "count")) << row.where;
    temperature_of_counts(file.planes[0].view(), camera_of(row), reflection_of(row), 2);
    EXPECT_FLOAT_EQ(file.planes[0].at(x, y), static_cast<float>(number(row, "surface_k"))) << row.where;
  }
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
