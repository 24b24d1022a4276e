// SPDX-License-Identifier: Apache-2.0
#pragma once

// A CSV table over time: the common part of weather and schedules (weather_csv.h has the form).

#include <string>
#include <string_view>
#include <vector>

#include "apps/scene/weather/si_units.h"

namespace apps::scene {

struct TimedColumn {
  std::string name;
  SiUnit unit;
  std::vector<double> value;  ///< SI by the unit; NaN for an empty cell or nan
};

struct TimedTable {
  std::size_t header_line = 0;
  std::vector<double> time_s;  ///< UTC, in the order of the file
  std::vector<std::size_t> line;
  std::vector<TimedColumn> columns;
};

/// Throws UsageError "source:line: error: ..." for the first thing that is wrong.
TimedTable parse_timed_table(std::string_view text, const std::string& source, double origin_s);

/// "source:12: error: "
std::string error_at(const std::string& source, std::size_t line);

}  // namespace apps::scene
