// SPDX-License-Identifier: Apache-2.0

// Scenes made of plain values: temperatures against the balance of heat in closed form, and what is refused.

#include "radiometry/thermal/thermal_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "radiometry/light/constants.h"
#include "radiometry/thermal/run/heat_run.h"
#include "radiometry/weather/instant.h"
#include "tests/expect_error.h"

namespace radiometry::thermal {
namespace {

const double kStart = heat::instant_of({2026, 6, 21}, 0.0);
constexpr double kAir_k = 288.15, kSky_w_m2 = 300.0, kFilm_w_m2_k = 14.0, kEmissivity = 0.9;

heat::WeatherSeries overcast() {
  using enum heat::WeatherQuantity;
  heat::Weather weather{.source = "overcast", .time_s = {kStart}, .values = {}};
  weather[air_temperature] = {kAir_k};
  weather[wind_speed] = {3.0};
  weather[direct_normal] = weather[diffuse_horizontal] = {0.0};
  weather[longwave_down] = {kSky_w_m2};
  weather[vapour_pressure] = {900.0};
  return make_series(weather, {});
}

/// Two level squares of 1 m beside each other: painted steel, insulated below.
ThermalScene plates() {
  const scene::Mesh mesh{.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}},
                         .corners = {0, 1, 4, 3, 1, 2, 5, 4},
                         .first = {0, 4, 8},
                         .group = {0, 0},
                         .material = {0, 0},
                         .group_names = {""},
                         .material_names = {""}};
  const scene::PlacedMesh placed{"plates", &mesh};
  Material paint{.name = "paint", .construction = {.layers = {{45.0, 7800.0, 480.0, 0.005}}}, .solar_absorptance = 0.7};
  paint.construction.emissivity = kEmissivity;
  paint.construction.convection = heat::LinearConvection{5.0, 3.0};
  return {.name = "plates",
          .start_s = kStart,
          .end_s = kStart + heat::kDay_s,
          .step_s = 6.0 * 3600.0,
          .weather = overcast(),
          .facets = scene::facets_of({&placed, 1}),
          .region_of = {0, 1},
          .regions = {{.name = "left", .material = 0}, {.name = "right", .material = 0}},
          .materials = {paint}};
}

/// eps sigma T^4 + h T = eps L + h T_air, by bisection.
double balance_k(double sky_w_m2) {
  double low = 100.0, high = 400.0;
  for (int i = 0; i < 100; ++i) {
    const double t = 0.5 * (low + high);
    const double gives = kEmissivity * kStefanBoltzmann_w_m2_k4 * std::pow(t, 4) + kFilm_w_m2_k * (t - kAir_k);
    (gives < kEmissivity * sky_w_m2 ? low : high) = t;
  }
  return low;
}

/// Temperatures of both squares at all outputs.
std::vector<double> solved(const ThermalScene& scene) {
  const HeatOptions options{.tolerance_k = 0.01};
  std::vector<double> kelvin;
  const HeatReport report = run_heat(prepare_heat(scene, options), options, [&](const HeatOutput& output) {
    kelvin.insert(kelvin.end(), output.front_k.begin(), output.front_k.end());
  });
  EXPECT_LE(report.promised.total_k(), options.tolerance_k);
  EXPECT_EQ(kelvin.size(), 10u);
  return kelvin;
}

// Nothing changes with time, so the bound is the tolerance of the run.
TEST(ThermalScene, APlateUnderAnOvercastSkyHasTheTemperatureOfItsBalance) {
  for (const double kelvin : solved(plates())) EXPECT_NEAR(kelvin, balance_k(kSky_w_m2), 0.01);
}

TEST(ThermalScene, TheSkyMayBeAFunctionOfTheWeather) {
  ThermalScene scene = plates();
  scene.sky = {.columns = {heat::WeatherQuantity::vapour_pressure}, .w_m2 = [](const heat::WeatherAt& at) {
                 return 100.0 + at[heat::WeatherQuantity::air_temperature] / 2.0 +
                        at[heat::WeatherQuantity::vapour_pressure] / 100.0;
               }};
  for (const double kelvin : solved(scene)) EXPECT_NEAR(kelvin, balance_k(100.0 + kAir_k / 2.0 + 9.0), 0.01);
}

TEST(ThermalScene, GivenTemperaturesAreTaken) {
  ThermalScene scene = plates();
  scene.regions[0] = {.name = "left",
                      .temperature = heat::make_schedule("s", {kStart, kStart + heat::kDay_s}, {300, 324})};
  scene.regions[1].table = std::make_shared<const TemperatureRows>(
      TemperatureRows{.source = "table", .facets = 2, .front_k = {std::numeric_limits<float>::quiet_NaN(), 310.0F}});
  const std::vector<double> kelvin = solved(scene);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(kelvin[2 * i], 300.0 + 6.0 * static_cast<double>(i), 1e-9);
    EXPECT_NEAR(kelvin[2 * i + 1], 310.0, 1e-9);
  }
}

/// A wall of brick that stands from south to north, through which heat passes, under two days of sun.
ThermalScene wall() {
  using enum heat::WeatherQuantity;
  ThermalScene scene = plates();
  const scene::Mesh mesh{
      .vertices = {{0, 0, 0}, {0.1, 0, 0}, {0.1, 4, 0}, {0, 4, 0}, {0, 0, 2}, {0.1, 0, 2}, {0.1, 4, 2}, {0, 4, 2}},
      .corners = {4, 5, 6, 7, 3, 2, 1, 0, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7},
      .first = {0, 4, 8, 12, 16, 20, 24},
      .group = std::vector<std::uint32_t>(6, 0),
      .material = std::vector<std::uint32_t>(6, 0),
      .group_names = {""},
      .material_names = {""}};
  const scene::PlacedMesh placed{"wall", &mesh};
  scene.facets = scene::facets_of({&placed, 1});
  scene.region_of.assign(6, 0);
  scene.regions.resize(1);
  Material& brick = scene.materials[0];
  brick.construction.layers = {{0.8, 1700.0, 850.0, 0.1}};
  brick.construction.inside = heat::Sheet{kEmissivity, brick.construction.convection};
  brick.back_solar_absorptance = brick.solar_absorptance;
  brick.pair_m = 0.2;
  heat::Weather weather{.source = "two days", .time_s = {}, .values = {}};
  for (int hour = 0; hour <= 48; ++hour) {
    const double sun = std::max(0.0, -std::cos(2.0 * std::numbers::pi * hour / 24.0));
    weather.time_s.push_back(kStart + 3600.0 * hour);
    weather[air_temperature].push_back(kAir_k + 6.0 * sun);
    weather[wind_speed].push_back(2.0);
    weather[direct_normal].push_back(800.0 * std::sqrt(sun));
    weather[diffuse_horizontal].push_back(100.0 * sun);
    weather[longwave_down].push_back(kSky_w_m2);
  }
  scene.weather = make_series(weather, scene.place);
  scene.end_s = kStart + 2.0 * heat::kDay_s;
  return scene;
}

// What goes on from the first day has all the numbers of what was not interrupted. The ends of the wall are solved as
// shortened chains, whose nodes have no depths.
TEST(ThermalScene, ARunGoesOnAfterADay) {
  HeatOptions options{.tolerance_k = 0.3};
  const HeatScene scene = prepare_heat(wall(), options);
  std::vector<double> whole, parts;
  const auto into = [](std::vector<double>& kelvin) {
    return [&kelvin](const HeatOutput& at) { kelvin.insert(kelvin.end(), at.front_k.begin(), at.front_k.end()); };
  };
  run_heat(scene, options, into(whole));
  options.go_on = [] { return false; };
  const HeatReport first = run_heat(scene, options, into(parts));
  ASSERT_TRUE(first.checkpoint);
  ASSERT_LT(parts.size(), whole.size());
  options.from = &*first.checkpoint;
  options.go_on = {};
  run_heat(scene, options, into(parts));
  EXPECT_EQ(parts, whole);
}

/// Of the two squares.
std::shared_ptr<const TemperatureRows> table(std::vector<double> utc_s, std::vector<float> kelvin) {
  return std::make_shared<const TemperatureRows>(
      TemperatureRows{.source = "t", .facets = 2, .utc_s = std::move(utc_s), .front_k = std::move(kelvin)});
}

TEST(ThermalScene, WhatIsNoSceneIsRefused) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](std::initializer_list<std::string_view> parts,
                          const std::function<void(ThermalScene&)>& change) {
    ThermalScene scene = plates();
    change(scene);
    expect_refused(parts, [&] { prepare_heat(scene, {}); });
  };
  refused({"plates: ", "no facets", "facets_of"}, [](ThermalScene& s) { s.facets = {}; });
  refused({"2 facets", "regions of 1"}, [](ThermalScene& s) { s.region_of = {0}; });
  refused({"facet 1", "region 7", "2 regions"}, [](ThermalScene& s) { s.region_of = {0, 7}; });
  refused({"'right'", "material 3", "1 material"}, [](ThermalScene& s) { s.regions[1].material = 3; });
  refused({"'right'", "a material, or a temperature"}, [](ThermalScene& s) { s.regions[1].material.reset(); });
  refused({"the ground", "material 1"}, [](ThermalScene& s) { s.ground = LevelGround{.material = 1}; });
  refused({"the ground", "a material, or a temperature"}, [](ThermalScene& s) { s.ground.emplace(); });
  refused({"end of the run", "after its start"}, [](ThermalScene& s) { s.end_s = s.start_s; });
  refused({"end of the run"}, [](ThermalScene& s) { s.start_s = kNaN; });
  refused({"25000 s", "divisor"}, [](ThermalScene& s) { s.step_s = 25000.0; });
  refused({"divisor"}, [](ThermalScene& s) { s.step_s = kNaN; });
  refused({"north"}, [](ThermalScene& s) { s.north_rad = kNaN; });
  refused({"no weather", "make_series"}, [](ThermalScene& s) { s.weather = {}; });
  refused({"longwave_down"}, [](ThermalScene& s) {
    s.weather.value[static_cast<std::size_t>(heat::WeatherQuantity::longwave_down)].clear();
  });
  refused({"'paint'", "emissivity", "between 0 and 1"},
          [](ThermalScene& s) { s.materials[0].construction.emissivity = kNaN; });
  refused({"'paint'", "absorptance", "between 0 and 1"},
          [](ThermalScene& s) { s.materials[0].solar_absorptance = kNaN; });
  refused({"'paint'", "inside", "schedule"},
          [](ThermalScene& s) { s.materials[0].construction.inside = heat::InnerFilm{5.0}; });
  refused({"'paint'", "leave it out"}, [](ThermalScene& s) { s.materials[0].inside = heat::constant_schedule(300.0); });
  refused({"'paint'", "generates"}, [](ThermalScene& s) { s.materials[0].sources = {heat::constant_schedule(300.0)}; });
  refused({"0 K"}, [](ThermalScene& s) { s.regions[0].temperature = heat::constant_schedule(0.0); });
  refused({"plates", "not finite"}, [](ThermalScene& s) { s.regions[0].temperature = {"s", {0.0}, {kNaN}}; });
  refused({"'right'", "1 temperatures", "2 facets"}, [](ThermalScene& s) { s.regions[1].table = table({}, {300.0F}); });
  refused({"t: facet 1", "'right'", "no temperature"}, [](ThermalScene& s) {
    s.regions[1].table = table({}, {300.0F, std::numeric_limits<float>::quiet_NaN()});
  });
  refused({"t: facet 1", "-5 K"}, [](ThermalScene& s) { s.regions[1].table = table({}, {300.0F, -5.0F}); });
  refused({"'right'", "2 rising times"}, [](ThermalScene& s) {
    s.regions[1].table = table({1.0, 1.0}, {300.0F, 300.0F, 300.0F, 300.0F});
  });
  // A run of less than a day begins with the state that repeats a whole one.
  refused({"'right'", "t has temperatures", "to 2026-06-21T12:00:00Z", "to 2026-06-22T00:00:00Z", "one row"},
          [](ThermalScene& s) {
            s.end_s = s.start_s + 0.5 * heat::kDay_s;
            s.regions[1].table = table({s.start_s, s.end_s}, {300.0F, 300.0F, 300.0F, 300.0F});
          });
  refused({"'right'", "from 2026-06-21T00:00:01Z", "take"}, [](ThermalScene& s) {
    s.regions[1].table = table({s.start_s + 1.0, s.end_s}, {300.0F, 300.0F, 300.0F, 300.0F});
  });
  refused({"'right'", "remove one"}, [](ThermalScene& s) {
    s.regions[1].table = table({}, {300.0F, 300.0F});
    s.regions[1].temperature = heat::constant_schedule(300.0);
  });
  refused({"outputs", "longer step"}, [](ThermalScene& s) { s.step_s = (s.end_s - s.start_s) / 4e6; });
  refused({"'paint'", "opposite faces", "sheet"}, [](ThermalScene& s) { s.materials[0].pair_m = 0.1; });
  refused({"'paint'", "opposite faces", "nan"}, [](ThermalScene& s) { s.materials[0].pair_m = kNaN; });
  refused({"'paint'", "W/m2", "finite"}, [](ThermalScene& s) { s.materials[0].source_w_m2 = kNaN; });
  // A column that is read and not listed is no number.
  refused({"plates", "long-wave", "LongwaveSky::columns"}, [](ThermalScene& s) {
    s.sky.w_m2 = [](const heat::WeatherAt& at) { return at[heat::WeatherQuantity::cloud_cover]; };
  });
}

}  // namespace
}  // namespace radiometry::thermal
