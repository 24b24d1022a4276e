// SPDX-License-Identifier: Apache-2.0
#include "radiometry/atmosphere/atmosphere_settings.h"

#include <cmath>
#include <numbers>

#include "mtf/error.h"

namespace radiometry {

using namespace atmosphere;

namespace {

constexpr double kMostVapour_ppm = 5e5, kRainTop_m = 6000.0;
constexpr double kNear_m = 500.0;  // from a single level, whose air is taken all along a horizontal line
constexpr ModelAtmosphere kGasesOfProfiles = ModelAtmosphere::us_standard_1976;

/// Runs `action`; what the model refuses is said of the table.
template <class Action>
auto of_table(const Action& action) {
  try {
    return action();
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError(std::string("[atmosphere]: ") + error.what());
  }
}

void require_one_source(const AtmosphereSettings& s) {
  if (s.pressure_pa) {
    if (s.model || !s.profile.empty())
      throw mtf::UsageError(std::string("atmosphere.pressure: given together with ") + (s.model ? "model" : "profile") +
                            ", which has pressures; remove it, or give the air of a horizontal line by pressure, "
                            "temperature and relative_humidity alone");
    if (!s.temperature_k || !s.relative_humidity)
      throw mtf::UsageError("atmosphere.pressure: needs temperature and relative_humidity beside it");
    return;
  }
  if (!s.model && s.profile.empty() && s.temperature_k && s.relative_humidity)
    throw mtf::UsageError(
        "atmosphere.pressure: missing beside temperature and relative_humidity, for example \"1013 hPa\"; or give "
        "model, whose lowest air they change");
  if (!s.model && s.profile.empty())
    throw mtf::UsageError(
        "[atmosphere]: says nothing of the air; write for example model = \"mid_latitude_summer\", or pressure, "
        "temperature and relative_humidity");
}

Profile<double> profile_of(const AtmosphereSettings& s, const std::optional<Profile<double>>& given) {
  const double carbon_dioxide_ppm = s.carbon_dioxide_ppm.value_or(kCarbonDioxide_ppm);
  if (s.pressure_pa)
    return surface_air(*s.pressure_pa, *s.temperature_k, 100.0 * *s.relative_humidity, carbon_dioxide_ppm);
  const bool by_file = given && !s.profile.empty();
  if (by_file && given->levels.size() == 1 &&
      std::abs(given->levels.front().altitude_m - s.sensor_altitude_m) > kNear_m)
    throw mtf::UsageError("atmosphere.profile: " + given->source + " has one level, at " +
                          mtf::format_double(given->levels.front().altitude_m) +
                          " m, which is the air of a horizontal line there; sensor_altitude is " +
                          mtf::format_double(s.sensor_altitude_m) + " m: give that altitude, or levels around it");
  Profile<double> profile = by_file ? *given : model_profile(s.model.value_or(kGasesOfProfiles), carbon_dioxide_ppm);
  if (by_file && s.carbon_dioxide_ppm) profile = with_carbon_dioxide(std::move(profile), *s.carbon_dioxide_ppm);
  if (!s.temperature_k && !s.relative_humidity) return profile;
  const Level<double>& lowest = profile.levels.front();
  const double humidity_percent =
      s.relative_humidity ? 100.0 * *s.relative_humidity : relative_humidity_percent(lowest);
  return with_surface(std::move(profile), s.temperature_k.value_or(lowest.temperature_k), humidity_percent);
}

}  // namespace

Air<double> air_of(const AtmosphereSettings& s, const std::optional<Profile<double>>& profile) {
  require_valid("atmosphere", s);
  require_one_source(s);
  if (s.haze == HazeKind::none && s.season)
    throw mtf::UsageError("atmosphere.season: needs haze; write for example haze = \"rural\"");
  if (s.haze == HazeKind::none && s.visibility_m)
    throw mtf::UsageError(
        "atmosphere.visibility: needs haze, which says what limits it; write for example haze = \"rural\"");
  return of_table([&] {
    Air<double> air{.profile = profile_of(s, profile)};
    air.haze = {.kind = s.haze,
                .visibility_m = s.visibility_m.value_or(usual_visibility_m(s.haze)),
                .season = s.season.value_or(s.model ? season_of(*s.model) : Season::spring_summer)};
    air.rain_mm_h = s.rain_mm_h;
    require_valid(air);
    if (air.rain_mm_h > 0.0)
      for (const Level<double>& level : air.profile.levels)
        if (level.altitude_m < kRainTop_m && water_ppm(level.pressure_pa, level.temperature_k, 100.0) > kMostVapour_ppm)
          throw mtf::UsageError("rain saturates the air, and that of " + mtf::format_double(level.temperature_k) +
                                " K at " + mtf::format_double(level.pressure_pa) +
                                " Pa would be mostly vapour; give other air or no rain");
    return air;
  });
}

std::optional<Sight<double>> sight_of(const AtmosphereSettings& s) {
  const double from_m = s.sensor_altitude_m;
  const double zenith_rad = s.zenith_deg.value_or(0.0) * std::numbers::pi / 180.0;
  if (s.target_altitude_m) {
    if (s.zenith_deg && s.range_m)
      throw mtf::UsageError(
          "atmosphere.target_altitude: given together with zenith_angle and range, which say where the line ends; "
          "remove one of the three");
    if (s.range_m) return Between<double>{from_m, *s.target_altitude_m, *s.range_m};
    if (s.zenith_deg && *s.target_altitude_m == from_m)
      throw mtf::UsageError(
          "atmosphere.target_altitude: the same as sensor_altitude, so that zenith_angle says no length; give range in "
          "place of zenith_angle");
    if (s.zenith_deg) return ToAltitude<double>{from_m, zenith_rad, *s.target_altitude_m};
    throw mtf::UsageError(
        "atmosphere.target_altitude: needs range or zenith_angle beside it; ranges of targets (mtf range) need range");
  }
  if (s.zenith_deg && s.range_m) return AtAngle<double>{from_m, zenith_rad, *s.range_m};
  if (s.range_m) return Horizontal<double>{from_m, *s.range_m};
  if (s.zenith_deg) return ToSpace<double>{from_m, zenith_rad};
  return std::nullopt;
}

}  // namespace radiometry
