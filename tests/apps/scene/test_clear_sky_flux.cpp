// SPDX-License-Identifier: Apache-2.0

// The long wave of the clear sky by the band model, for the weather at the ground.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "apps/scene/scene_file/scene_file.h"
#include "apps/scene/weather/weather_file.h"
#include "mtf/error.h"
#include "radiometry/atmosphere/sky_radiance.h"
#include "radiometry/light/constants.h"
#include "radiometry/weather/sky.h"
#include "tests/apps/scene/weather_texts.h"

namespace apps::scene {
namespace {

namespace air = radiometry::atmosphere;

const radiometry::AtmosphereSettings kSummer{.model = air::ModelAtmosphere::mid_latitude_summer};

double vapour_pa(double air_k, double humidity) {
  return humidity * 1e6 * air::saturation_per_cm3(air_k) * radiometry::kBoltzmann_j_k * air_k;
}

// Between its nodes and with fewer angles than the model's own flux: 0.5 W/m2, as the header says.
TEST(ClearSkyFlux, is_the_flux_of_the_model_with_the_weather_at_the_ground) {
  ClearSkyFlux sky(kSummer, 0.0);
  for (const double kelvin : {271.3, 292.4})
    for (const double humidity : {0.05, 0.37, 0.96}) {
      air::Air<double> today = air_of(kSummer);
      today.profile = with_surface(today.profile, kelvin, 100.0 * humidity);
      EXPECT_NEAR(sky.at(kelvin, vapour_pa(kelvin, humidity)), sky_flux(today, 0.0).total_w_m2, 0.5)
          << kelvin << " K, " << humidity;
    }
}

TEST(ClearSkyFlux, rises_with_humidity_and_stays_below_a_black_sky) {
  ClearSkyFlux sky(kSummer, 0.0);
  const double dry = sky.at(290.0, vapour_pa(290.0, 0.1)), humid = sky.at(290.0, vapour_pa(290.0, 0.9));
  EXPECT_LT(dry, humid);
  EXPECT_LT(humid, radiometry::kStefanBoltzmann_w_m2_k4 * std::pow(290.0, 4));
  // A little more vapour than the air can hold is held at saturation, as in fog.
  EXPECT_EQ(sky.at(290.0, vapour_pa(290.0, 1.08)), sky.at(290.0, vapour_pa(290.0, 1.0)));
}

// Less air above a mountain: under it the sky of the same weather is colder.
TEST(ClearSkyFlux, begins_at_the_altitude_of_the_place) {
  ClearSkyFlux low(kSummer, 0.0), high(kSummer, 2317.0);
  EXPECT_LT(high.at(285.0, 800.0), low.at(285.0, 800.0));
}

// A winter day at Alamosa (SURFRAD, 2317 m, -22 to -4 C), clear but for a cloud at 3 UTC, at even hours, with
// temperature, humidity and pressure of the station: the model lies 2 to 16 W/m2 above the pyrgeometer, of whose
// measurements it knows nothing, and Brutsaert's formula, good to 10 to 30 W/m2, 11 to 44 W/m2 below it.
TEST(ClearSkyFlux, against_a_measured_day) {
  const std::string path = test::shared_weather("surfrad-slv16001.dat");
  if (path.empty()) GTEST_SKIP() << "no shared data";
  const auto weather = read_weather(path).weather;
  using enum radiometry::heat::WeatherQuantity;
  ClearSkyFlux sky({.model = air::ModelAtmosphere::mid_latitude_winter}, 2317.0);
  double least = 1e9, most = -1e9, brutsaert_least = 1e9, brutsaert_most = -1e9;
  for (std::size_t i = 0; i < weather.time_s.size(); i += 120) {
    const double kelvin = weather[air_temperature][i], vapour = weather[vapour_pressure][i];
    const double model = sky.at(kelvin, vapour) - weather[longwave_down][i];
    const double formula =
        radiometry::heat::clear_sky_longwave_w_m2(radiometry::heat::SkyModel::brutsaert, kelvin, vapour) -
        weather[longwave_down][i];
    least = std::min(least, model), most = std::max(most, model);
    brutsaert_least = std::min(brutsaert_least, formula), brutsaert_most = std::max(brutsaert_most, formula);
  }
  std::printf("less measured: model %.1f ... %.1f, Brutsaert %.1f ... %.1f W/m2\n", least, most, brutsaert_least,
              brutsaert_most);
  EXPECT_GT(least, 0.0);
  EXPECT_LT(most, 20.0);
  EXPECT_LT(most, -brutsaert_least);
}

TEST(ClearSkyFlux, refusals) {
  ClearSkyFlux sky(kSummer, 0.0);
  EXPECT_THROW(sky.at(400.0, 1000.0), mtf::UsageError);
  EXPECT_THROW(sky.at(std::nan(""), 1000.0), mtf::UsageError);
  EXPECT_THROW(sky.at(290.0, std::nan("")), mtf::UsageError);
  EXPECT_THROW(sky.at(290.0, vapour_pa(290.0, 1.6)), mtf::UsageError);
  EXPECT_THROW(ClearSkyFlux({.pressure_pa = 1e5, .temperature_k = 290.0, .relative_humidity = 0.5}, 0.0),
               mtf::UsageError);
  EXPECT_THROW(ClearSkyFlux(kSummer, 200e3), mtf::UsageError);
  SceneFile scene;
  EXPECT_FALSE(clear_sky_of(scene));
  scene.sky.longwave = LongwaveModel::atmosphere;
  EXPECT_THROW(clear_sky_of(scene), mtf::UsageError);
  scene.atmosphere = kSummer;
  EXPECT_TRUE(clear_sky_of(scene));
}

}  // namespace
}  // namespace apps::scene
