// SPDX-License-Identifier: Apache-2.0
#pragma once

// The air between a sensor and its target at any range: what a range that is solved for has to follow.
//   [atmosphere]   its line of sight with other values of range: horizontal, between two altitudes (the angle then
//                  follows from the range), or at an angle
//   path.table     within its ranges
//   neither        no air, or [conditions] extinction, of the contrast alone
// A [path] of one transmission, a tape7 or table of one range, a range for each pixel, a line whose length follows from
// angle and altitude, and components that state a path of their own hold for one range alone.

#include <functional>
#include <string>

#include "apps/sensor/sensor_chain.h"
#include "radiometry/performance/overrides.h"

namespace apps {

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
