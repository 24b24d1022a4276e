// SPDX-License-Identifier: Apache-2.0

// Each absorber alone against tables of its transmittance or optical depth, those kept out of the fit included.

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/radiometry/atmosphere/atmosphere_data.h"

namespace {

using namespace atmosphere_tests;

const std::map<std::string, Gas> kGasNames{
    {"h2o", Gas::water},           {"co2", Gas::carbon_dioxide},   {"o3", Gas::ozone},    {"n2o", Gas::nitrous_oxide},
    {"co", Gas::carbon_monoxide},  {"ch4", Gas::methane},          {"o2", Gas::oxygen},   {"no", Gas::nitric_oxide},
    {"so2", Gas::sulphur_dioxide}, {"no2", Gas::nitrogen_dioxide}, {"nh3", Gas::ammonia}, {"hno3", Gas::nitric_acid}};
const std::map<std::string, Component> kGasComponents{
    {"h2o", Component::water_lines},   {"co2", Component::carbon_dioxide}, {"o3", Component::ozone},
    {"n2o", Component::nitrous_oxide}, {"co", Component::carbon_monoxide}, {"ch4", Component::methane},
    {"o2", Component::oxygen},         {"no", Component::trace_gases},     {"so2", Component::trace_gases},
    {"no2", Component::trace_gases},   {"nh3", Component::trace_gases},    {"hno3", Component::nitric_acid}};

TEST(AtmosphereTables, EveryGasAlone) {
  const std::string path = shared_table("gas_transmittance.csv");
  if (path.empty()) GTEST_SKIP() << "no shared data";
  const Table table = read_table(path), conditions = read_table(shared_table("gas_conditions.csv"));
  std::map<std::string, std::vector<std::size_t>> rows;
  for (std::size_t i = 0; i < table.rows.size(); ++i) rows[table.rows[i][0]].push_back(i);
  std::map<std::string, double> worst;
  for (std::size_t c = 0; c < conditions.rows.size(); ++c) {
    const std::string gas = conditions.rows[c][0], use = conditions.rows[c].back();
    Air<double> air = one_level(conditions.number(c, 2), conditions.number(c, 3));
    air.profile.levels[0][kGasNames.at(gas)] = conditions.number(c, 5);
    const auto model = along(air, conditions.number(c, 4));
    const auto& tau = of(model, kGasComponents.at(gas));
    const std::size_t column = table.column("t_" + conditions.rows[c][1]);
    for (const std::size_t row : rows.at(gas))
      worst[use] =
          std::max(worst[use], std::abs(tau[index_of(model, table.number(row, 1))] - table.number(row, column)));
  }
  RecordProperty("fit", std::to_string(worst.at("fit")));
  EXPECT_LE(worst.at("fit"), 5e-6);  // six decimals, of which a single-precision program keeps about that
  EXPECT_LE(worst.at("check"), 3e-5);
  std::printf("gases: worst %.1e fitted, %.1e not fitted\n", worst.at("fit"), worst.at("check"));
}

TEST(AtmosphereTables, WaterContinuum) {
  const std::string path = shared_table("h2o_continuum.csv");
  if (path.empty()) GTEST_SKIP() << "no shared data";
  const Table table = read_table(path), conditions = read_table(shared_table("h2o_continuum_conditions.csv"));
  double worst = 0.0, weak = 0.0;
  for (std::size_t c = 0; c < conditions.rows.size(); ++c) {
    Air<double> air = one_level(conditions.number(c, 1), conditions.number(c, 2));
    air.profile.levels[0][Gas::water] = conditions.number(c, 3);
    const double km = 1e-3;  // so short that no optical depth is lost in exp(-x)
    const auto model = along(air, km);
    const auto& tau = of(model, Component::water_continuum);
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
      const double expected = table.number(row, c + 1);
      if (std::isnan(expected)) continue;
      const double got = -std::log(tau[index_of(model, table.number(row, 0))]) / km;
      if (expected > 1e-4)
        worst = std::max(worst, std::abs(got / expected - 1.0));
      else
        weak = std::max(weak, std::abs(got - expected));
    }
  }
  EXPECT_LE(worst, 2e-5);
  EXPECT_LE(weak, 1e-6);  // per km: where it is below 1e-4 per km its parts cannot be told apart
  std::printf("water continuum: worst %.1e relative, below 1e-4 per km %.1e per km\n", worst, weak);
}

void compare_depths(const char* file, Component component, double from_cm, double tolerance) {
  const std::string path = shared_table(file);
  if (path.empty()) GTEST_SKIP() << "no shared data";
  const Table table = read_table(path);
  double worst = 0.0;
  for (std::size_t c = 1; c < table.names.size(); ++c) {
    double hpa = 0.0, kelvin = 0.0;
    ASSERT_EQ(std::sscanf(table.names[c].c_str(), "od_per_km_%lfmb_%lfK", &hpa, &kelvin), 2) << table.names[c];
    const auto model = along(one_level(hpa, kelvin), 0.1);
    const auto& tau = of(model, component);
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
      const double nu = table.number(row, 0), expected = table.number(row, c);
      if (nu < from_cm || std::isnan(expected)) continue;
      worst = std::max(worst, std::abs(-std::log(tau[index_of(model, nu)]) / 0.1 / expected - 1.0));
    }
  }
  EXPECT_LE(worst, tolerance);
  std::printf("%s: worst %.1e relative\n", file, worst);
}

TEST(AtmosphereTables, Nitrogen) { compare_depths("n2_continuum.csv", Component::nitrogen, 0.0, 2e-5); }
// Below 4000 cm^-1 the tables are a few 1e-7 per km with an error of 1e-10.
TEST(AtmosphereTables, Rayleigh) { compare_depths("rayleigh.csv", Component::molecular, 4000.0, 2e-5); }

TEST(AtmosphereTables, FogAndHaze) {
  const std::string path = shared_table("aerosol_transmittance.csv");
  if (path.empty()) GTEST_SKIP() << "no shared data";
  const Table table = read_table(path);
  struct Named {
    const char* name;
    HazeKind kind;
  };
  for (const auto& [name, kind] : {Named{"rural", HazeKind::rural}, Named{"urban", HazeKind::urban},
                                   Named{"maritime", HazeKind::maritime}, Named{"tropospheric", HazeKind::tropospheric},
                                   Named{"fog1", HazeKind::advection_fog}, Named{"fog2", HazeKind::radiation_fog}}) {
    double worst = 0.0;
    const bool fog = kind == HazeKind::advection_fog || kind == HazeKind::radiation_fog;
    for (const char* visibility : {"23", "5", "1", "0.2"})
      for (const int humidity : {0, 50, 70, 80, 90, 95, 99}) {
        const std::string column =
            std::string("ext_") + name + "_vis" + visibility + "km" + (fog ? "" : "_rh" + std::to_string(humidity));
        if (std::ranges::find(table.names, column) == table.names.end()) continue;
        Air<double> air{.profile = surface_air(101325.0, 290.0, 1.0 * humidity),
                        .haze = {.kind = kind, .visibility_m = 1e3 * std::stod(visibility)}};
        const double km = 0.01;
        const auto model = spectral_path(air, Sight<double>(Horizontal<double>{0.0, 1e3 * km}), {.components = true});
        for (std::size_t row = 0; row < table.rows.size(); ++row) {
          const double nu = table.number(row, 1);
          if (nu > 3500.0 && std::fmod(nu, 20.0) != 0.0) continue;  // those that both have
          const double depth = -std::log(of(model, Component::aerosol)[index_of(model, nu)]) / km;
          worst = std::max(worst, std::abs(depth / table.number(row, table.column(column)) - 1.0));
        }
      }
    EXPECT_GT(worst, 0.0);
    EXPECT_LE(worst, fog ? 2e-4 : 2.5e-3) << name;  // five digits; extinction at 0.55 um and 5 km has two
    std::printf("%s: worst %.1e relative\n", name, worst);
  }
}

}  // namespace
