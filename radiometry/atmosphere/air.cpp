// SPDX-License-Identifier: Apache-2.0
#include <numeric>

#include "mtf/error.h"
#include "mtf/units.h"
#include "radiometry/atmosphere/air_impl.h"

namespace radiometry::atmosphere {
namespace {

using mtf::format_double;
using mtf::UsageError;

#include "radiometry/atmosphere/tables/model_atmospheres.inc"

constexpr std::size_t kLevels = std::size(kAltitude_km);

std::string celsius_hint(double temperature_k) {
  return temperature_k >= -100.0 && temperature_k <= 70.0
             ? " (degrees Celsius? that would be " + format_double(temperature_k + kZero_c_k) + " K)"
             : "";
}

}  // namespace

Profile<double> model_profile(ModelAtmosphere model, double carbon_dioxide_ppm) {
  const auto m = static_cast<std::size_t>(model);
  Profile<double> profile{std::string(kModelAtmosphereNames[m]), std::vector<Level<double>>(kLevels)};
  for (std::size_t i = 0; i < kLevels; ++i) {
    Level<double>& level = profile.levels[i];
    level.altitude_m = 1000.0 * kAltitude_km[i];
    level.pressure_pa = 100.0 * kPressure_hpa[m][i];
    level.temperature_k = kTemperature_k[m][i];
    level.ppm = {kWater_ppm[m][i],          kCarbonDioxide330_ppm[i], kOzone_ppm[m][i], kNitrousOxide_ppm[m][i],
                 kCarbonMonoxide_ppm[m][i], kMethane_ppm[m][i],       kOxygen_ppm[i],   kNitricOxide_ppm[i],
                 kSulphurDioxide_ppm[i],    kNitrogenDioxide_ppm[i],  kAmmonia_ppm[i],  kNitricAcid_ppm[i]};
  }
  return with_carbon_dioxide(std::move(profile), carbon_dioxide_ppm);
}

Level<double> standard_ground(double carbon_dioxide_ppm) {
  return model_profile(ModelAtmosphere::us_standard_1976, carbon_dioxide_ppm).levels.front();
}

void require_carbon_dioxide(double ppm) {
  if (!(ppm >= 0.0 && ppm <= 1e5))
    throw UsageError("air: CO2 of " + format_double(ppm) + " ppm; it has to be from 0 to 100000 (today's air has 420)");
}

void require_surface(double pressure_pa, double temperature_k, double relative_humidity_percent) {
  if (!(temperature_k >= 150.0 && temperature_k <= 350.0))
    throw UsageError("air: a temperature of " + format_double(temperature_k) + " K" + celsius_hint(temperature_k) +
                     "; it has to be from 150 to 350 K");
  if (!(pressure_pa >= 0.01 && pressure_pa <= 120000.0))
    throw UsageError("air: a pressure of " + format_double(pressure_pa) + " Pa; it has to be from 0.01 to 120000 Pa");
  if (pressure_pa >= 300.0 && pressure_pa <= 1100.0 && temperature_k > 275.0)
    throw UsageError("air: a pressure of " + format_double(pressure_pa) + " Pa at " + format_double(temperature_k) +
                     " K; that looks like hectopascals: give " + format_double(100.0 * pressure_pa) + " Pa");
  if (!(relative_humidity_percent >= 0.0 && relative_humidity_percent <= 100.0))
    throw UsageError("air: a relative humidity of " + format_double(relative_humidity_percent) +
                     " %; it has to be from 0 to 100");
  const double ppm = water_ppm(pressure_pa, temperature_k, relative_humidity_percent);
  if (!(ppm <= 5e5))
    throw UsageError("air: vapour of " + format_double(relative_humidity_percent) + " % at " +
                     format_double(temperature_k) + " K would be " + format_double(1e-4 * ppm) + " % of air of " +
                     format_double(pressure_pa) + " Pa; give less humidity, a lower temperature or more pressure");
}

void require_altitude_inside(const std::string& source, double altitude_m, double lowest_m, double highest_m) {
  if (!(altitude_m >= lowest_m && altitude_m <= highest_m))
    throw UsageError(source + ": the altitude " + format_double(altitude_m) + " m is outside of its levels, " +
                     format_double(lowest_m) + " to " + format_double(highest_m) + " m");
}

void require_valid_levels(const std::string& source, std::span<const LevelValues> levels) {
  if (levels.empty()) throw UsageError(source + ": a profile without levels; give one or more");
  const auto refuse = [&](std::size_t i, const std::string& what) {
    throw UsageError(source + ": level " + std::to_string(i + 1) + " at " + format_double(levels[i].altitude_m) +
                     " m: " + what);
  };
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const LevelValues& level = levels[i];
    if (!(level.altitude_m >= -500.0 && level.altitude_m <= 120000.0))
      refuse(i, "altitudes have to be from -500 to 120000 m");
    // Closer levels would bend light beyond what the shells can follow.
    if (i > 0 && !(level.altitude_m >= levels[i - 1].altitude_m + 0.01))
      refuse(i, "altitudes have to rise, by a centimetre or more; sort the levels and remove double ones");
    const bool high = level.altitude_m > 60000.0;
    if (!(level.temperature_k >= (high ? 100.0 : 150.0) && level.temperature_k <= (high ? 1000.0 : 350.0)))
      refuse(i, "a temperature of " + format_double(level.temperature_k) + " K" + celsius_hint(level.temperature_k) +
                    "; it has to be from " + (high ? "100 to 1000 K" : "150 to 350 K"));
    if (!(level.pressure_pa > 0.0 && level.pressure_pa <= 120000.0))
      refuse(i,
             "a pressure of " + format_double(level.pressure_pa) + " Pa; it has to be above 0 and at most 120000 Pa");
    // Air is never thinner than a tenth of what an isothermal scale height of 7 km leaves of 1000 hPa.
    const double usual = 1e5 * std::exp(-level.altitude_m / 7000.0);
    if (levels.size() > 1 && level.altitude_m < 30000.0 && level.pressure_pa < 0.1 * usual)
      refuse(i, "a pressure of " + format_double(level.pressure_pa) + " Pa, where some " +
                    format_double(std::round(usual)) + " Pa are usual; are these hectopascals? give pascals");
    if (i > 0 && !(level.pressure_pa < levels[i - 1].pressure_pa))
      refuse(i, "a pressure of " + format_double(level.pressure_pa) +
                    " Pa, not below that of the level before; pressure falls with altitude");
    for (std::size_t g = 0; g < kGases; ++g)
      if (!(level.ppm[g] >= 0.0 && level.ppm[g] <= 1e6))
        refuse(i, "a mixing ratio of " + format_double(level.ppm[g]) + " ppm (gas " + std::to_string(g + 1) +
                      "); it has to be from 0 to 1e6");
    const double whole = std::accumulate(level.ppm.begin(), level.ppm.end(), 0.0);
    if (whole > 1e6)
      refuse(i, "gases of " + format_double(whole) + " ppm, more than all of the air; for vapour, give less humidity");
    const double saturated = water_ppm(level.pressure_pa, level.temperature_k, 100.0);
    if (level.altitude_m < 10000.0 && level.ppm[0] > 1.5 * saturated)
      refuse(i, "vapour of " + format_double(level.ppm[0]) + " ppm, " +
                    format_double(std::round(100.0 * level.ppm[0] / saturated)) +
                    " % of saturation; humidity above 100 % condenses");
  }
}

template Profile<double> with_scalar(const Profile<double>&);
template Profile<double> with_carbon_dioxide(Profile<double>, const double&);
template Profile<double> with_surface(Profile<double>, const double&, const double&);
template Profile<double> surface_air(const double&, const double&, const double&, double);
template void require_valid(const Profile<double>&);
template double saturation_per_cm3(const double&);
template double air_per_cm3(const double&, const double&);
template double water_ppm(const double&, const double&, const double&);
template double relative_humidity_percent(const Level<double>&);
template Level<double> level_at(const Profile<double>&, double);

Season season_of(ModelAtmosphere model) {
  return model == ModelAtmosphere::mid_latitude_winter || model == ModelAtmosphere::subarctic_winter
             ? Season::autumn_winter
             : Season::spring_summer;
}

double usual_visibility_m(HazeKind kind) {
  constexpr std::array<double, kHazeNames.size()> kVisibility_m{23e3, 23e3, 5e3, 23e3, 50e3, 200.0, 500.0};
  return kVisibility_m[static_cast<std::size_t>(kind)];
}

void require_haze(double visibility_m, double rain_mm_h) {
  if (!(visibility_m >= 10.0 && visibility_m <= 1e6))
    throw UsageError("air: a visibility of " + format_double(visibility_m) +
                     " m; it has to be from 10 m to 1000 km (metres, not kilometres)");
  if (!(rain_mm_h >= 0.0 && rain_mm_h <= 300.0))
    throw UsageError("air: rain of " + format_double(rain_mm_h) + " mm/h; it has to be from 0 to 300");
}

template void require_valid(const Air<double>&);
template std::array<double, kAerosolRegions> aerosol_per_km(const Haze<double>&, double);
template double rain_per_km(const double&);

}  // namespace radiometry::atmosphere
