// SPDX-License-Identifier: Apache-2.0
#pragma once

// Weather and schedules as CSV of our own:
//   # demo weather, clear-sky model
//   time,air_temperature (degC),relative_humidity (%),wind_speed (m/s),direct_normal (W/m2),longwave_down (W/m2)
//   2016-01-01T00:00:00Z,-7.6,52.7,3.1,0,186.3
// One header line; every column but `time` carries its unit in brackets. `time` is ISO 8601 with a compulsory zone (Z
// or +01:00); "time (s)", "time (min)" and "time (h)" count from the start of the run. Columns: the names of weather.h,
// and relative_humidity or dew_point in place of vapour_pressure (saturation over water, sky.h); a column of another
// name is refused with the nearest name. Empty cells and nan are missing values. `#` starts a comment line; the
// separator is a comma, semicolon or tab.

#include <string>
#include <string_view>
#include <vector>

#include "apps/scene/weather/si_units.h"
#include "apps/scene/weather/weather_file.h"
#include "radiometry/weather/weather_series.h"

namespace apps::scene {

struct TimedColumn {
  std::string name;
  SiUnit unit;
  std::vector<double> value;  ///< SI by the unit; NaN for an empty cell or nan
};

/// A table of that form: the common part of weather, schedules and paths of cameras.
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

WeatherFile parse_weather_csv(std::string_view text, const std::string& source, const WeatherRequest& request = {});

/// A CSV that reads back as the same numbers: the columns that are there in SI units, times to 1 us;
/// `comments` become # lines at the top.
std::string weather_csv(const radiometry::heat::Weather& weather, const std::vector<std::string>& comments = {});

/// A schedule: `time` as above and one column of any name with a unit that converts to `si_unit` ("K", "W/m2"); degC is
/// a temperature. Throws RuntimeError and UsageError as read_weather.
radiometry::heat::Schedule read_schedule(const std::string& path, std::string_view si_unit, double origin_s);
radiometry::heat::Schedule parse_schedule(std::string_view text, const std::string& source, std::string_view si_unit,
                                          double origin_s);

}  // namespace apps::scene
