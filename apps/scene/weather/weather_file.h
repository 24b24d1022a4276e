// SPDX-License-Identifier: Apache-2.0
#pragma once

// Weather files: our own CSV (weather_csv.h), EnergyPlus' EPW, NREL's TMY3 and NOAA's SURFRAD. What a file is is seen
// from its text, not from its name. Every reader gives SI values with times in UTC and the place that the file states;
// wrong values are refused by check_weather (radiometry/weather/weather.h) with file and line.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "radiometry/weather/sun.h"
#include "radiometry/weather/weather.h"

namespace apps::scene {

enum class WeatherFormat { csv, epw, tmy3, surfrad };
/// "CSV", "EPW", "TMY3", "SURFRAD"
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

}  // namespace apps::scene
