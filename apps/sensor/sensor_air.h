// SPDX-License-Identifier: Apache-2.0
#pragma once

// [atmosphere] of a sensor file: its profile read, its path through the band model of radiometry/atmosphere.

#include <optional>
#include <vector>

#include "apps/sensor/sensor_chain.h"
#include "radiometry/atmosphere/atmosphere_settings.h"

namespace apps {

/// The air and line of sight that the table states. Throws UsageError as air_of and sight_of do.
radiometry::atmosphere::Air<double> read_air(const radiometry::AtmosphereSettings& settings);

/// The line of sight; throws UsageError for a table without one.
radiometry::atmosphere::Sight<double> read_sight(const radiometry::AtmosphereSettings& settings);

/// Tables of sensor files, radiometry::sensor_tables(), where [atmosphere] also gives components their path.
std::vector<mtf::TableInfo> sensor_schema();

/// What the path of such a system loses to haze: absorption alone where a component `aerosol` scatters.
radiometry::atmosphere::AerosolLoss loss_in(const mtf::System<double>& system);

/// Fills the path of a sensor with [atmosphere]: the path itself, how it follows from other numbers, or, with
/// scene.depth_channel, the table over ranges and its error. Light that haze scatters stays in the image where an
/// `aerosol` component of the system counts it, and is lost elsewhere. Throws UsageError as above and for a table
/// without a line.
void read_atmosphere(const mtf::System<double>& system, const radiometry::SensorSettings& settings,
                     LoadedSensor& loaded);

/// The sensor without [path] and [atmosphere] and without the ranges of pixels, for the sensor by itself and for
/// pictures that have their air in them. Its components keep the path that they were read with.
mtf::io::SensorConfig without_path(mtf::io::SensorConfig sensor);

/// How long the air in front of a sensor is, where its file says it. `to_space`: one end lies at the top of the air, so
/// that the target may be farther.
struct AirRange {
  double range_m = 0.0;
  bool to_space = false;
};
/// Nothing for a path of no stated length. Throws UsageError as above.
std::optional<AirRange> range_of_air(const mtf::io::SensorConfig& sensor);

/// What the model is not good for in the band of this sensor (radiometry/atmosphere: limits_of).
std::vector<mtf::io::Diagnostic> atmosphere_warnings(const mtf::io::SensorConfig& config);

}  // namespace apps
