// SPDX-License-Identifier: Apache-2.0
#include "radiometry/weather/demo_weather.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mtf/error.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sky.h"

namespace radiometry::heat {
namespace {

constexpr double kPi = std::numbers::pi;

/// Cosine of a day that has its maximum at `hour`, local solar time.
double daily(double utc_s, const Place& place, double hour) {
  const double solar_day = utc_s / kDay_s + place.longitude_rad / (2.0 * kPi);
  return std::cos(2.0 * kPi * (solar_day - hour / 24.0));
}

}  // namespace

Weather demo_weather(const Place& place, double begin_s, double end_s, double step_s, const DemoClimate& climate) {
  constexpr double kWarmest_h = 15.0, kWindiest_h = 14.0, kLeastWind_m_s = 0.5, kMostHumid = 0.95, kMostRecords = 1e6;
  const double steps = std::round((end_s - begin_s) / step_s);
  if (!(step_s > 0.0 && steps >= 1.0 && steps < kMostRecords))
    throw mtf::UsageError("demo_weather: the step has to fit into the span, at most a million times");
  if (std::abs(begin_s + steps * step_s - end_s) > 1e-6 * step_s)
    throw mtf::UsageError("demo_weather: the step is no divisor of the span");
  ClearSkyAir air = climate.air;
  air.pressure_pa = standard_pressure_pa(place.altitude_m);

  Weather weather{.source = "demo weather", .stamp = Stamp::instant};
  for (int i = 0; i <= static_cast<int>(steps); ++i) {
    const double t = begin_s + i * step_s;
    const SunPosition sun = sun_position(t, place);
    const SolarIrradiance solar = clear_sky(air, sun.zenith_rad, extraterrestrial_normal_w_m2(sun));
    const double temperature = climate.mean_temperature_k + climate.temperature_swing_k * daily(t, place, kWarmest_h);
    const double vapour =
        std::min(saturation_pressure_pa(climate.dew_point_k), kMostHumid * saturation_pressure_pa(temperature));
    weather.time_s.push_back(t);
    const auto add = [&](WeatherQuantity quantity, double value) { weather[quantity].push_back(value); };
    using enum WeatherQuantity;
    add(air_temperature, temperature);
    add(wind_speed,
        std::max(kLeastWind_m_s, climate.mean_wind_m_s + climate.wind_swing_m_s * daily(t, place, kWindiest_h)));
    add(vapour_pressure, vapour);
    add(pressure, air.pressure_pa);
    add(direct_normal, solar.direct_normal_w_m2);
    add(diffuse_horizontal, solar.diffuse_horizontal_w_m2);
    add(global_horizontal, solar.global_horizontal_w_m2);
    add(longwave_down, clear_sky_longwave_w_m2(SkyModel::brutsaert, temperature, vapour));
  }
  check_weather(weather);
  return weather;
}

}  // namespace radiometry::heat
