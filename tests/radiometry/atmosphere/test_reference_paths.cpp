// SPDX-License-Identifier: Apache-2.0

// Fifteen paths as LOWTRAN7 computes them, each 5 cm^-1 of the infrared and 20 of the short wave; nothing is fitted to
// them. The runs had 330 ppm of CO2, older constants of Planck's law (1.190956e-8 W m^-2 sr^-1 cm^4 and 1.43879 cm K),
// and levels at 0 to 25 by 1, 30, 35, 40, 45, 50, 70, 100 km; the model has all levels of the profiles.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <tuple>

#include "tests/radiometry/atmosphere/atmosphere_data.h"

namespace {

using namespace atmosphere_tests;

struct Case {
  std::string name;
  Air<double> air;
  Sight<double> sight;
  double infrared, short_wave;  ///< bars
};

Profile<double> program_levels(Profile<double> profile) {
  std::erase_if(profile.levels, [](const Level<double>& level) {
    const double km = 1e-3 * level.altitude_m;
    return km > 25.0 && km != 30.0 && km != 35.0 && km != 40.0 && km != 45.0 && km != 50.0 && km != 70.0 && km != 100.0;
  });
  return profile;
}

std::vector<Case> cases(bool all_levels) {
  const auto model = [&](ModelAtmosphere m) {
    auto profile = model_profile(m, kModelCarbonDioxide_ppm);
    return all_levels ? profile : program_levels(profile);
  };
  const auto us = model(ModelAtmosphere::us_standard_1976), summer = model(ModelAtmosphere::mid_latitude_summer),
             winter = model(ModelAtmosphere::mid_latitude_winter), tropical = model(ModelAtmosphere::tropical),
             arctic = model(ModelAtmosphere::subarctic_winter);
  const auto level = [](double altitude_m, double range_m) {
    return Sight<double>(Horizontal<double>{altitude_m, range_m});
  };
  const Haze<double> rural{.kind = HazeKind::rural, .visibility_m = 23e3};
  const double degree = std::acos(-1.0) / 180.0;
  std::vector<Case> out{{"A01", {us}, level(0, 1e3), 1e-5, 1e-5},
                        {"A02", {us, rural}, level(0, 5e3), 3e-4, 5e-4},
                        {"A03", {summer, rural}, level(0, 1e3), 3e-4, 5e-4},
                        {"A04", {summer, {HazeKind::rural, 5e3}}, level(0, 5e3), 3e-4, 5e-4},
                        {"A05", {tropical, {HazeKind::maritime, 23e3}}, level(0, 2e3), 3e-4, 5e-4},
                        {"A06", {winter, {HazeKind::rural, 23e3, Season::autumn_winter}}, level(0, 10e3), 3e-4, 5e-4},
                        {"A07", {summer, rural}, ToAltitude<double>{1e3, 180.0 * degree, 0.0}, 1e-3, 5e-4},
                        {"A08", {us}, ToAltitude<double>{0.0, 60.0 * degree, 3e3}, 1e-3, 5e-4},
                        {"A09", {summer, rural}, ToSpace<double>{0.0, 0.0}, 1e-3, 5e-4},
                        {"A10", {summer, rural}, ToSpace<double>{0.0, 75.0 * degree}, 1e-3, 5e-4},
                        {"A11", {arctic}, level(1e3, 3e3), 1e-5, 1e-5},
                        {"A12", {us, rural}, ToAltitude<double>{10e3, 135.0 * degree, 0.0}, 1e-3, 5e-4},
                        {"A13",
                         {surface_air(101300.0, 303.2, 80.0, kModelCarbonDioxide_ppm), {HazeKind::urban, 5e3}},
                         level(0, 2e3),
                         1e-5,
                         5e-4},
                        {"A14", {us, {HazeKind::radiation_fog, 500.0}}, level(0, 300.0), 1e-5, 5e-4},
                        {"A15", {us, rural, 5.0}, level(0, 1e3), 3e-4, 5e-4}};
  return out;
}

/// B(nu, T) with the constants of the runs over that of today.
double older_planck(double wavenumber_cm, double temperature_k) {
  const auto planck = [&](double c1, double c2) { return c1 / std::expm1(c2 * wavenumber_cm / temperature_k); };
  return planck(1.190956e-8, 1.43879) / planck(1.191042972e-8, 1.438776877);
}

struct Reference {
  std::map<std::string, std::vector<std::array<double, 3>>> rows;  ///< wavenumber, transmission, radiance
};

Reference read_reference(const std::string& file, bool radiance) {
  const Table table = read_table(file);
  Reference reference;
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    reference.rows[table.rows[i][0]].push_back(
        {table.number(i, 1), table.number(i, 2), radiance ? table.number(i, 3) : 0.0});
  return reference;
}

void compare(bool all_levels) {
  const std::string file = shared_table("reference_paths.csv");
  if (file.empty()) GTEST_SKIP() << "no shared data";
  const Reference infrared = read_reference(file, true),
                  short_wave = read_reference(shared_table("reference_paths_short_wave.csv"), false);
  std::printf("levels: %s\n", all_levels ? "all of the profiles" : "those of the runs");
  for (const Case& one : cases(all_levels)) {
    const auto path = spectral_path(one.air, one.sight);
    double worst = 0.0, square = 0.0, worst_short = 0.0, worst_radiance = 0.0, most_radiance = 0.0;
    double at = 0.0;
    for (const auto& [nu, tau, radiance] : infrared.rows.at(one.name)) {
      const std::size_t i = index_of(path, nu);
      const double off = std::abs(path.transmission[i] - tau);
      if (off > worst) worst = off, at = nu;
      square += off * off;
      most_radiance = std::max(most_radiance, radiance);
      worst_radiance = std::max(worst_radiance, std::abs(path.radiance[i] * older_planck(nu, 280.0) - radiance));
    }
    for (const auto& [nu, tau, radiance] : short_wave.rows.at(one.name))
      worst_short = std::max(worst_short, std::abs(path.transmission[index_of(path, nu)] - tau));
    EXPECT_LE(worst, one.infrared) << one.name << " at " << at << " cm^-1";
    EXPECT_LE(worst_short, one.short_wave) << one.name;
    EXPECT_LE(worst_radiance, 2e-4 * most_radiance) << one.name;
    std::printf("%s  worst %.1e at %4.0f  rms %.1e  radiance %.1e of most  short wave %.1e\n", one.name.c_str(), worst,
                at, std::sqrt(square / static_cast<double>(infrared.rows.at(one.name).size())),
                worst_radiance / most_radiance, worst_short);
  }
}

struct Band {
  double transmission = 0.0, radiance = 0.0;
};

/// Transmission weighted by dB/dT at 300 K over wavenumber, and radiance, straight lines between the samples.
Band band_of(const SpectralPath<double>& path, double lo_um, double hi_um) {
  const double from = 1e4 / hi_um, to = 1e4 / lo_um, step = 0.25;
  const auto at = [&](const std::vector<double>& value, double nu) {
    const double place = (nu - path.wavenumber_cm.front()) / 5.0;
    const auto i = std::min(static_cast<std::size_t>(place), value.size() - 2);
    return value[i] + (place - static_cast<double>(i)) * (value[i + 1] - value[i]);
  };
  double weighted = 0.0, weights = 0.0, radiance = 0.0;
  const int steps = static_cast<int>((to - from) / step);
  for (int k = 0; k < steps; ++k) {
    const double nu = from + (k + 0.5) * (to - from) / steps, x = 1.438776877 * nu / 300.0;
    const double weight = nu * nu * nu * nu * std::exp(x) / (std::expm1(x) * std::expm1(x));
    weighted += weight * at(path.transmission, nu);
    weights += weight;
    radiance += (to - from) / steps * at(path.radiance, nu);
  }
  return {weighted / weights, radiance};
}

TEST(AtmospherePaths, Bands) {
  const std::string file = shared_table("reference_paths_bands.csv");
  if (file.empty()) GTEST_SKIP() << "no shared data";
  const Table table = read_table(file);
  double worst = 0.0, worst_radiance = 0.0;
  for (const Case& one : cases(true)) {
    auto path = spectral_path(one.air, one.sight);
    for (std::size_t i = 0; i < path.radiance.size(); ++i)
      path.radiance[i] *= older_planck(path.wavenumber_cm[i], 285.0);
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
      if (table.rows[row][0] != one.name) continue;
      for (const auto& [name, lo, hi] :
           {std::tuple{"3-5um", 3.0, 5.0}, {"3.4-4.8um", 3.4, 4.8}, {"8-12um", 8.0, 12.0}, {"8-14um", 8.0, 14.0}}) {
        const Band band = band_of(path, lo, hi);
        const double tau = table.number(row, table.column(std::string("tau_") + name));
        const double radiance = table.number(row, table.column(std::string("path_radiance_") + name + "_W_m-2_sr-1"));
        EXPECT_NEAR(band.transmission, tau, 2e-4) << one.name << " " << name;
        EXPECT_NEAR(band.radiance, radiance, 5e-4 * radiance) << one.name << " " << name;
        worst = std::max(worst, std::abs(band.transmission - tau));
        worst_radiance = std::max(worst_radiance, std::abs(band.radiance / radiance - 1.0));
      }
    }
  }
  std::printf("bands: transmission within %.1e, radiance within %.1e of itself\n", worst, worst_radiance);
}

// MODTRAN 5.2.1 for 1 km straight down, mid-latitude summer, rural haze of 23 km, as published with pyBSM's test
// values: 8-14 um .7094, 8-12 um .7849, 3-5 um .5582, radiance 14.93, 7.18, .607 W m^-2 sr^-1. Another band model,
// fitted later.
TEST(AtmospherePaths, Modtran) {
  const Air<double> air{model_profile(ModelAtmosphere::mid_latitude_summer, kModelCarbonDioxide_ppm),
                        {HazeKind::rural, 23e3}};
  const auto path = spectral_path(air, Sight<double>(ToAltitude<double>{1e3, std::acos(-1.0), 0.0}));
  const Band wide = band_of(path, 8.0, 14.0), far = band_of(path, 8.0, 12.0), middle = band_of(path, 3.0, 5.0);
  EXPECT_NEAR(wide.transmission, 0.7094, 0.01);
  EXPECT_NEAR(far.transmission, 0.7849, 0.01);
  EXPECT_NEAR(middle.transmission, 0.5582, 0.04);
  EXPECT_NEAR(wide.radiance, 14.93, 0.02 * 14.93);
  EXPECT_NEAR(far.radiance, 7.18, 0.02 * 7.18);
  EXPECT_NEAR(middle.radiance, 0.607, 0.11 * 0.607);
  std::printf("8-14 %.4f %.3f  8-12 %.4f %.3f  3-5 %.4f %.4f\n", wide.transmission, wide.radiance, far.transmission,
              far.radiance, middle.transmission, middle.radiance);
}

TEST(AtmospherePaths, ProgramLevels) { compare(false); }
TEST(AtmospherePaths, AllLevels) { compare(true); }

}  // namespace
