// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "apps/scene/scene_file/demo_scene_text.h"
#include "apps/scene/scene_file/scene_file.h"
#include "radiometry/light/blackbody.h"
#include "radiometry/light/constants.h"
#include "radiometry/weather/instant.h"
#include "tests/apps/scene/scene_folder.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps::scene {
namespace {

using namespace test;
using radiometry::heat::instant_of;
using radiometry::heat::WeatherAt;
using enum radiometry::heat::WeatherQuantity;

constexpr double kDegree = std::numbers::pi / 180.0;

std::string all_of(const SceneResult& result) {
  std::string text;
  for (const auto& diagnostic : result.diagnostics) text += mtf::io::format_diagnostic(diagnostic, "scene.toml") + "\n";
  return text;
}

TEST(SceneFile, EveryValueArrives) {
  const SceneFolder folder;
  const SceneResult result = folder.parse(scene_text());
  ASSERT_TRUE(result.ok()) << all_of(result);
  EXPECT_TRUE(result.diagnostics.empty()) << all_of(result);
  const SceneFile& scene = result.scene;
  EXPECT_DOUBLE_EQ(scene.place.latitude_rad, 37.70 * kDegree);
  EXPECT_DOUBLE_EQ(scene.place.longitude_rad, -105.92 * kDegree);
  EXPECT_EQ(scene.place.altitude_m, 2317.0);
  EXPECT_DOUBLE_EQ(scene.north_rad, 10.0 * kDegree);
  EXPECT_EQ(scene.time.start_s, instant_of({2016, 1, 1}));
  EXPECT_EQ(scene.time.end_s, instant_of({2016, 1, 3}));
  EXPECT_EQ(scene.time.step_s, 600.0);
  EXPECT_EQ(scene.weather.file, folder.file("weather.csv"));
  EXPECT_EQ(scene.weather.stamp, radiometry::heat::Stamp::instant);
  EXPECT_EQ(scene.weather.repeat, radiometry::heat::Repeat::none);
  EXPECT_EQ(scene.sky.longwave, LongwaveModel::measured);
  EXPECT_EQ(scene.sky.cloud, CloudSource::from_longwave);

  ASSERT_EQ(scene.materials.size(), 3u);
  const MaterialSection& armour = scene.materials[0];
  EXPECT_EQ(armour.name, "armour");
  EXPECT_EQ(armour.solar_absorptance, 0.7);
  ASSERT_TRUE(armour.emissivity.spectrum);
  EXPECT_EQ(armour.emissivity.value, planck_mean(*armour.emissivity.spectrum, 300.0));
  EXPECT_GT(armour.emissivity.value, 0.9);
  EXPECT_EQ(armour.convection.model, ConvectionModel::mcadams);
  ASSERT_EQ(armour.layers.size(), 1u);
  EXPECT_EQ(armour.layers[0].conductivity_w_m_k, 45.0);
  EXPECT_EQ(armour.layers[0].density_kg_m3, 7800.0);
  EXPECT_EQ(armour.layers[0].heat_capacity_j_kg_k, 480.0);
  EXPECT_DOUBLE_EQ(armour.layers[0].thickness_m, 0.02);
  EXPECT_EQ(armour.inside.kind, InsideKind::film);
  EXPECT_EQ(armour.inside.h_w_m2_k, 10.0);
  EXPECT_DOUBLE_EQ(value_at(armour.inside.temperature, scene.time.start_s + 3.0 * 3600.0), 323.15);

  const MaterialSection& soil = scene.materials[1];
  EXPECT_DOUBLE_EQ(soil.solar_absorptance, 0.78);
  EXPECT_EQ(soil.emissivity.value, 0.95);
  EXPECT_EQ(soil.convection.model, ConvectionModel::linear);
  EXPECT_EQ(soil.convection.h0_w_m2_k, 5.0);
  EXPECT_DOUBLE_EQ(soil.convection.h1_j_m3_k, 3.8);
  ASSERT_EQ(soil.layers.size(), 2u);
  EXPECT_DOUBLE_EQ(soil.layers[0].density_kg_m3, 1600.0);
  EXPECT_DOUBLE_EQ(soil.layers[0].heat_capacity_j_kg_k, 900.0);
  ASSERT_TRUE(soil.layers[1].source.constant());
  EXPECT_EQ(soil.layers[1].source.value.front(), 1e-6);
  EXPECT_EQ(soil.inside.kind, InsideKind::adiabatic);

  const MaterialSection& canvas = scene.materials[2];
  EXPECT_EQ(canvas.inside.kind, InsideKind::sheet);
  EXPECT_EQ(canvas.inside.back_solar_absorptance, 0.3);
  EXPECT_FALSE(canvas.inside.back_emissivity);
  EXPECT_EQ(canvas.wet_fraction, 0.1);

  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.meshes[0].file, folder.file("vehicle.obj"));
  EXPECT_DOUBLE_EQ(scene.meshes[0].unit_m, 1e-3);
  EXPECT_EQ(scene.meshes[1].file, "/data/terrain.ply");
  EXPECT_EQ(scene.meshes[1].unit_m, 1.0);
  ASSERT_EQ(scene.regions.size(), 4u);
  EXPECT_EQ(scene.regions[0].name, "power_top");
  EXPECT_EQ(scene.regions[0].material, 0u);
  EXPECT_FALSE(scene.regions[0].temperature);
  EXPECT_EQ(scene.regions[1].name, "tent");
  EXPECT_EQ(scene.regions[1].mesh_material, "cloth");
  EXPECT_FALSE(scene.regions[2].material);
  EXPECT_DOUBLE_EQ(value_at(scene.regions[2].temperature.value().schedule, 0.0), 303.15);
  EXPECT_EQ(scene.regions[3].name, "terrain");
  EXPECT_EQ(scene.regions[3].mesh, 1u);
  EXPECT_EQ(scene.regions[3].temperature.value().table, folder.file("facets.csv"));
  EXPECT_EQ(scene.ground.value().material, 1u);
  EXPECT_EQ(scene.camera.value().position_m, (std::array{14.0, -12.0, 5.0}));
  EXPECT_DOUBLE_EQ(scene.camera.value().look_at_m[2], 1.2);
  EXPECT_EQ(scene.text, scene_text());
  EXPECT_EQ(scene.sha256.size(), 64u);
}

TEST(SceneFile, EveryKindOfInside) {
  const SceneFolder folder;
  const std::string film = "{ kind = \"film\", h = \"10 W/m2/K\", temperature = \"engine.csv\" }";
  const auto inside = [&](const std::string& text) {
    const SceneResult result = folder.parse(replaced(scene_text(), film, text));
    EXPECT_TRUE(result.ok()) << text << "\n" << all_of(result);
    return result.ok() ? result.scene.materials[0].inside : Inside{};
  };
  EXPECT_EQ(inside("{ kind = \"adiabatic\" }").kind, InsideKind::adiabatic);
  EXPECT_DOUBLE_EQ(inside("{ kind = \"fixed\", temperature = \"20 degC\" }").temperature.value.at(0), 293.15);
  EXPECT_EQ(inside("{ kind = \"flux\", flux = \"-20 W/m2\" }").flux.value.at(0), -20.0);
  EXPECT_EQ(value_at(inside("{ kind = \"flux\", flux = \"heater.csv\" }").flux, instant_of({2016, 1, 1}, 3.0 * 3600.0)),
            50.0);
  EXPECT_EQ(inside("{ kind = \"sheet\", emissivity = 0.4 }").back_emissivity.value().value, 0.4);
  EXPECT_DOUBLE_EQ(inside("{ kind = \"pair\", thickness = \"5 cm\" }").thickness_m.value(), 0.05);
  EXPECT_FALSE(inside("{ kind = \"pair\" }").thickness_m);
}

/// `emissivity` is that along the normal; the balance has what goes to all sides.
TEST(SceneFile, EmissivityByAngle) {
  const SceneFolder folder;
  folder.write("angles.csv", "angle_deg,relative\n0,1\n60,0.9\n90,0\n");
  const auto soil_with = [&](const std::string& keys) {
    std::string text = scene_text();
    const std::string line = "emissivity = 0.95\n";
    text.insert(text.find(line) + line.size(), keys);
    return folder.parse(text);
  };
  const SceneResult schlick = soil_with("schlick_exponent = 5\ngloss = 0.3\n");
  ASSERT_TRUE(schlick.ok()) << all_of(schlick);
  const MaterialSection& soil = schlick.scene.materials[1];
  EXPECT_EQ(soil.emissivity.along_normal, 0.95);
  EXPECT_NEAR(soil.emissivity.value, 0.95 * (1.0 - 2.0 / 42.0), 1e-5);
  EXPECT_EQ(soil.gloss, 0.3);
  EXPECT_NEAR(relative_emissivity(soil.by_angle, 0.5), 1.0 - std::pow(0.5, 5), 1e-5);
  const SceneResult table = soil_with("emissivity_angles = \"angles.csv\"\n");
  ASSERT_TRUE(table.ok()) << all_of(table);
  EXPECT_NEAR(relative_emissivity(table.scene.materials[1].by_angle, 0.5), 0.9, 1e-4);
  expect_says(all_of(soil_with("schlick_exponent = 5\nrefractive_index = 1.5\n")), {"exclude each other"});
  expect_says(all_of(soil_with("gloss = 1.5\n")), {"gloss"});
  folder.write("angles.csv", "angle_deg,relative\n0,1\n60,1.2\n");
  expect_says(all_of(soil_with("emissivity_angles = \"angles.csv\"\n")), {"above 1"});
}

/// The day that a fit compares with may be the weather's own long wave.
TEST(SceneFile, TheNoiseOfAMeasuredDayMayStandAlone) {
  const SceneFolder folder;
  const SceneResult result = folder.parse(scene_text() + "[measured]\nsd = \"0.3 K\"\n");
  ASSERT_TRUE(result.ok()) << all_of(result);
  EXPECT_EQ(result.scene.measured->sd_k, 0.3);
  EXPECT_TRUE(result.scene.measured->temperature.value.empty());
}

TEST(SceneFile, TimesMayHaveZonesAndQuotes) {
  const SceneFolder folder;
  for (const char* start : {"2016-01-01T01:00:00+01:00", "2015-12-31 19:00:00-05:00", "\"2016-01-01T00:00Z\""}) {
    const SceneResult result = folder.parse(replaced(scene_text(), "2016-01-01T00:00:00Z", start));
    ASSERT_TRUE(result.ok()) << start << all_of(result);
    EXPECT_EQ(result.scene.time.start_s, instant_of({2016, 1, 1})) << start;
  }
}

TEST(SceneFile, ConstantWeather) {
  const SceneFolder folder;
  const SceneResult result = folder.parse(replaced(scene_text(), "file = \"weather.csv\"",
                                                   "air_temperature = \"15 degC\"\nwind_speed = \"10.8 km/h\"\n"
                                                   "relative_humidity = \"50 %\"\ndirect_normal = \"800 W/m2\"\n"
                                                   "longwave_down = \"300 W/m2\""));
  ASSERT_TRUE(result.ok()) << all_of(result);
  const auto series = scene_weather(result.scene);
  EXPECT_TRUE(series.constant());
  const WeatherAt weather = weather_at(series, 0.0);
  EXPECT_DOUBLE_EQ(weather[air_temperature], 288.15);
  EXPECT_DOUBLE_EQ(weather[wind_speed], 3.0);
  EXPECT_DOUBLE_EQ(weather[vapour_pressure], 0.5 * radiometry::heat::saturation_pressure_pa(288.15));
  EXPECT_EQ(weather[direct_normal], 800.0);
}

TEST(SceneFile, WeatherIsReadAndPlacesAreCompared) {
  const SceneFolder folder;
  const auto series = scene_weather(folder.parse(scene_text()).scene);
  EXPECT_DOUBLE_EQ(value_at(series, air_temperature, instant_of({2016, 1, 1}, 10.0 * 3600.0)), 278.15);
  EXPECT_TRUE(series.has(global_horizontal)) << "closed by beam and diffuse";
  folder.write("weather.csv", surfrad_text(120));
  const std::string repeated = replaced(replaced(scene_text(), "stamp = \"instant\"\n", ""), "\"none\"", "\"day\"");
  const auto measured = scene_weather(folder.parse(repeated).scene);
  EXPECT_EQ(measured.repeat, radiometry::heat::Repeat::day);
  // Its numbers are made without a sun, which is down at that time.
  ASSERT_EQ(measured.warnings.size(), 2u);
  expect_says(measured.warnings[0], {"global_horizontal contradicts"});
  expect_says(measured.warnings[1], {"more light"});
  const auto means = scene_weather(folder.parse(replaced(repeated, "repeat", "average = \"5 min\"\nrepeat")).scene);
  // Minutes 1 to 5 of the file, whose beam rises by 1 W/m2 a minute from 800 W/m2.
  const double midnight = instant_of({2016, 1, 1});
  EXPECT_NEAR(mean_over(means, direct_normal, midnight, midnight + 300.0), 803.0, 1e-9);
  const auto elsewhere = scene_weather(folder.parse(replaced(repeated, "37.70 deg", "47.70 deg")).scene);
  ASSERT_EQ(elsewhere.warnings.size(), 3u);
  expect_says(elsewhere.warnings[2], {"10 deg away from [place]"});
}

TEST(SceneFile, WeatherOfAFileIsChanged) {
  const SceneFolder folder;
  const auto with = [&](const std::string& keys) {
    return folder.parse(replaced(scene_text(), "stamp = \"instant\"\n", "stamp = \"instant\"\n" + keys));
  };
  const auto plain = scene_weather(folder.parse(scene_text()).scene);
  const SceneResult result = with(
      "air_temperature_offset = \"-7 K\"\nwind_speed_factor = 0.5\nsolar_factor = \"40 %\"\n"
      "longwave_down_offset = \"20 W/m2\"\n");
  ASSERT_TRUE(result.ok()) << all_of(result);
  const auto changed = scene_weather(result.scene);
  ASSERT_EQ(changed.node_s, plain.node_s);
  for (std::size_t q = 0; q < radiometry::heat::kQuantities; ++q) {
    const auto quantity = static_cast<radiometry::heat::WeatherQuantity>(q);
    ASSERT_EQ(changed.has(quantity), plain.has(quantity));
    const bool sun = quantity == direct_normal || quantity == diffuse_horizontal || quantity == global_horizontal;
    const double factor = quantity == wind_speed ? 0.5 : sun ? 0.4 : 1.0;
    const double offset = quantity == air_temperature ? -7.0 : quantity == longwave_down ? 20.0 : 0.0;
    for (std::size_t i = 0; i < plain.value[q].size(); ++i)
      // A closed column is closed after the change: sums of numbers up to 1500.
      EXPECT_NEAR(changed.value[q][i], factor * plain.value[q][i] + offset, 1e-9)
          << quantity_name(quantity) << " " << i;
  }
  expect_says(all_of(with("wind_speed_factor = -1\n")), {"outside [0, 20]"});
  EXPECT_TRUE(says(all_of(with("air_temperature_offset = \"20 degC\"\n")), "outside [-60, 60]")) << "a point";
  expect_refused({"factors of [weather]:"},
                 [&] { scene_weather(with("longwave_down_offset = \"-300 W/m2\"\n").scene); });
  const std::string constant =
      replaced(scene_text(), "file = \"weather.csv\"", "wind_speed = \"3 m/s\"\nsolar_factor = 0.5");
  expect_says(all_of(folder.parse(constant)), {"weather.solar_factor:", "of a file"});
}

TEST(SceneFile, SkyModels) {
  WeatherAt weather;
  weather.value.fill(std::nan(""));
  const auto set = [&](radiometry::heat::WeatherQuantity q, double value) {
    weather.value[static_cast<std::size_t>(q)] = value;
  };
  set(air_temperature, 290.0);
  set(vapour_pressure, 1000.0);
  set(longwave_down, 330.0);
  set(cloud_cover, 0.5);
  using radiometry::heat::SkyModel;
  const double brunt = clear_sky_longwave_w_m2(SkyModel::brunt, 290.0, 1000.0);
  EXPECT_EQ(sky_longwave({}, weather).irradiance_w_m2, 330.0);
  EXPECT_EQ(sky_longwave({.longwave = LongwaveModel::brunt}, weather).irradiance_w_m2, brunt);
  EXPECT_DOUBLE_EQ(sky_longwave({LongwaveModel::brunt, CloudSource::constant, 0.3}, weather).irradiance_w_m2,
                   brunt * radiometry::heat::cloud_factor(0.3));
  EXPECT_EQ(sky_longwave({LongwaveModel::brunt, CloudSource::from_weather}, weather).cloud_cover, 0.5);
  // The cover that is taken from the measured long wave gives it back.
  EXPECT_NEAR(sky_longwave({LongwaveModel::brunt, CloudSource::from_longwave}, weather).irradiance_w_m2, 330.0, 1e-9);
  EXPECT_GT(sky_longwave({LongwaveModel::measured, CloudSource::from_longwave}, weather).cloud_cover, 0.3);
  EXPECT_GT(sky_longwave({.longwave = LongwaveModel::swinbank}, weather).irradiance_w_m2, 250.0);
  EXPECT_THROW(sky_longwave({.longwave = LongwaveModel::atmosphere}, weather), mtf::UsageError);
  set(vapour_pressure, std::nan(""));
  expect_says(message_of([&] { sky_longwave({.longwave = LongwaveModel::brunt}, weather); }),
              {"needs vapour_pressure"});
}

TEST(SceneFile, PlanckMeans) {
  const auto constant = radiometry::make_spectrum("test", {3.0, 14.0}, {0.8, 0.8});
  EXPECT_NEAR(planck_mean(constant, 300.0), 0.8, 1e-12);
  // Bands by the blackbody's own shares; between and beyond the bands the nearer end holds, on a straight line.
  const SceneFolder folder;
  const double all = radiometry::kStefanBoltzmann_w_m2_k4 * std::pow(300.0, 4) / std::numbers::pi;
  const auto share = [&](double lo, double hi) {
    return radiometry::band_radiance(radiometry::Flux::watts, lo, hi, 300.0) / all;
  };
  const SceneResult result = folder.parse(scene_text());
  const double bands = result.scene.materials[2].emissivity.value;
  double between = 0.0;
  for (int i = 0; i < 30000; ++i) {
    const double l = 5.0 + (i + 0.5) * 1e-4;
    between += (0.5 + 0.45 * (l - 5.0) / 3.0) * radiometry::planck(radiometry::Flux::watts, l, 300.0) * 1e-4 / all;
  }
  EXPECT_NEAR(bands, 0.5 * share(0.0, 5.0) + between + 0.95 * share(8.0, 1e9), 2e-6);
  // A spectrum against a plain sum over the wavelength.
  const radiometry::Spectrum paint = result.scene.materials[0].emissivity.spectrum.value();
  double sum = 0.6 * share(0.0, 3.0) + 0.95 * share(14.0, 1e9);
  for (int i = 0; i < 110000; ++i) {
    const double l = 3.0 + (i + 0.5) * 1e-4;
    sum += radiometry::evaluate(paint, l) * radiometry::planck(radiometry::Flux::watts, l, 300.0) * 1e-4 / all;
  }
  EXPECT_NEAR(planck_mean(paint, 300.0), sum, 2e-6);
}

TEST(SceneFile, DemoReadsBack) {
  const SceneFolder folder;
  folder.write("weather.csv", demo_weather_text());
  folder.write("engine.csv", demo_engine_text());
  const SceneResult result = folder.parse(demo_scene_text());
  ASSERT_TRUE(result.ok()) << all_of(result);
  EXPECT_TRUE(result.diagnostics.empty()) << all_of(result);
  ASSERT_EQ(result.scene.regions.size(), 5u);
  std::string names;
  for (const RegionSection& region : result.scene.regions) names += region.name + " ";
  EXPECT_EQ(names, "firing_part driving_part power_top others terrain ");
  const auto series = scene_weather(result.scene);
  EXPECT_TRUE(series.warnings.empty());
  const TimeSection& time = result.scene.time;
  EXPECT_NO_THROW(
      require(series, {air_temperature, wind_speed, vapour_pressure, direct_normal, diffuse_horizontal, longwave_down},
              time.start_s, time.end_s));
  const auto& deck = result.scene.materials[1].inside.temperature;
  EXPECT_EQ(deck.time_s.front(), time.start_s);
  EXPECT_EQ(deck.time_s.back(), time.end_s);
}

TEST(SceneFile, LoadsFromDisk) {
  const SceneFolder folder;
  folder.write("scene.toml", scene_text() +
                                 "[[material]]\nname = \"spare\"\nsolar_absorptance = 0.5\nemissivity = 0.5\n"
                                 "layers = [{ conductivity = \"1 W/m/K\", density = \"1 kg/m3\", heat_capacity = "
                                 "\"1 J/kg/K\", thickness = \"1 m\" }]\n");
  std::vector<mtf::io::Diagnostic> warnings;
  EXPECT_EQ(load_scene(folder.file("scene.toml"), &warnings).materials.size(), 4u);
  ASSERT_EQ(warnings.size(), 1u);
  expect_says(warnings[0].text, {"no region"});
  EXPECT_THROW(load_scene(folder.file("other.toml")), mtf::RuntimeError);
}

}  // namespace
}  // namespace apps::scene
