// SPDX-License-Identifier: Apache-2.0
#pragma once

// One quantity as a function of time, for schedules (temperature of an engine bay, a heat flux): straight lines between
// the samples, held at the first value before them and at the last after them. One sample is a constant.

#include <string>
#include <vector>

namespace radiometry::heat {

struct Schedule {
  std::string source;          ///< file it came from, for messages
  std::vector<double> time_s;  ///< UTC (instant.h), strictly rising
  std::vector<double> value;   ///< finite, as many

  bool constant() const { return value.size() == 1; }
};

/// Throws UsageError, with the source, for no samples, sizes that differ, times that do not rise, and values that are
/// not finite.
Schedule make_schedule(std::string source, std::vector<double> time_s, std::vector<double> value);
Schedule constant_schedule(double value);

double value_at(const Schedule& schedule, double utc_s);

/// The sample times strictly between the two times.
std::vector<double> break_times(const Schedule& schedule, double begin_s, double end_s);

}  // namespace radiometry::heat
