// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "radiometry/weather/clear_sky.h"
#include "radiometry/weather/sky.h"

namespace radiometry::heat {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

// By hand: T = 290 K, e = 10 hPa, sigma T^4 = 401.054809 W/m2.
TEST(Sky, FormulasByHand) {
  EXPECT_NEAR(clear_sky_longwave_w_m2(SkyModel::brunt, 290.0, 1000.0), 401.054809 * 0.7255480479, 1e-5);
  EXPECT_NEAR(clear_sky_longwave_w_m2(SkyModel::brutsaert, 290.0, 1000.0), 401.054809 * 1.24 * 0.618138794, 1e-5);
  EXPECT_NEAR(clear_sky_longwave_w_m2(SkyModel::swinbank, 290.0, 1000.0), 5.31e-13 * 5.94823321e14, 1e-3);
  EXPECT_DOUBLE_EQ(cloud_factor(0.0), 1.0);
  EXPECT_DOUBLE_EQ(cloud_factor(1.0), 1.22);
  EXPECT_NEAR(cloud_factor(0.5), 1.0 + 0.22 * 0.148651, 1e-6);
  EXPECT_NEAR(sky_temperature_k(401.054809), 290.0, 1e-5);
}

// Guide of the WMO: 6.112 hPa at 0 degC, 23.37 hPa at 20 degC, 73.8 hPa at 40 degC (rounded).
TEST(Sky, SaturationPressureAndDewPointAreInverse) {
  EXPECT_DOUBLE_EQ(saturation_pressure_pa(273.15), 611.2);
  EXPECT_NEAR(saturation_pressure_pa(293.15), 2337.0, 5.0);
  EXPECT_NEAR(saturation_pressure_pa(313.15), 7380.0, 15.0);
  for (double t = 230.0; t < 330.0; t += 7.0) EXPECT_NEAR(dew_point_k(saturation_pressure_pa(t)), t, 1e-9);
}

TEST(Sky, CloudCoverFromLongwaveInvertsTheFactor) {
  for (double n = 0.05; n <= 1.0; n += 0.05)
    EXPECT_NEAR(cloud_cover_from_longwave(300.0 * cloud_factor(n), 300.0), n, 1e-9);
  EXPECT_EQ(cloud_cover_from_longwave(250.0, 300.0), 0.0);
  EXPECT_EQ(cloud_cover_from_longwave(400.0, 300.0), 1.0);
}

TEST(Sky, RefusesWhatIsNoAir) {
  EXPECT_THROW(clear_sky_longwave_w_m2(SkyModel::brunt, 0.0, 1000.0), mtf::UsageError);
  EXPECT_THROW(clear_sky_longwave_w_m2(SkyModel::brunt, 290.0, -1.0), mtf::UsageError);
  EXPECT_THROW(cloud_factor(1.1), mtf::UsageError);
  EXPECT_THROW(cloud_factor(std::nan("")), mtf::UsageError);
  EXPECT_THROW(clear_sky({.pressure_pa = 1013.0 * 1e3}, 0.5, 1361.0), mtf::UsageError);
  EXPECT_THROW(clear_sky({.albedo = 2.0}, 0.5, 1361.0), mtf::UsageError);
}

// One row of the authors' spreadsheet: day 1, hour 13, and what the formulas give for it by hand.
TEST(ClearSky, OneRowOfTheAuthorsTable) {
  const SolarIrradiance solar = clear_sky({.pressure_pa = 84000.0}, 63.37408378 * kDegree, 1414.91335);
  EXPECT_NEAR(relative_air_mass(63.37408378 * kDegree), 2.220958083, 2e-5);
  EXPECT_NEAR(solar.direct_normal_w_m2, 806.6780719, 0.02);
  EXPECT_NEAR(solar.global_horizontal_w_m2, 452.9804466, 0.005);
  EXPECT_NEAR(solar.diffuse_horizontal_w_m2, 91.45611383, 0.005);
}

TEST(ClearSky, ClosesAndIsDarkAtNight) {
  for (double z = 0.0; z < 88.9; z += 3.7) {
    const SolarIrradiance solar = clear_sky({}, z * kDegree, 1361.0);
    EXPECT_NEAR(solar.global_horizontal_w_m2,
                solar.direct_normal_w_m2 * std::cos(z * kDegree) + solar.diffuse_horizontal_w_m2, 1e-10);
    EXPECT_GE(solar.diffuse_horizontal_w_m2, 0.0);
    EXPECT_LT(solar.direct_normal_w_m2, 1361.0);
  }
  EXPECT_EQ(clear_sky({}, 89.5 * kDegree, 1361.0).global_horizontal_w_m2, 0.0);
  EXPECT_EQ(clear_sky({}, 2.5, 1361.0).global_horizontal_w_m2, 0.0);
}

TEST(ClearSky, PressureOfTheStandardAtmosphere) {
  EXPECT_NEAR(standard_pressure_pa(0.0), 101325.0, 1e-9);
  EXPECT_NEAR(standard_pressure_pa(1000.0), 89876.0, 5.0);  // ISO 2533
  EXPECT_NEAR(standard_pressure_pa(5000.0), 54019.9, 0.5);  // ISO 2533, geopotential altitude
  EXPECT_THROW(standard_pressure_pa(20000.0), mtf::UsageError);
}

std::filesystem::path bird_table() {
  const char* chosen = std::getenv("MTFKIT_SHARED");
  const std::filesystem::path shared =
      chosen != nullptr ? std::filesystem::path(chosen) : std::filesystem::path(MTFKIT_SOURCE_DIR) / "../shared";
  const auto file = shared / "data/weather/BIRD_08_16_2012.csv";
  return std::filesystem::exists(file) ? file : std::filesystem::path();
}

// All hours of the spreadsheet that have values (47, of two days), with its own zenith angles: within 0.02 W/m2 (beam)
// and 0.005 W/m2 (global and diffuse), which is the spreadsheet's own rounding of the air mass.
TEST(ClearSky, WholeTableOfTheAuthors) {
  const auto path = bird_table();
  if (path.empty()) GTEST_SKIP() << "no shared data";
  std::ifstream file(path);
  std::string line;
  int rows = 0, lit = 0;
  double worst_beam = 0.0, worst_flat = 0.0;
  while (std::getline(file, line)) {
    const auto cells = mtf::io::split_cells(line, ',', 64);
    if (cells.size() < 21) continue;
    const auto day = mtf::io::cell_number(cells[1]), etr = mtf::io::cell_number(cells[3]),
               zenith = mtf::io::cell_number(cells[8]);
    const auto beam = mtf::io::cell_number(cells[17]), beam_flat = mtf::io::cell_number(cells[18]),
               global = mtf::io::cell_number(cells[20]);
    if (!day || !etr || !zenith || !beam || !beam_flat || !global) continue;
    const double diffuse = *global - *beam_flat;
    ++rows;
    if (*beam > 0.0) ++lit;
    const SolarIrradiance solar = clear_sky({.pressure_pa = 84000.0}, *zenith * kDegree, *etr);
    worst_beam = std::max(worst_beam, std::abs(solar.direct_normal_w_m2 - *beam));
    worst_flat = std::max({worst_flat, std::abs(solar.global_horizontal_w_m2 - *global),
                           std::abs(solar.diffuse_horizontal_w_m2 - diffuse)});
  }
  EXPECT_EQ(rows, 47);
  EXPECT_EQ(lit, 18);
  EXPECT_LT(worst_beam, 0.02);
  EXPECT_LT(worst_flat, 0.005);
}

}  // namespace
}  // namespace radiometry::heat
