// SPDX-License-Identifier: Apache-2.0
#pragma once

// The published formats that parse_weather tells apart, one function each, and what they share.

#include <string>
#include <string_view>
#include <vector>

#include "apps/scene/weather/weather_file.h"

namespace apps::scene {

/// EnergyPlus weather (Auxiliary Programs, "EnergyPlus Weather File (EPW) Data Dictionary").
WeatherFile parse_epw(std::string_view text, const std::string& source, const WeatherRequest& request);

/// Typical meteorological year, version 3 (Wilcox and Marion, NREL/TP-581-43156 (2008)).
WeatherFile parse_tmy3(std::string_view text, const std::string& source, const WeatherRequest& request);

/// Surface radiation budget network, daily files (NOAA Global Monitoring Laboratory, README of the archive).
WeatherFile parse_surfrad(std::string_view text, const std::string& source, const WeatherRequest& request);

/// A line of text with its number, and its cells as numbers; throws UsageError with file, line and column.
class RecordCells {
 public:
  RecordCells(const std::string& source, std::size_t line, const std::vector<std::string_view>& cells)
      : source_(source), line_(line), cells_(cells) {}

  [[noreturn]] void fail(const std::string& text) const;
  std::string_view text(std::size_t i) const { return cells_[i]; }
  /// Of a cell that holds a number.
  double number(std::size_t i, std::string_view name) const;
  int whole(std::size_t i, std::string_view name) const;
  /// NaN for a value at or beyond the format's mark of missing values; `mark` may be negative (at or below it then).
  double value(std::size_t i, std::string_view name, double mark) const;

 private:
  const std::string& source_;
  std::size_t line_;
  const std::vector<std::string_view>& cells_;
};

/// The end of a record in local standard time.
struct HourStamp {
  int year = 0, month = 0, day = 0;
  double seconds = 0.0;  ///< of the day
};

/// Gives the records their times in UTC and puts them, checked, into `file`. Where their years differ they are of a
/// typical year and become those of `year`; the 29th of February is left out, with a warning, where that one has none.
void finish_hours(radiometry::heat::Weather&& records, const std::vector<HourStamp>& stamps, double zone_h, int year,
                  WeatherFile& file);

/// What the stamps of means stand for: what the format states, unless another stamp is asked for, which is noted.
radiometry::heat::Stamp stamp_of(const WeatherRequest& request, radiometry::heat::Stamp stated, WeatherFile& file,
                                 const std::string& source);

/// What the published formats of hours say of temperature, humidity, wind, pressure and clouds: they hold at the time
/// indicated, where sunlight is the sum of the record before it.
void set_at_stamp(radiometry::heat::Weather& weather);

/// Latitude and longitude in degrees, altitude in m, checked; throws UsageError with the line.
radiometry::heat::Place place_of_degrees(double latitude_deg, double longitude_deg, double altitude_m,
                                         const std::string& source, std::size_t line);

}  // namespace apps::scene
