// SPDX-License-Identifier: Apache-2.0
#pragma once

// The table [atmosphere] of sensor, study and scene files: which air, what floats in it, and the line of sight.
//   air     a model atmosphere or a profile, whose lowest level may be given another temperature and relative humidity;
//           or the pressure, temperature and relative humidity of one place, for horizontal lines
//   line    range alone                           horizontal at the sensor's altitude
//           target_altitude and range             from the sensor's altitude to that of the target
//           target_altitude and zenith_angle      at that angle, up or down to the altitude of the target
//           zenith_angle and range                at that angle, as long
//           zenith_angle alone                    to space
//           none of them                          no line: the air alone, as a scene file gives it

#include <optional>
#include <string>

#include "radiometry/atmosphere/air.h"
#include "radiometry/atmosphere/sight.h"
#include "radiometry/fields.h"

namespace radiometry {

struct AtmosphereSettings {
  std::optional<atmosphere::ModelAtmosphere> model{};
  std::string profile{};  ///< CSV file of the air by altitude
  std::optional<double> pressure_pa{}, temperature_k{}, relative_humidity{};
  std::optional<double> carbon_dioxide_ppm{};  ///< else kCarbonDioxide_ppm, or what the profile has
  atmosphere::HazeKind haze = atmosphere::HazeKind::none;
  std::optional<double> visibility_m{};  ///< else the usual one of the haze
  std::optional<atmosphere::Season> season{};
  double rain_mm_h = 0.0;
  double sensor_altitude_m = 0.0;
  std::optional<double> target_altitude_m{}, zenith_deg{}, range_m{};

  static constexpr auto fields() {
    using A = AtmosphereSettings;
    return std::tuple{
        optional(&A::model, "model", "\"mid_latitude_summer\"", "model atmosphere of AFGL-TR-86-0110"),
        optional(&A::profile, "profile", "\"sounding.csv\"",
                 "CSV file of altitude, pressure, temperature and humidity; gases that it lacks, and the air above it, "
                 "are those of model"),
        optional(&A::pressure_pa, "pressure", "Pa", 1.0, 120e3, "\"1013 hPa\"",
                 "of the air of a horizontal line, with temperature and relative_humidity in place of model"),
        optional(&A::temperature_k, "temperature", "K", 150.0, 350.0, "\"22 degC\"",
                 "of the air at the lowest altitude of model or profile, or of that horizontal line"),
        optional(&A::relative_humidity, "relative_humidity", 0.0, 1.0, "0.6", "there, a fraction"),
        optional(&A::carbon_dioxide_ppm, "co2", 0.0, 1e5, "420.0",
                 "carbon dioxide near the ground, parts per million by volume"),
        optional(&A::haze, "haze", "\"rural\"", "what floats in the lowest 2 km"),
        optional(&A::visibility_m, "visibility", "m", 10.0, 1e6, "\"23 km\"",
                 "meteorological visibility; else the usual one of the haze"),
        optional(&A::season, "season", "\"autumn_winter\"", "of the aerosol above 2 km; else that of model"),
        optional(&A::rain_mm_h, "rain", "mm/h", 0.0, 300.0, "\"5 mm/h\"",
                 "rain rate from the ground to 6 km; rain saturates the air"),
        optional(&A::sensor_altitude_m, "sensor_altitude", "m", 0.0, 1e8, "\"3 km\"", "above the sea"),
        optional(&A::target_altitude_m, "target_altitude", "m", 0.0, 1e8, "\"0 m\"", "above the sea"),
        optional(&A::zenith_deg, "zenith_angle", "deg", 0.0, 180.0, "\"120 deg\"",
                 "of the line at the sensor: 0 straight up, 180 straight down"),
        optional(&A::range_m, "range", "m", 0.0, 1e9, "\"2 km\"", "along the line; or scene.depth_channel")};
  }
};

/// The air of the table. `profile` is what the file of that name holds. Throws UsageError "atmosphere.KEY: ..." for
/// keys that contradict each other, and what the model says of its numbers as "[atmosphere]: ...".
atmosphere::Air<double> air_of(const AtmosphereSettings& settings,
                               const std::optional<atmosphere::Profile<double>>& profile = {});

/// Its line of sight; nothing where the table gives none. Throws UsageError as above.
std::optional<atmosphere::Sight<double>> sight_of(const AtmosphereSettings& settings);

}  // namespace radiometry
