// SPDX-License-Identifier: Apache-2.0

// TMY3: the first line has station, zone and place, the second one the names of the columns with their units, then one
// line an hour, in local standard time (01:00 ... 24:00). Sunlight is that of the 60 minutes that end at the stamp; all
// else holds at the time indicated. Missing values are -9900.

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/scene/weather/weather_formats.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/units.h"
#include "mtf/words.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sky.h"

namespace apps::scene {
namespace {

using radiometry::heat::Stamp;
using radiometry::heat::Weather;
using radiometry::heat::WeatherQuantity;
using enum radiometry::heat::WeatherQuantity;

constexpr double kMissingMark = -9900.0;

struct Tmy3Column {
  WeatherQuantity quantity;
  std::string_view name;
  double factor, offset;
};
constexpr std::array kColumns{Tmy3Column{global_horizontal, "GHI (W/m^2)", 1.0, 0.0},
                              Tmy3Column{direct_normal, "DNI (W/m^2)", 1.0, 0.0},
                              Tmy3Column{diffuse_horizontal, "DHI (W/m^2)", 1.0, 0.0},
                              Tmy3Column{air_temperature, "Dry-bulb (C)", 1.0, mtf::kZeroCelsius_k},
                              Tmy3Column{pressure, "Pressure (mbar)", 100.0, 0.0},
                              Tmy3Column{wind_speed, "Wspd (m/s)", 1.0, 0.0},
                              Tmy3Column{cloud_cover, "OpqCld (tenths)", 0.1, 0.0}};
constexpr std::string_view kHumidity = "RHum (%)";

/// "01/31/1988" and "24:00".
HourStamp stamp_of(const RecordCells& record) {
  const std::string_view date = record.text(0), time = record.text(1);
  const auto part = [&](std::string_view text, std::size_t at, std::size_t size) {
    return text.size() >= at + size ? mtf::io::cell_number<int>(text.substr(at, size)) : std::nullopt;
  };
  const auto month = part(date, 0, 2), day = part(date, 3, 2), year = part(date, 6, 4), hour = part(time, 0, 2),
             minute = part(time, 3, 2);
  // Year 2000 has every day that any year has.
  const bool good = month && day && year && hour && minute && date.size() == 10 && time.size() == 5 && date[2] == '/' &&
                    date[5] == '/' && time[2] == ':' && radiometry::heat::is_date({2000, *month, *day}) && *hour >= 0 &&
                    *minute >= 0 && *minute < 60 && 60 * *hour + *minute <= 24 * 60;
  if (!good)
    record.fail("\"" + mtf::printable(date, 20) + " " + mtf::printable(time, 20) +
                "\" is no date and time; they are like 01/31/1988 and 24:00");
  return {*year, *month, *day, 3600.0 * *hour + 60.0 * *minute};
}

}  // namespace

WeatherFile parse_tmy3(std::string_view text, const std::string& source, const WeatherRequest& request) {
  WeatherFile file;
  file.format = WeatherFormat::tmy3;
  text = mtf::io::without_mark(text);

  const std::string_view station = mtf::io::take_text_line(text);
  const auto station_cells = mtf::io::split_cells(station, ',', station.size());
  const RecordCells head(source, 1, station_cells);
  if (station_cells.size() != 7)
    head.fail(std::to_string(station_cells.size()) +
              " cells, 7 are needed: number, name, state, zone, latitude, longitude, elevation");
  const double zone_h = head.number(3, "time zone");
  if (!(std::abs(zone_h) <= 14.0)) head.fail("the time zone is outside of -14 ... 14 h");
  file.place =
      place_of_degrees(head.number(4, "latitude"), head.number(5, "longitude"), head.number(6, "elevation"), source, 1);

  const std::string_view names = mtf::io::take_text_line(text);
  const auto name_cells = mtf::io::split_cells(names, ',', names.size());
  const RecordCells header(source, 2, name_cells);
  const auto cell_of = [&](std::string_view name) {
    const auto found = std::find(name_cells.begin(), name_cells.end(), name);
    if (found == name_cells.end()) header.fail("the column \"" + std::string(name) + "\" is missing");
    return static_cast<std::size_t>(found - name_cells.begin());
  };
  std::array<std::size_t, kColumns.size()> cells_of{};
  std::transform(kColumns.begin(), kColumns.end(), cells_of.begin(),
                 [&](const Tmy3Column& c) { return cell_of(c.name); });
  const std::size_t humidity_cell = cell_of(kHumidity);

  Weather all{.source = source, .stamp = stamp_of(request, Stamp::end, file, source), .time_s = {}, .values = {}};
  set_at_stamp(all);
  std::vector<HourStamp> stamps;
  for (std::size_t line = 3; !text.empty(); ++line) {
    const std::string_view row = mtf::io::take_text_line(text);
    if (mtf::io::trimmed_cell(row).empty()) continue;
    const auto cells = mtf::io::split_cells(row, ',', row.size());
    const RecordCells record(source, line, cells);
    if (cells.size() != name_cells.size())
      record.fail(std::to_string(cells.size()) + " cells where the header has " + std::to_string(name_cells.size()));
    stamps.push_back(stamp_of(record));
    all.line.push_back(line);
    for (std::size_t i = 0; i < kColumns.size(); ++i) {
      const Tmy3Column& column = kColumns[i];
      all[column.quantity].push_back(record.value(cells_of[i], column.name, kMissingMark) * column.factor +
                                     column.offset);
    }
    const double humidity = record.value(humidity_cell, kHumidity, kMissingMark) / 100.0;
    if (humidity < 0.0 || humidity > 1.1) record.fail("the relative humidity is outside of 0 ... 110 %");
    all[vapour_pressure].push_back(humidity * radiometry::heat::saturation_pressure_pa(all[air_temperature].back()));
  }
  finish_hours(std::move(all), stamps, zone_h, request.year, file);
  return file;
}

}  // namespace apps::scene
