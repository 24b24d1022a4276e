// SPDX-License-Identifier: Apache-2.0
#pragma once

// Weather files: our own CSV (below), EnergyPlus' EPW, NREL's TMY2, TMY3 and SAM CSV (NSRDB), NOAA's SURFRAD and the
// typical year of PVGIS. What a file is is seen from its text, not from its name. Every reader gives SI values with
// times in UTC and the place that the file states; wrong values are refused by check_weather
// (radiometry/weather/weather.h) with file and line.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/scene/weather/si_units.h"
#include "radiometry/weather/sun.h"
#include "radiometry/weather/weather.h"
#include "radiometry/weather/weather_series.h"

namespace apps::scene {

enum class WeatherFormat { csv, epw, tmy2, tmy3, surfrad, sam, pvgis };
/// "CSV", "EPW", "TMY2", ...
std::string_view format_name(WeatherFormat format);

struct WeatherRequest {
  /// What the stamps of means stand for, where the file does not say it (absent: instants), or where it is not what its
  /// format says: EPW and TMY3 have hours of sunlight that end at their stamp, SURFRAD has minutes.
  std::optional<radiometry::heat::Stamp> stamp{};
  /// UTC from which a column "time (s)" counts, the start of the run.
  double origin_s = 0.0;
  /// Year that the records of a typical year (EPW, TMY3, whose months come from different years) are taken to be of.
  int year = 2001;
};

struct WeatherFile {
  WeatherFormat format = WeatherFormat::csv;
  radiometry::heat::Weather weather;
  std::optional<radiometry::heat::Place> place{};  ///< that the file states
  std::vector<std::string> warnings{};             ///< "file:line: warning: ..."
};

/// A file of at most 256 MiB and a million records. Throws RuntimeError when it cannot be read, UsageError
/// "file:line: error: ..." for what is wrong in it.
WeatherFile read_weather(const std::string& path, const WeatherRequest& request = {});
/// The same from text; `source` is what messages call it.
WeatherFile parse_weather(std::string_view text, const std::string& source, const WeatherRequest& request = {});

// Weather and schedules as CSV of our own:
//   # demo weather, clear-sky model
//   time,air_temperature (degC),relative_humidity (%),wind_speed (m/s),direct_normal (W/m2),longwave_down (W/m2)
//   2016-01-01T00:00:00Z,-7.6,52.7,3.1,0,186.3
// One header line; every column but `time` carries its unit in brackets. `time` is ISO 8601 with a compulsory zone (Z
// or +01:00); "time (s)", "time (min)" and "time (h)" count from the start of the run. Columns: the names of weather.h,
// and relative_humidity or dew_point in place of vapour_pressure (saturation over water, sky.h); a column of another
// name is refused with the nearest name. Empty cells and nan are missing values. `#` starts a comment line; the
// separator is a comma, semicolon or tab.

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
