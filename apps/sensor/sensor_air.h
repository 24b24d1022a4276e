// SPDX-License-Identifier: Apache-2.0
#pragma once

// The air in front of a sensor: [atmosphere] of its file, the profile read, the path through the band model of
// radiometry/atmosphere, and the air up to any range.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/sensor/sensor_chain.h"
#include "radiometry/atmosphere/atmosphere_settings.h"
#include "radiometry/performance/overrides.h"

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

// The air up to a target at any range: what a range that is solved for has to follow.
//   [atmosphere]   its line of sight with other values of range: horizontal, between two altitudes (the angle then
//                  follows from the range), or at an angle
//   path.table     within its ranges
//   neither        no air, or [conditions] extinction, of the contrast alone
// A [path] of one transmission, a tape7 or table of one range, a range for each pixel, a line whose length follows from
// angle and altitude, and components that state a path of their own hold for one range alone.

/// Why the air of this sensor cannot be followed, and what to write so that it can; "" where it can.
std::string air_course_gap(const mtf::System<double>& system, const LoadedSensor& loaded);

struct AirCourse {
  radiometry::Reach reach{};
  /// The air of a range within the reach; empty without air. Throws UsageError as Sensor::air.
  std::function<radiometry::Path(double range_m)> path{};
  /// The same from the table without that of its ranges that is nearest, and with nothing where a transmission falls to
  /// 0; empty where the air is no table.
  std::function<radiometry::Path(double range_m)> coarser{};
  /// What components take from it; empty where none takes any.
  std::function<mtf::PathAir<double>(double range_m)> path_air{};
};

/// `numbers`: of [atmosphere], in place of those of the file. The sensor has to be one without a gap.
AirCourse air_course(const LoadedSensor& loaded, const radiometry::Overrides<double>& numbers = {});

/// The keys of [atmosphere] or [path], with their values; "" without either.
std::string air_words(const radiometry::SensorSettings& settings);

/// The frame rate that figures of observers take from the sensor, with where it comes from; "" where they have none.
std::string frame_rate_words(const mtf::System<double>& system, const radiometry::SensorSettings& settings);

/// The range that the file states for its air: [atmosphere] range or [path] range; nothing where it states none.
std::optional<double> stated_range_m(const radiometry::SensorSettings& settings);

}  // namespace apps
