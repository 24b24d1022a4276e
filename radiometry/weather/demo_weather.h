// SPDX-License-Identifier: Apache-2.0
#pragma once

// Weather of our own making, for examples that have to run without measured data: a cloudless dry day. It is a model,
// not a measurement. With h the local solar hour (UTC + longitude / 15 deg):
//   sun             Bird and Hulstrom's clear sky (clear_sky.h) at the true position of the sun
//   air             mean + swing cos(2 pi (h - 15) / 24), warmest at 15 h
//   vapour          constant, the saturation pressure of a dew point (but no more than 95 % of saturation)
//   wind            mean + swing cos(2 pi (h - 14) / 24), never below 0.5 m/s
//   pressure        of the standard atmosphere at the altitude
//   long wave       Brutsaert's clear sky of that air

#include "radiometry/weather/clear_sky.h"
#include "radiometry/weather/sun.h"
#include "radiometry/weather/weather.h"

namespace radiometry::heat {

struct DemoClimate {
  double mean_temperature_k = 288.15, temperature_swing_k = 8.0;
  double dew_point_k = 276.15;
  double mean_wind_m_s = 3.0, wind_swing_m_s = 1.5;
  ClearSkyAir air{};  ///< its pressure is replaced by that of the altitude
};

/// Instants from `begin_s` to `end_s`, both included, every `step_s` (a divisor of the span). All quantities but the
/// cloud cover. Throws UsageError.
Weather demo_weather(const Place& place, double begin_s, double end_s, double step_s, const DemoClimate& climate = {});

}  // namespace radiometry::heat
