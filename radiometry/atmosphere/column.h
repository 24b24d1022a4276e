// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the air holds at each altitude that the model computes with: the amount of every absorber per km, and, for
// refraction, the refractive index times the distance from the centre of the earth (n r).

#include <array>
#include <cmath>
#include <vector>

#include "radiometry/atmosphere/haze_impl.h"

namespace radiometry::atmosphere {

/// Indices of the densities, in the order of Amounts; self: h^2, oxygen: u P / P0.
enum Density : std::size_t {
  kForeign = kLineBands,
  kSelf,
  kNitrogenDensity,
  kOxygenDensity,
  kMoleculesDensity,
  kRainDensity,
  kPressureDensity,  ///< Pa
  kMassDensity,      ///< Pa / K
  kAerosolDensity,   ///< extinction at 0.55 um, of each region
  kHumidAerosolDensity =
      kAerosolDensity + kAerosolRegions,  ///< that of the boundary region times the humidity in percent
  kDensities
};

template <class S>
struct Column {
  std::vector<double> altitude_m;
  std::vector<S> bent;  ///< n r at the levels, up to a common factor; a straight line of the altitude between them
  std::vector<std::array<S, kDensities>> density;
  std::vector<std::array<S, kDensities>> log_ratio;  ///< of each layer: ln(above / below), where both are above 0
  std::size_t densities = kDensities;                ///< without aerosol: fewer
};

/// (n - 1) of air at 2000 cm^-1, Edlen's formula.
template <class S>
S refractivity(const Level<S>& level) {
  const double nu = 2000.0;
  const double dry = 83.42 + 185.08 / (1.0 - nu * nu / (1.14e5 * 1.14e5)) + 4.11 / (1.0 - nu * nu / (6.24e4 * 6.24e4));
  const double vapour = 43.49 - nu * nu / (1.7e4 * 1.7e4);
  const S pressure = level.pressure_pa / kStandard_pa;
  return 1e-6 * pressure * (dry * 288.15 / level.temperature_k - vapour * 1e-6 * level[Gas::water]);
}

template <class S>
std::array<S, kDensities> densities_of(const Air<S>& air, Level<S> level) {
  using std::exp, std::log, std::sqrt;
  constexpr double kReference_k = 296.0, kRainTop_m = 6000.0;
  const bool rains = value_of(air.rain_mm_h) > 0.0 && level.altitude_m <= kRainTop_m;
  if (rains) level[Gas::water] = water_ppm(level.pressure_pa, level.temperature_k, S(100.0));
  std::array<S, kDensities> out;
  const S n = air_per_cm3(level.pressure_pa, level.temperature_k);
  const S pressure = level.pressure_pa / kStandard_pa, cold = kReference_k / level.temperature_k;
  const S log_pressure = log(pressure), log_cold = log(cold);
  const auto laws = band_laws();
  for (std::size_t i = 0; i < kLineBands; ++i)  // 1e20 molecules per cm^2 and km
    out[i] = 1e-21 * n * level[laws[i].gas] * exp(laws[i].n * log_pressure + laws[i].m * log_cold);
  const S h = 1e-25 * n * level[Gas::water], whole = 1e-19 * n;
  out[kForeign] = h * (whole - h);
  out[kSelf] = h * h;
  out[kNitrogenDensity] = pressure * pressure * cold * sqrt(cold);
  out[kOxygenDensity] = 1e-21 * n * level[Gas::oxygen] * pressure;
  out[kMoleculesDensity] = pressure * cold;
  out[kRainDensity] = level.altitude_m <= kRainTop_m ? rain_per_km(air.rain_mm_h) : S(0.0);
  out[kPressureDensity] = level.pressure_pa;
  out[kMassDensity] = level.pressure_pa / level.temperature_k;
  const auto aerosol = aerosol_per_km(air.haze, level.altitude_m);
  std::ranges::copy(aerosol, out.begin() + kAerosolDensity);
  out[kHumidAerosolDensity] =
      value_of(aerosol[0]) > 0.0 ? S(aerosol[0] * (rains ? S(100.0) : relative_humidity_percent(level))) : S(0.0);
  return out;
}

/// The levels of the profile, and between them the altitudes at which the model divides its layers.
template <class S>
std::vector<Level<S>> refined_levels(const Profile<S>& profile) {
  std::vector<double> altitudes;
  for (int km = 0; km <= 25; ++km) altitudes.push_back(1000.0 * km);
  for (const double km : {30.0, 35.0, 40.0, 45.0, 50.0, 70.0, 100.0}) altitudes.push_back(1000.0 * km);
  std::vector<Level<S>> levels;
  for (std::size_t i = 0; i < profile.levels.size(); ++i) {
    if (i > 0)
      for (const double z : altitudes)
        if (z > profile.levels[i - 1].altitude_m && z < profile.levels[i].altitude_m)
          levels.push_back(level_between(profile.levels[i - 1], profile.levels[i], z));
    levels.push_back(profile.levels[i]);
  }
  return levels;
}

template <class S>
Column<S> column_of(const Air<S>& air) {
  using std::log;
  constexpr double kLeastBend = 0.1;  // of d(n r)/dr: below it light would circle the earth, in layers that do not last
  Column<S> column;
  if (air.haze.kind == HazeKind::none) column.densities = kAerosolDensity;
  const auto levels = refined_levels(air.profile);
  for (const Level<S>& level : levels) {
    column.altitude_m.push_back(level.altitude_m);
    column.density.push_back(densities_of(air, level));
  }
  column.bent.push_back(S(kEarthRadius_m + levels.front().altitude_m));
  column.log_ratio.resize(levels.size() - 1);
  for (std::size_t i = 0; i + 1 < levels.size(); ++i) {
    const double radius = kEarthRadius_m + levels[i].altitude_m, step = levels[i + 1].altitude_m - levels[i].altitude_m;
    const S index = (1.0 + refractivity(levels[i + 1])) / (1.0 + refractivity(levels[i]));
    S rise = index * (1.0 + step / radius) - 1.0;
    if (value_of(rise) < kLeastBend * step / radius) rise = S(kLeastBend * step / radius);
    column.bent.push_back(column.bent[i] + column.bent[i] * rise);
    for (std::size_t k = 0; k < column.densities; ++k) {
      const S &below = column.density[i][k], &above = column.density[i + 1][k];
      if (value_of(below) > 0.0 && value_of(above) > 0.0) column.log_ratio[i][k] = log(above / below);
    }
  }
  return column;
}

}  // namespace radiometry::atmosphere
