// SPDX-License-Identifier: Apache-2.0
#pragma once

// Short records of weather at one place.

#include <numbers>
#include <utility>
#include <vector>

#include "radiometry/weather/instant.h"
#include "radiometry/weather/weather_series.h"

namespace radiometry::heat::test {

inline constexpr double kDegree = std::numbers::pi / 180.0;
inline const Place kAlamosa{37.70 * kDegree, -105.92 * kDegree, 2317.0};
inline const double kBegin = instant_of({2016, 1, 1});

/// From kBegin on, an hour or `step` seconds apart.
inline Weather hourly(Stamp stamp, std::vector<double> temperature, double step = 3600.0) {
  Weather weather{.source = "test.csv", .stamp = stamp, .time_s = {}, .values = {}};
  for (std::size_t i = 0; i < temperature.size(); ++i)
    weather.time_s.push_back(kBegin + (static_cast<double>(i) + (stamp == Stamp::end ? 1.0 : 0.0)) * step);
  weather[WeatherQuantity::air_temperature] = std::move(temperature);
  return weather;
}

}  // namespace radiometry::heat::test
