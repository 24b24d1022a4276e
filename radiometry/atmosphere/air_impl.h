// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bodies of air.h for any scalar: derivatives.h includes this for others than double.

#include <algorithm>
#include <cmath>

#include "mtf/math/special.h"
#include "radiometry/atmosphere/air.h"
#include "radiometry/atmosphere/band_model.h"

namespace radiometry::atmosphere {

using mtf::lift;
using mtf::value_of;

inline constexpr double kZero_c_k = 273.15, kStandard_pa = 101325.0;
inline constexpr double kMoleculesPerGramOfWater = 6.02214076e23 / 18.015;

/// What the checks see of a level.
struct LevelValues {
  double altitude_m = 0.0, pressure_pa = 0.0, temperature_k = 0.0;
  std::array<double, kGases> ppm{};
};
void require_valid_levels(const std::string& source, std::span<const LevelValues> levels);
void require_surface(double pressure_pa, double temperature_k, double relative_humidity_percent);
void require_carbon_dioxide(double ppm);
void require_altitude_inside(const std::string& source, double altitude_m, double lowest_m, double highest_m);
/// US standard 1976 at the ground.
Level<double> standard_ground(double carbon_dioxide_ppm);

template <class S>
void require_valid(const Profile<S>& profile) {
  std::vector<LevelValues> levels;
  levels.reserve(profile.levels.size());
  for (const Level<S>& level : profile.levels) {
    LevelValues values{level.altitude_m, value_of(level.pressure_pa), value_of(level.temperature_k), {}};
    std::ranges::transform(level.ppm, values.ppm.begin(), [](const S& ppm) { return value_of(ppm); });
    levels.push_back(values);
  }
  require_valid_levels(profile.source, levels);
}

template <class S>
Level<S> with_scalar(const Level<double>& level) {
  Level<S> out{
      .altitude_m = level.altitude_m, .pressure_pa = S(level.pressure_pa), .temperature_k = S(level.temperature_k)};
  std::ranges::transform(level.ppm, out.ppm.begin(), [](double ppm) { return S(ppm); });
  return out;
}

template <class S>
Profile<S> with_scalar(const Profile<double>& profile) {
  Profile<S> out{profile.source, {}};
  for (const Level<double>& level : profile.levels) out.levels.push_back(with_scalar<S>(level));
  return out;
}

template <class S>
Profile<S> with_carbon_dioxide(Profile<S> profile, const S& ppm) {
  require_carbon_dioxide(value_of(ppm));
  if (profile.levels.empty()) return profile;
  const S lowest = profile.levels.front()[Gas::carbon_dioxide];
  for (Level<S>& level : profile.levels)
    level[Gas::carbon_dioxide] = value_of(lowest) > 0.0 ? S(level[Gas::carbon_dioxide] / lowest * ppm) : ppm;
  return profile;
}

template <class S>
S saturation_per_cm3(const S& temperature_k) {
  using std::exp;
  const S a = kZero_c_k / temperature_k;
  return 1e-6 * kMoleculesPerGramOfWater * a * exp(18.9766 - 14.9595 * a - 2.43882 * a * a);
}

template <class S>
S air_per_cm3(const S& pressure_pa, const S& temperature_k) {
  return 2.6868e19 / kStandard_pa * kZero_c_k * pressure_pa / temperature_k;
}

template <class S>
S water_ppm(const S& pressure_pa, const S& temperature_k, const S& relative_humidity_percent) {
  return 1e4 * relative_humidity_percent * saturation_per_cm3(temperature_k) / air_per_cm3(pressure_pa, temperature_k);
}

template <class S>
S relative_humidity_percent(const Level<S>& level) {
  return 1e-4 * level[Gas::water] * air_per_cm3(level.pressure_pa, level.temperature_k) /
         saturation_per_cm3(level.temperature_k);
}

template <class S>
Profile<S> with_surface(Profile<S> profile, const S& temperature_k, const S& relative_humidity_percent) {
  using std::pow;
  constexpr double kFades_m = 2000.0;
  require_valid(profile);
  const Level<S> ground = profile.levels.front();
  require_surface(value_of(ground.pressure_pa), value_of(temperature_k), value_of(relative_humidity_percent));
  const S least(1e-9);  // percent: a model without any vapour at the ground has no quotient
  const S model_humidity = atmosphere::relative_humidity_percent(ground);
  const S quotient = relative_humidity_percent / (value_of(model_humidity) > value_of(least) ? model_humidity : least);
  for (Level<S>& level : profile.levels) {
    const double share = 1.0 - (level.altitude_m - ground.altitude_m) / kFades_m;
    if (share <= 0.0) break;
    S humidity = share == 1.0 ? relative_humidity_percent
                              : S(atmosphere::relative_humidity_percent(level) *
                                  (value_of(quotient) > 0.0 ? S(pow(quotient, share)) : S(0.0)));
    if (value_of(humidity) > 100.0) humidity = S(100.0);
    level.temperature_k = level.temperature_k + share * (temperature_k - ground.temperature_k);
    level[Gas::water] = water_ppm(level.pressure_pa, level.temperature_k, humidity);
  }
  return profile;
}

template <class S>
Profile<S> surface_air(const S& pressure_pa, const S& temperature_k, const S& relative_humidity_percent,
                       double carbon_dioxide_ppm) {
  require_surface(value_of(pressure_pa), value_of(temperature_k), value_of(relative_humidity_percent));
  Level<S> level = with_scalar<S>(standard_ground(carbon_dioxide_ppm));
  level.pressure_pa = pressure_pa;
  level.temperature_k = temperature_k;
  level[Gas::water] = water_ppm(pressure_pa, temperature_k, relative_humidity_percent);
  return {"surface air", {level}};
}

/// a at share 0, b at share 1; exponential, a straight line where one of them is 0.
template <class S>
S exponential_between(const S& a, const S& b, const S& share) {
  using std::exp, std::log;
  if (!(value_of(a) > 0.0) || !(value_of(b) > 0.0)) return a + share * (b - a);
  return a * exp(share * log(b / a));
}

template <class S>
Level<S> level_between(const Level<S>& below, const Level<S>& above, double altitude_m) {
  const S share((altitude_m - below.altitude_m) / (above.altitude_m - below.altitude_m));
  Level<S> level{.altitude_m = altitude_m,
                 .pressure_pa = exponential_between(below.pressure_pa, above.pressure_pa, share),
                 .temperature_k = below.temperature_k + share * (above.temperature_k - below.temperature_k)};
  for (std::size_t i = 0; i < kGases; ++i) level.ppm[i] = exponential_between(below.ppm[i], above.ppm[i], share);
  return level;
}

template <class S>
Level<S> level_at(const Profile<S>& profile, double altitude_m) {
  const auto& levels = profile.levels;
  if (levels.size() == 1) {
    Level<S> level = levels.front();
    level.altitude_m = altitude_m;
    return level;
  }
  require_altitude_inside(profile.source, altitude_m, levels.front().altitude_m, levels.back().altitude_m);
  const auto above = std::ranges::lower_bound(levels, altitude_m, {}, &Level<S>::altitude_m);
  if (above->altitude_m == altitude_m) return *above;
  return level_between(above[-1], *above, altitude_m);
}

void require_haze(double visibility_m, double rain_mm_h);

template <class S>
void require_valid(const Air<S>& air) {
  require_valid(air.profile);
  require_haze(value_of(air.haze.visibility_m), value_of(air.rain_mm_h));
}

/// Of values at 50, 23, 10, 5, 2 km (or the first of these): a straight line of 1 / V between neighbours; above 50 km
/// in proportion to 1 / V or constant; below the last the line of the last two goes on, or the value stays.
template <class S, std::size_t N>
S by_visibility(const S& visibility_m, const std::array<double, N>& values, bool beyond) {
  constexpr std::array<double, 5> kVisibility_m{50e3, 23e3, 10e3, 5e3, 2e3};
  if (value_of(visibility_m) >= kVisibility_m[0])
    return beyond ? S(values[0] * kVisibility_m[0] / visibility_m) : S(values[0]);
  if (!beyond && value_of(visibility_m) <= kVisibility_m[N - 1]) return S(values[N - 1]);
  std::size_t i = 1;
  while (i + 1 < N && value_of(visibility_m) < kVisibility_m[i]) ++i;
  const double a = 1.0 / kVisibility_m[i - 1], b = 1.0 / kVisibility_m[i];
  return values[i - 1] + (1.0 / visibility_m - a) / (b - a) * (values[i] - values[i - 1]);
}

/// Of values at rising altitudes in km; 0 outside of them.
template <class S, std::size_t N>
S by_altitude(double km, const std::array<double, N>& altitude_km, const std::array<S, N>& values) {
  if (km < altitude_km.front() || km > altitude_km.back()) return S(0.0);
  const auto above = std::upper_bound(altitude_km.begin() + 1, altitude_km.end() - 1, km);
  const auto i = static_cast<std::size_t>(above - altitude_km.begin());
  return exponential_between(values[i - 1], values[i], S((km - above[-1]) / (above[0] - above[-1])));
}

template <class S>
std::array<S, kAerosolRegions> aerosol_per_km(const Haze<S>& haze, double altitude_m) {
  std::array<S, kAerosolRegions> out{S(0.0), S(0.0), S(0.0), S(0.0)};
  if (haze.kind == HazeKind::none) return out;
  const double km = std::clamp(1e-3 * altitude_m, 0.0, 100.0);
  if (km < 3.0) {
    std::array<S, 4> ground;
    for (std::size_t z = 0; z < 3; ++z) {
      std::array<double, 5> values;
      for (std::size_t v = 0; v < 5; ++v) values[v] = boundary_aerosol(v, z);
      ground[z] = by_visibility(haze.visibility_m, values, true);
    }
    ground[3] = S(0.0);
    out[0] = by_altitude(km, {0.0, 1.0, 2.0, 3.0}, ground);
  }
  if (km > 2.0 && km < 11.0) {
    std::array<double, 10> altitude;
    std::array<S, 10> values;
    for (std::size_t z = 0; z < 10; ++z) {
      altitude[z] = 2.0 + static_cast<double>(z);
      values[z] = z == 0 || z == 9 ? S(0.0)
                                   : by_visibility(haze.visibility_m,
                                                   std::array{tropospheric_aerosol(haze.season, 0, z - 1),
                                                              tropospheric_aerosol(haze.season, 1, z - 1)},
                                                   false);
    }
    out[1] = by_altitude(km, altitude, values);
  }
  if (km > 10.0 && km < 35.0) {
    std::array<double, 18> altitude;
    std::array<S, 18> values;
    for (std::size_t z = 0; z < 16; ++z) {
      altitude[z] = 10.0 + static_cast<double>(z);
      values[z] = z == 0 ? S(0.0) : S(stratospheric_aerosol(haze.season, z - 1));
    }
    altitude[16] = 30.0, values[16] = S(stratospheric_aerosol(haze.season, 15));
    altitude[17] = 35.0, values[17] = S(0.0);
    out[2] = by_altitude(km, altitude, values);
  }
  if (km > 30.0) {
    std::array<S, 7> values;
    for (std::size_t z = 0; z < 7; ++z) values[z] = z == 0 ? S(0.0) : S(upper_aerosol(z - 1));
    out[3] = by_altitude(km, {30.0, 35.0, 40.0, 45.0, 50.0, 70.0, 100.0}, values);
  }
  return out;
}

/// The spectrum of the boundary region for a relative humidity.
template <class S>
std::array<S, kAerosolNodes> boundary_spectrum(HazeKind kind, AerosolLoss loss, const S& relative_humidity_percent) {
  using std::exp, std::log;
  std::array<S, kAerosolNodes> out;
  if (kind == HazeKind::advection_fog || kind == HazeKind::radiation_fog) {
    std::ranges::transform(fog_spectrum(kind, loss), out.begin(), [](double v) { return S(v); });
    return out;
  }
  S humidity = haze_humidity_share() * relative_humidity_percent;
  if (value_of(humidity) > kHazeHumidities.back()) humidity = S(kHazeHumidities.back());
  std::size_t i = 1;
  while (i + 1 < kHazeHumidities.size() && value_of(humidity) > kHazeHumidities[i]) ++i;
  const double dry = std::log(100.0 - kHazeHumidities[i - 1]), humid = std::log(100.0 - kHazeHumidities[i]);
  const S share = (log(100.0 - humidity) - dry) / (humid - dry);
  const auto a = haze_spectrum(kind, loss, i - 1), b = haze_spectrum(kind, loss, i);
  for (std::size_t k = 0; k < kAerosolNodes; ++k) out[k] = a[k] * exp(share * std::log(b[k] / a[k]));
  return out;
}

template <class S>
S rain_per_km(const S& rain_mm_h) {
  constexpr double kPower = 0.63, kFactor = mtf::kPi * 8000.0 / (4.1 * 4.1 * 4.1) * 1e-3, kSlopeFrom = 0.01;
  const double rate = value_of(rain_mm_h);
  return lift({kFactor * std::pow(rate, kPower), kFactor * kPower * std::pow(std::max(rate, kSlopeFrom), kPower - 1.0)},
              rain_mm_h);
}

}  // namespace radiometry::atmosphere
