// SPDX-License-Identifier: Apache-2.0

// EPW: eight header lines, of which LOCATION has the place and the zone, then one line a record with 35 cells. Hours
// count from 1 and end at their stamp in local standard time. Solar columns are Wh/m2 received in the minutes before
// the stamp; for hourly records that is the mean in W/m2. So, by its unit, is the long wave, of which the dictionary
// does not say when it was received. Temperature, humidity, pressure, wind and clouds hold at the time indicated.

#include <array>
#include <cmath>

#include "apps/scene/weather/weather_formats.h"
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

constexpr std::size_t kHeaderLines = 8, kCells = 35, kOldCells = 32;  // older files end before albedo and rain

/// A column of the data: where it stands, from which value on it is missing, and how it becomes SI.
struct EpwColumn {
  WeatherQuantity quantity;
  std::size_t cell;
  double mark, factor, offset;
  bool is_sum;  ///< Wh/m2 over the record
};
constexpr std::array kColumns{EpwColumn{air_temperature, 6, 99.9, 1.0, mtf::kZeroCelsius_k, false},
                              EpwColumn{pressure, 9, 999999.0, 1.0, 0.0, false},
                              EpwColumn{longwave_down, 12, 9999.0, 1.0, 0.0, true},
                              EpwColumn{global_horizontal, 13, 9999.0, 1.0, 0.0, true},
                              EpwColumn{direct_normal, 14, 9999.0, 1.0, 0.0, true},
                              EpwColumn{diffuse_horizontal, 15, 9999.0, 1.0, 0.0, true},
                              EpwColumn{wind_speed, 21, 999.0, 1.0, 0.0, false},
                              EpwColumn{cloud_cover, 23, 99.0, 0.1, 0.0, false}};
constexpr std::size_t kHumidityCell = 8;  // %, missing from 999 on

}  // namespace

WeatherFile parse_epw(std::string_view text, const std::string& source, const WeatherRequest& request) {
  WeatherFile file;
  file.format = WeatherFormat::epw;
  double zone_h = 0.0, per_hour = 1.0;
  std::vector<HourStamp> stamps;
  Weather all{.source = source, .stamp = stamp_of(request, Stamp::end, file, source), .time_s = {}, .values = {}};
  set_at_stamp(all);
  text = mtf::io::without_mark(text);
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::string_view row = mtf::io::take_text_line(text);
    if (mtf::io::trimmed_cell(row).empty()) continue;
    const auto cells = mtf::io::split_cells(row, ',', row.size());
    const RecordCells record(source, line, cells);
    if (line == 1) {
      if (cells.size() < 10) record.fail("LOCATION has " + std::to_string(cells.size()) + " cells, 10 are needed");
      file.place = place_of_degrees(record.number(6, "latitude"), record.number(7, "longitude"),
                                    record.number(9, "elevation"), source, line);
      zone_h = record.number(8, "time zone");
      if (!(std::abs(zone_h) <= 14.0)) record.fail("the time zone is outside of -14 ... 14 h");
    }
    if (line <= kHeaderLines) {
      if (cells.front() == "DATA PERIODS" && cells.size() > 2) per_hour = record.number(2, "records per hour");
      if (!(per_hour >= 1.0 && per_hour <= 60.0)) record.fail("records per hour are outside of 1 ... 60");
      continue;
    }
    if (cells.size() != kOldCells && cells.size() < kCells)
      record.fail(std::to_string(cells.size()) + " cells in a record, " + std::to_string(kCells) + " or " +
                  std::to_string(kOldCells) + " are needed");
    const int hour = record.whole(3, "hour"), minute = record.whole(4, "minute");
    const HourStamp stamp{record.whole(0, "year"), record.whole(1, "month"), record.whole(2, "day"),
                          3600.0 * (hour - 1) + 60.0 * (minute == 0 ? 60 : minute)};
    // Year 2000 has every day that any year has.
    if (!radiometry::heat::is_date({2000, stamp.month, stamp.day}) || hour < 1 || hour > 24 || minute < 0 ||
        minute > 60)
      record.fail("no such date or hour; hours are from 1 to 24");
    stamps.push_back(stamp);
    all.line.push_back(line);
    for (const EpwColumn& column : kColumns) {
      const double factor = column.is_sum ? per_hour : column.factor;
      all[column.quantity].push_back(record.value(column.cell, quantity_name(column.quantity), column.mark) * factor +
                                     column.offset);
    }
    const double humidity = record.value(kHumidityCell, "relative humidity", 999.0) / 100.0;
    if (humidity < 0.0 || humidity > 1.1) record.fail("the relative humidity is outside of 0 ... 110 %");
    all[vapour_pressure].push_back(humidity * radiometry::heat::saturation_pressure_pa(all[air_temperature].back()));
  }
  finish_hours(std::move(all), stamps, zone_h, request.year, file);
  return file;
}

}  // namespace apps::scene
