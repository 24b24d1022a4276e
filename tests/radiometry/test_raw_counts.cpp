// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "mtf/io/image_io.h"
#include "radiometry/performance/count_uncertainty.h"
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

Thermometry reflection_of(const Row& row) {
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

// The other way round: what a camera counts of a surface that reflects, behind air and a window, by the published sum.
double count_of(double surface_k, const Thermometry& a) {
  const auto u = [](double k) { return kCamera.r1 / (kCamera.r2 * (std::exp(kCamera.b_k / k) - kCamera.f)); };
  const double before = a.emissivity * u(surface_k) + (1.0 - a.emissivity) * u(a.reflected_k);
  const double behind = a.transmission * before + (1.0 - a.transmission) * u(a.air_k);
  return a.window_transmission * behind + (1.0 - a.window_transmission) * u(a.window_k) - kCamera.o;
}

TEST(RawCounts, air_and_window_are_taken_off) {
  const Thermometry seen{.emissivity = 0.8,
                         .reflected_k = 280.0,
                         .transmission = 0.9,
                         .air_k = 285.0,
                         .window_transmission = 0.85,
                         .window_k = 300.0};
  for (const double t : {250.0, 293.15, 310.0, 400.0}) {
    EXPECT_NEAR(temperature_of(count_of(t, seen), kCamera, seen), t, 1e-10 * t);
    mtf::Image plane = test::flat(2, 1, static_cast<float>(count_of(t, seen)));
    temperature_of_counts(plane.view(), kCamera, seen);
    EXPECT_NEAR(static_cast<double>(plane.at(1, 0)), t, 1e-3);  // half a count of float; the bar is 0.01 K
  }
  // Partial derivatives are slopes of the same formula: central differences, to their square.
  const double count = count_of(310.0, seen);
  const CountSensitivity s = sensitivity_of(count, kCamera, seen);
  const auto slope = [&](double Thermometry::*field, double step) {
    Thermometry more = seen, less = seen;
    more.*field += step;
    less.*field -= step;
    return (temperature_of(count, kCamera, more) - temperature_of(count, kCamera, less)) / (2.0 * step);
  };
  EXPECT_NEAR(s.emissivity, slope(&Thermometry::emissivity, 1e-4), 1e-5 * std::abs(s.emissivity));
  EXPECT_NEAR(s.reflected, slope(&Thermometry::reflected_k, 1e-2), 1e-5 * std::abs(s.reflected));
  EXPECT_NEAR(s.transmission, slope(&Thermometry::transmission, 1e-4), 1e-5 * std::abs(s.transmission));
  EXPECT_NEAR(s.air, slope(&Thermometry::air_k, 1e-2), 1e-5 * std::abs(s.air));
  EXPECT_LT(s.emissivity, 0.0);  // what is darker has to be warmer
}

TEST(RawCounts, transmission_of_the_air) {
  EXPECT_EQ(transmission_of({.distance_m = 0.0}), 1.0);
  // By a calculator: 20 C and 50 % hold h = 8.563981, and 100 m give t = 1.9 exp(-10 (0.006569 - 0.002276 sqrt h))
  //   - 0.9 exp(-10 (0.01262 - 0.00667 sqrt h)).
  EXPECT_NEAR(transmission_of({.distance_m = 100.0}), 0.937454651437, 1e-9);
  EXPECT_TRUE(std::isnan(transmission_of({.distance_m = -1.0})));
  EXPECT_TRUE(std::isnan(transmission_of({.distance_m = 100.0, .x = 1e6})));
}

// Against numpy's Monte Carlo and differences of the published formula: tests/python/test_count_temperatures.py.
TEST(CountErrors, what_is_exact_leaves_no_interval) {
  const CountScene told{.emissivity = 0.9, .surroundings_k = 285.0, .distance_m = 20.0};
  const double count = count_of(310.0, thermometry_of(told, CountAir{}));
  const CountUncertainty exact = CountErrors(kCamera, told, CountAir{}, {}).of(count);
  EXPECT_NEAR(exact.temperature_k, 310.0, 1e-9);
  EXPECT_EQ(exact.sd_k, 0.0);
  EXPECT_NEAR(exact.low_k, 310.0, 1e-9);
  EXPECT_NEAR(exact.high_k, 310.0, 1e-9);
  EXPECT_TRUE(exact.first_order);
  // One number alone: the interval is that of the formula at its quantiles, for the temperature falls with it.
  const CountUncertainty one = CountErrors(kCamera, told, CountAir{}, {0.02}).of(count);
  CountScene bright = told, dim = told;
  bright.emissivity += 1.96 * 0.02;
  dim.emissivity -= 1.96 * 0.02;
  EXPECT_TRUE(one.first_order);
  EXPECT_NEAR(one.low_k, temperature_of(count, kCamera, thermometry_of(bright, CountAir{})), 0.01 * one.sd_k);
  EXPECT_NEAR(one.high_k, temperature_of(count, kCamera, thermometry_of(dim, CountAir{})), 0.01 * one.sd_k);
  EXPECT_EQ(one.share(0), 1.0);
}

TEST(CountErrors, what_has_no_slope_or_no_temperature_is_no_number_of_first_order) {
  const CountScene near{.emissivity = 0.9, .distance_m = 0.0};
  const double count = count_of(310.0, thermometry_of(near, CountAir{}));
  const CountUncertainty found = CountErrors(kCamera, near, CountAir{}, {0.0, 0.0, 1.0}).of(count);
  EXPECT_FALSE(found.first_order);
  EXPECT_GE(found.low_k, 310.0);  // distances go from 0 on, and what lies further away is warmer than it seems
  EXPECT_LT(found.low_k, 310.1);
  EXPECT_GT(found.high_k, 310.1);
  const CountUncertainty none = CountErrors(kCamera, near, CountAir{}, {0.02}).of(0.0);
  EXPECT_TRUE(std::isnan(none.temperature_k) && std::isnan(none.low_k));
  EXPECT_FALSE(none.first_order);
  expect_refused({"less than 5 %"}, [&] { CountErrors(kCamera, near, CountAir{}, {50.0}); });
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
  const auto with = [&](const Thermometry& assumed) { temperature_of_counts(plane.view(), kCamera, assumed); };
  expect_refused({"emissivity 0;"}, [&] { with({.emissivity = 0.0}); });
  expect_refused({"emissivity 1.1"}, [&] { with({.emissivity = 1.1}); });
  expect_refused({"emissivity nan"}, [&] { with({.emissivity = std::nan("")}); });
  expect_refused({"-3,"}, [&] { with({.emissivity = 0.9, .reflected_k = -3.0}); });
  expect_refused({"nan,"}, [&] { with({.emissivity = 0.9, .reflected_k = std::nan("")}); });
  with({.emissivity = 0.9, .reflected_k = 0.0});
  expect_refused({"transmission of the air 0;"}, [&] { with({.transmission = 0.0}); });
  expect_refused({"transmission of the window 2;"}, [&] { with({.window_transmission = 2.0}); });
  expect_refused({"-1 and"}, [&] { with({.transmission = 0.9, .air_k = -1.0}); });
  expect_refused({"counts.R1", "counts.B"}, [&] { temperature_of_counts(plane.view(), CountCamera{}); });
}

}  // namespace
}  // namespace radiometry
