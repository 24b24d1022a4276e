// SPDX-License-Identifier: Apache-2.0

// SURFRAD: the first line names the station, the second one has latitude, longitude (west positive), altitude and the
// version, then one line a minute in UTC: 8 numbers of the time, then 20 pairs of a value and its quality flag (0 good,
// 1 bad, 2 doubtful). Values are means over the interval that ends at the stamp. -9999.9 is missing; a value whose flag
// is not 0 is taken as missing, too.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "apps/scene/weather/weather_formats.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/units.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sky.h"

namespace apps::scene {
namespace {

using radiometry::heat::Stamp;
using radiometry::heat::Weather;
using radiometry::heat::WeatherQuantity;
using enum radiometry::heat::WeatherQuantity;

constexpr std::size_t kCells = 48;
constexpr double kMissingMark = -9999.0;

struct SurfradColumn {
  WeatherQuantity quantity;
  std::size_t cell;  ///< its flag follows
  double factor, offset;
};
constexpr std::array kColumns{SurfradColumn{global_horizontal, 8, 1.0, 0.0},
                              SurfradColumn{solar_up, 10, 1.0, 0.0},
                              SurfradColumn{direct_normal, 12, 1.0, 0.0},
                              SurfradColumn{diffuse_horizontal, 14, 1.0, 0.0},
                              SurfradColumn{longwave_down, 16, 1.0, 0.0},
                              SurfradColumn{longwave_up, 22, 1.0, 0.0},
                              SurfradColumn{air_temperature, 38, 1.0, mtf::kZeroCelsius_k},
                              SurfradColumn{wind_speed, 42, 1.0, 0.0},
                              SurfradColumn{pressure, 46, 100.0, 0.0}};
constexpr std::size_t kHumidityCell = 40;

/// Cells that blanks separate.
std::vector<std::string_view> words_of(std::string_view row) {
  constexpr std::string_view blanks = " \t\r";
  std::vector<std::string_view> words;
  for (std::size_t at = row.find_first_not_of(blanks); at != std::string_view::npos;) {
    const std::size_t end = std::min(row.find_first_of(blanks, at), row.size());
    words.push_back(row.substr(at, end - at));
    at = row.find_first_not_of(blanks, end);
  }
  return words;
}

}  // namespace

WeatherFile parse_surfrad(std::string_view text, const std::string& source, const WeatherRequest& request) {
  WeatherFile file;
  file.format = WeatherFormat::surfrad;
  Weather& weather = file.weather;
  weather.source = source;
  weather.stamp = stamp_of(request, Stamp::end, file, source);
  mtf::io::take_text_line(text);
  const auto station = words_of(mtf::io::take_text_line(text));
  const RecordCells head(source, 2, station);
  if (station.size() < 3) head.fail("the line has to state latitude, longitude and altitude");
  file.place =
      place_of_degrees(head.number(0, "latitude"), -head.number(1, "longitude"), head.number(2, "altitude"), source, 2);

  std::size_t flagged = 0;
  for (std::size_t line = 3; !text.empty(); ++line) {
    const auto cells = words_of(mtf::io::take_text_line(text));
    if (cells.empty()) continue;
    const RecordCells record(source, line, cells);
    if (cells.size() != kCells)
      record.fail(std::to_string(cells.size()) + " numbers, " + std::to_string(kCells) + " are needed");
    const radiometry::heat::CalendarDate date{record.whole(0, "year"), record.whole(2, "month"),
                                              record.whole(3, "day")};
    const int hour = record.whole(4, "hour"), minute = record.whole(5, "minute");
    if (!is_date(date) || hour < 0 || hour > 23 || minute < 0 || minute > 59) record.fail("no such date or time");
    weather.time_s.push_back(radiometry::heat::instant_of(date, 3600.0 * hour + 60.0 * minute));
    weather.line.push_back(line);
    const auto read = [&](std::size_t cell, std::string_view name) {
      const double value = record.value(cell, name, kMissingMark);
      if (record.whole(cell + 1, "quality flag") == 0 || std::isnan(value)) return value;
      ++flagged;
      return std::numeric_limits<double>::quiet_NaN();
    };
    for (const SurfradColumn& column : kColumns)
      weather[column.quantity].push_back(read(column.cell, quantity_name(column.quantity)) * column.factor +
                                         column.offset);
    const double humidity = read(kHumidityCell, "relative humidity") / 100.0;
    if (humidity < 0.0 || humidity > 1.1) record.fail("the relative humidity is outside of 0 ... 110 %");
    weather[vapour_pressure].push_back(humidity *
                                       radiometry::heat::saturation_pressure_pa(weather[air_temperature].back()));
  }
  if (weather.time_s.empty()) throw mtf::UsageError(source + ": error: the file has no records");
  if (flagged > 0)
    file.warnings.push_back(source + ": warning: " + std::to_string(flagged) +
                            " values with a quality flag other than 0 are taken as missing");
  check_weather(weather);
  return file;
}

}  // namespace apps::scene
