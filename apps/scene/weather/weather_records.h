// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the readers of weather files share: cells as numbers, stamps of local standard time, places, and how records
// become weather.

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "apps/scene/weather/weather_file.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/words.h"

namespace apps::scene {

/// A line of text with its number, and its cells as numbers; throws UsageError with file, line and column.
class RecordCells {
 public:
  RecordCells(const std::string& source, std::size_t line, const std::vector<std::string_view>& cells)
      : source_(source), line_(line), cells_(cells) {}

  [[noreturn]] void fail(const std::string& text) const { throw mtf::UsageError(error_at(source_, line_) + text); }
  std::string_view text(std::size_t i) const { return cells_[i]; }
  /// Of a cell that holds a number.
  double number(std::size_t i, std::string_view name) const {
    const auto value = mtf::io::cell_number(cells_[i]);
    if (!value || !std::isfinite(*value))
      fail(std::string(name) + " \"" + mtf::printable(cells_[i], 40) + "\" is no number");
    return *value;
  }
  int whole(std::size_t i, std::string_view name) const {
    const double value = number(i, name);
    if (value != std::round(value) || std::abs(value) > 1e6)
      fail(std::string(name) + " \"" + mtf::printable(cells_[i], 40) + "\" is no whole number");
    return static_cast<int>(value);
  }
  /// NaN for a value at or beyond the format's mark of missing values; `mark` may be negative (at or below it then).
  double value(std::size_t i, std::string_view name, double mark) const {
    const double value = number(i, name);
    const bool missing = mark > 0.0 ? value >= mark : value <= mark;
    return missing ? std::nan("") : value;
  }

 private:
  const std::string& source_;
  std::size_t line_;
  const std::vector<std::string_view>& cells_;
};

/// The stamp of a record in local standard time.
struct HourStamp {
  int year = 0, month = 0, day = 0;
  double seconds = 0.0;  ///< of the day
};

/// Whether some year has that day, as that of a typical year is not known: the year 2000 has every day.
bool is_day(int month, int day);

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

/// The offset from UTC of local standard time.
double zone_h_of(const RecordCells& record, std::size_t cell);

/// The vapour pressure of a record whose temperature is there.
void add_humidity(const RecordCells& record, double percent, radiometry::heat::Weather& weather);

/// The readers of the formats with columns by name that NREL's and the JRC's services hand out (weather_services.cpp).
WeatherFile parse_sam_csv(std::string_view text, const std::string& source, const WeatherRequest& request);
WeatherFile parse_pvgis(std::string_view text, const std::string& source, const WeatherRequest& request);

}  // namespace apps::scene
