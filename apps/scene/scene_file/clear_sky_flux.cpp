// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/scene_file/clear_sky_flux.h"

#include <algorithm>
#include <cmath>

#include "apps/sensor/sensor_air.h"
#include "mtf/error.h"
#include "radiometry/atmosphere/sky_radiance.h"
#include "radiometry/light/constants.h"

namespace apps::scene {

namespace air = radiometry::atmosphere;

namespace {

constexpr double kStep_k = 5.0;
constexpr double kBelow_m = 500.0;  // that a place may lie below the lowest altitude of the air
constexpr double kMostHumid_percent = 150.0;
constexpr int kHumidities = 20;  // steps of ln(1 + RH / 1 %), in which the flux is nearly straight
constexpr double kColdest_k = 180.0, kWarmest_k = 340.0;
constexpr int kAngles = 4;  // Gauss's nodes over the cosine of the zenith angle: within 0.1 W/m2 of eight

/// The levels from an altitude on.
air::Profile<double> above(const air::Profile<double>& profile, double altitude_m) {
  air::Profile<double> cut{.source = profile.source, .levels = {level_at(profile, altitude_m)}};
  for (const air::Level<double>& level : profile.levels)
    if (level.altitude_m > altitude_m + 1.0) cut.levels.push_back(level);
  return cut;
}

double percent_of(int node) { return std::min(std::expm1(std::log(101.0) * node / kHumidities), 100.0); }

double humidity_percent(double air_k, double vapour_pressure_pa) {
  const double saturated_pa = 1e6 * air::saturation_per_cm3(air_k) * radiometry::kBoltzmann_j_k * air_k;
  const double percent = 100.0 * vapour_pressure_pa / saturated_pa;
  if (percent > kMostHumid_percent)
    throw mtf::UsageError("[sky] longwave = \"atmosphere\": a vapour pressure of " +
                          mtf::format_double(vapour_pressure_pa) + " Pa in air of " + mtf::format_double(air_k) +
                          " K is a humidity of " + mtf::format_double(std::round(percent)) +
                          " %; check the units of both in [weather]");
  return std::min(percent, 100.0);
}

}  // namespace

air::Air<double> air_above(const radiometry::AtmosphereSettings& settings, double altitude_m) {
  if (settings.pressure_pa)
    throw mtf::UsageError(
        "atmosphere.pressure: is the air of a horizontal line; the sky needs model or profile, whose lowest part "
        "follows the weather");
  if (settings.temperature_k || settings.relative_humidity || settings.target_altitude_m || settings.zenith_deg ||
      settings.range_m || settings.sensor_altitude_m != 0.0)
    throw mtf::UsageError(
        "[atmosphere]: of a scene it is the air alone; remove temperature, relative_humidity, sensor_altitude, "
        "target_altitude, zenith_angle and range, which weather and camera give");
  air::Air<double> through = read_air(settings);
  const double lowest_m = through.profile.levels.front().altitude_m;
  if (altitude_m < lowest_m - kBelow_m)
    throw mtf::UsageError("atmosphere.profile: begins at " + mtf::format_double(lowest_m) +
                          " m, above the altitude of [place]; add the air below");
  through.profile = above(through.profile, std::max(altitude_m, lowest_m));
  return through;
}

ClearSkyFlux::ClearSkyFlux(const radiometry::AtmosphereSettings& settings, double altitude_m)
    : air_(air_above(settings, altitude_m)) {}

double ClearSkyFlux::node(int temperature, int humidity) {
  const auto known = nodes_.find({temperature, humidity});
  if (known != nodes_.end()) return known->second;
  air::Air<double> today = air_;
  today.profile = with_surface(air_.profile, kStep_k * temperature, percent_of(humidity));
  const double flux = sky_flux(today, today.profile.levels.front().altitude_m, kAngles).total_w_m2;
  nodes_.emplace(std::pair{temperature, humidity}, flux);
  return flux;
}

air::Air<double> ClearSkyFlux::air_at(double air_k, std::optional<double> vapour_pressure_pa) const {
  air::Air<double> today = air_;
  const double humidity = vapour_pressure_pa ? humidity_percent(air_k, *vapour_pressure_pa)
                                             : relative_humidity_percent(air_.profile.levels.front());
  today.profile = with_surface(air_.profile, air_k, humidity);
  return today;
}

double ClearSkyFlux::at(double air_k, double vapour_pressure_pa) {
  if (!(air_k >= kColdest_k && air_k <= kWarmest_k))
    throw mtf::UsageError("[sky] longwave = \"atmosphere\": air of " + mtf::format_double(air_k) +
                          " K; the model is for " + mtf::format_double(kColdest_k) + " to " +
                          mtf::format_double(kWarmest_k) + " K");
  if (!(vapour_pressure_pa >= 0.0))
    throw mtf::UsageError("[sky] longwave = \"atmosphere\": a vapour pressure of " +
                          mtf::format_double(vapour_pressure_pa) + " Pa; it has to be 0 or above");
  const double t = air_k / kStep_k;
  const double h = kHumidities * std::log1p(humidity_percent(air_k, vapour_pressure_pa)) / std::log(101.0);
  const int t0 = static_cast<int>(t), h0 = std::min(static_cast<int>(h), kHumidities - 1);
  const double dt = t - t0, dh = h - h0;
  const double dry = (1.0 - dt) * node(t0, h0) + dt * node(t0 + 1, h0);
  const double humid = (1.0 - dt) * node(t0, h0 + 1) + dt * node(t0 + 1, h0 + 1);
  return (1.0 - dh) * dry + dh * humid;
}

}  // namespace apps::scene
