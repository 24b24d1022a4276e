// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/weather/weather_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "apps/scene/weather/weather_records.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/units.h"
#include "mtf/words.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sky.h"

namespace apps::scene {
namespace {

using radiometry::heat::CalendarDate;
using radiometry::heat::Place;
using radiometry::heat::Stamp;
using radiometry::heat::Weather;
using radiometry::heat::WeatherQuantity;
using enum radiometry::heat::WeatherQuantity;

// EPW, EnergyPlus weather (Auxiliary Programs, "EnergyPlus Weather File (EPW) Data Dictionary"): eight header lines, of
// which LOCATION has the place and the zone, then one line a record with 35 cells. Hours count from 1 and end at their
// stamp in local standard time. Solar columns are Wh/m2 received in the minutes before the stamp; for hourly records
// that is the mean in W/m2. So, by its unit, is the long wave, of which the dictionary does not say when it was
// received. Temperature, humidity, pressure, wind and clouds hold at the time indicated.

constexpr std::size_t kEpwHeaderLines = 8, kEpwCells = 35, kEpwOldCells = 32;  // older files end before albedo and rain

/// A column of the data: where it stands, from which value on it is missing, and how it becomes SI.
struct EpwColumn {
  WeatherQuantity quantity;
  std::size_t cell;
  double mark, factor, offset;
  bool is_sum;  ///< Wh/m2 over the record
};
constexpr std::array kEpwColumns{EpwColumn{air_temperature, 6, 99.9, 1.0, mtf::kZeroCelsius_k, false},
                                 EpwColumn{pressure, 9, 999999.0, 1.0, 0.0, false},
                                 EpwColumn{longwave_down, 12, 9999.0, 1.0, 0.0, true},
                                 EpwColumn{global_horizontal, 13, 9999.0, 1.0, 0.0, true},
                                 EpwColumn{direct_normal, 14, 9999.0, 1.0, 0.0, true},
                                 EpwColumn{diffuse_horizontal, 15, 9999.0, 1.0, 0.0, true},
                                 EpwColumn{wind_speed, 21, 999.0, 1.0, 0.0, false},
                                 EpwColumn{cloud_cover, 23, 99.0, 0.1, 0.0, false}};
constexpr std::size_t kEpwHumidityCell = 8;  // %, missing from 999 on

WeatherFile parse_epw(std::string_view text, const std::string& source, const WeatherRequest& request) {
  WeatherFile file;
  file.format = WeatherFormat::epw;
  double zone_h = 0.0, per_hour = 1.0;
  std::vector<HourStamp> stamps;
  Weather all{.source = source, .stamp = stamp_of(request, Stamp::end, file, source), .time_s = {}, .values = {}};
  set_at_stamp(all);
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::string_view row = mtf::io::take_text_line(text);
    if (mtf::io::trimmed_cell(row).empty()) continue;
    const auto cells = mtf::io::split_cells(row, ',', row.size());
    const RecordCells record(source, line, cells);
    if (line == 1) {
      if (cells.size() < 10) record.fail("LOCATION has " + std::to_string(cells.size()) + " cells, 10 are needed");
      file.place = place_of_degrees(record.number(6, "latitude"), record.number(7, "longitude"),
                                    record.number(9, "elevation"), source, line);
      zone_h = zone_h_of(record, 8);
    }
    if (line <= kEpwHeaderLines) {
      if (cells.front() == "DATA PERIODS" && cells.size() > 2) per_hour = record.number(2, "records per hour");
      if (!(per_hour >= 1.0 && per_hour <= 60.0)) record.fail("records per hour are outside of 1 ... 60");
      continue;
    }
    if (cells.size() != kEpwOldCells && cells.size() < kEpwCells)
      record.fail(std::to_string(cells.size()) + " cells in a record, " + std::to_string(kEpwCells) + " or " +
                  std::to_string(kEpwOldCells) + " are needed");
    const int hour = record.whole(3, "hour"), minute = record.whole(4, "minute");
    const HourStamp stamp{record.whole(0, "year"), record.whole(1, "month"), record.whole(2, "day"),
                          3600.0 * (hour - 1) + 60.0 * (minute == 0 ? 60 : minute)};
    if (!is_day(stamp.month, stamp.day) || hour < 1 || hour > 24 || minute < 0 || minute > 60)
      record.fail("no such date or hour; hours are from 1 to 24");
    stamps.push_back(stamp);
    all.line.push_back(line);
    for (const EpwColumn& column : kEpwColumns) {
      const double factor = column.is_sum ? per_hour : column.factor;
      all[column.quantity].push_back(record.value(column.cell, quantity_name(column.quantity), column.mark) * factor +
                                     column.offset);
    }
    add_humidity(record, record.value(kEpwHumidityCell, "relative humidity", 999.0), all);
  }
  finish_hours(std::move(all), stamps, zone_h, request.year, file);
  return file;
}

// TMY3, typical meteorological year, version 3 (Wilcox and Marion, NREL/TP-581-43156 (2008)): the first line has
// station, zone and place, the second one the names of the columns with their units, then one line an hour, in local
// standard time (01:00 ... 24:00). Sunlight is that of the 60 minutes that end at the stamp; all else holds at the time
// indicated. Missing values are -9900.

constexpr double kTmy3MissingMark = -9900.0;

struct Tmy3Column {
  WeatherQuantity quantity;
  std::string_view name;
  double factor, offset;
};
constexpr std::array kTmy3Columns{Tmy3Column{global_horizontal, "GHI (W/m^2)", 1.0, 0.0},
                                  Tmy3Column{direct_normal, "DNI (W/m^2)", 1.0, 0.0},
                                  Tmy3Column{diffuse_horizontal, "DHI (W/m^2)", 1.0, 0.0},
                                  Tmy3Column{air_temperature, "Dry-bulb (C)", 1.0, mtf::kZeroCelsius_k},
                                  Tmy3Column{pressure, "Pressure (mbar)", 100.0, 0.0},
                                  Tmy3Column{wind_speed, "Wspd (m/s)", 1.0, 0.0},
                                  Tmy3Column{cloud_cover, "OpqCld (tenths)", 0.1, 0.0}};
constexpr std::string_view kTmy3Humidity = "RHum (%)";

/// "01/31/1988" and "24:00".
HourStamp stamp_of(const RecordCells& record) {
  const std::string_view date = record.text(0), time = record.text(1);
  const auto part = [&](std::string_view text, std::size_t at, std::size_t size) {
    return text.size() >= at + size ? mtf::io::cell_number<int>(text.substr(at, size)) : std::nullopt;
  };
  const auto month = part(date, 0, 2), day = part(date, 3, 2), year = part(date, 6, 4), hour = part(time, 0, 2),
             minute = part(time, 3, 2);
  const bool good = month && day && year && hour && minute && date.size() == 10 && time.size() == 5 && date[2] == '/' &&
                    date[5] == '/' && time[2] == ':' && is_day(*month, *day) && *hour >= 0 && *minute >= 0 &&
                    *minute < 60 && 60 * *hour + *minute <= 24 * 60;
  if (!good)
    record.fail("\"" + mtf::printable(date, 20) + " " + mtf::printable(time, 20) +
                "\" is no date and time; they are like 01/31/1988 and 24:00");
  return {*year, *month, *day, 3600.0 * *hour + 60.0 * *minute};
}

WeatherFile parse_tmy3(std::string_view text, const std::string& source, const WeatherRequest& request) {
  WeatherFile file;
  file.format = WeatherFormat::tmy3;

  const std::string_view station = mtf::io::take_text_line(text);
  const auto station_cells = mtf::io::split_cells(station, ',', station.size());
  const RecordCells head(source, 1, station_cells);
  if (station_cells.size() != 7)
    head.fail(std::to_string(station_cells.size()) +
              " cells, 7 are needed: number, name, state, zone, latitude, longitude, elevation");
  const double zone_h = zone_h_of(head, 3);
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
  std::array<std::size_t, kTmy3Columns.size()> cells_of{};
  std::transform(kTmy3Columns.begin(), kTmy3Columns.end(), cells_of.begin(),
                 [&](const Tmy3Column& c) { return cell_of(c.name); });
  const std::size_t humidity_cell = cell_of(kTmy3Humidity);

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
    for (std::size_t i = 0; i < kTmy3Columns.size(); ++i) {
      const Tmy3Column& column = kTmy3Columns[i];
      all[column.quantity].push_back(record.value(cells_of[i], column.name, kTmy3MissingMark) * column.factor +
                                     column.offset);
    }
    add_humidity(record, record.value(humidity_cell, kTmy3Humidity, kTmy3MissingMark), all);
  }
  finish_hours(std::move(all), stamps, zone_h, request.year, file);
  return file;
}

// SURFRAD, surface radiation budget network, daily files (NOAA Global Monitoring Laboratory, README of the archive):
// the first line names the station, the second one has latitude, longitude (west positive), altitude and the version,
// then one line a minute in UTC: 8 numbers of the time, then 20 pairs of a value and its quality flag (0 good, 1 bad, 2
// doubtful). Values are means over the interval that ends at the stamp. -9999.9 is missing; a value whose flag is not 0
// is taken as missing, too.

constexpr std::size_t kSurfradCells = 48;
constexpr double kSurfradMissingMark = -9999.0;

struct SurfradColumn {
  WeatherQuantity quantity;
  std::size_t cell;  ///< its flag follows
  double factor, offset;
};
constexpr std::array kSurfradColumns{SurfradColumn{global_horizontal, 8, 1.0, 0.0},
                                     SurfradColumn{solar_up, 10, 1.0, 0.0},
                                     SurfradColumn{direct_normal, 12, 1.0, 0.0},
                                     SurfradColumn{diffuse_horizontal, 14, 1.0, 0.0},
                                     SurfradColumn{longwave_down, 16, 1.0, 0.0},
                                     SurfradColumn{longwave_up, 22, 1.0, 0.0},
                                     SurfradColumn{air_temperature, 38, 1.0, mtf::kZeroCelsius_k},
                                     SurfradColumn{wind_speed, 42, 1.0, 0.0},
                                     SurfradColumn{pressure, 46, 100.0, 0.0}};
constexpr std::size_t kSurfradHumidityCell = 40;

WeatherFile parse_surfrad(std::string_view text, const std::string& source, const WeatherRequest& request) {
  WeatherFile file;
  file.format = WeatherFormat::surfrad;
  Weather& weather = file.weather;
  weather.source = source;
  weather.stamp = stamp_of(request, Stamp::end, file, source);
  mtf::io::take_text_line(text);
  const auto station = mtf::io::split_words(mtf::io::take_text_line(text));
  const RecordCells head(source, 2, station);
  if (station.size() < 3) head.fail("the line has to state latitude, longitude and altitude");
  file.place =
      place_of_degrees(head.number(0, "latitude"), -head.number(1, "longitude"), head.number(2, "altitude"), source, 2);

  std::size_t flagged = 0;
  for (std::size_t line = 3; !text.empty(); ++line) {
    const auto cells = mtf::io::split_words(mtf::io::take_text_line(text));
    if (cells.empty()) continue;
    const RecordCells record(source, line, cells);
    if (cells.size() != kSurfradCells)
      record.fail(std::to_string(cells.size()) + " numbers, " + std::to_string(kSurfradCells) + " are needed");
    const CalendarDate date{record.whole(0, "year"), record.whole(2, "month"), record.whole(3, "day")};
    const int hour = record.whole(4, "hour"), minute = record.whole(5, "minute");
    if (!is_date(date) || hour < 0 || hour > 23 || minute < 0 || minute > 59) record.fail("no such date or time");
    weather.time_s.push_back(radiometry::heat::instant_of(date, 3600.0 * hour + 60.0 * minute));
    weather.line.push_back(line);
    const auto read = [&](std::size_t cell, std::string_view name) {
      const double value = record.value(cell, name, kSurfradMissingMark);
      if (record.whole(cell + 1, "quality flag") == 0 || std::isnan(value)) return value;
      ++flagged;
      return std::numeric_limits<double>::quiet_NaN();
    };
    for (const SurfradColumn& column : kSurfradColumns)
      weather[column.quantity].push_back(read(column.cell, quantity_name(column.quantity)) * column.factor +
                                         column.offset);
    add_humidity(record, read(kSurfradHumidityCell, "relative humidity"), weather);
  }
  if (weather.time_s.empty()) throw mtf::UsageError(source + ": error: the file has no records");
  if (flagged > 0)
    file.warnings.push_back(source + ": warning: " + std::to_string(flagged) +
                            " values with a quality flag other than 0 are taken as missing");
  check_weather(weather);
  return file;
}

// TMY2 (Marion and Urban, User's Manual for TMY2s, NREL (1995)): a header line with station, zone and place, then 142
// characters an hour, cells by their position, in local standard time (1 ... 24). Sunlight is that of the 60 minutes
// that end at the hour; all else holds at the hour. Missing values are nines over the whole cell.

constexpr std::size_t kTmy2Characters = 142;

struct Tmy2Column {
  WeatherQuantity quantity;
  std::size_t first, characters;  ///< counted from 0
  double factor, offset;
};
constexpr std::array kTmy2Columns{Tmy2Column{global_horizontal, 17, 4, 1.0, 0.0},
                                  Tmy2Column{direct_normal, 23, 4, 1.0, 0.0},
                                  Tmy2Column{diffuse_horizontal, 29, 4, 1.0, 0.0},
                                  Tmy2Column{cloud_cover, 63, 2, 0.1, 0.0},
                                  Tmy2Column{air_temperature, 67, 4, 0.1, mtf::kZeroCelsius_k},
                                  Tmy2Column{pressure, 84, 4, 100.0, 0.0},
                                  Tmy2Column{wind_speed, 95, 3, 0.1, 0.0}};
constexpr std::size_t kTmy2Humidity = 79, kTmy2HumidityCharacters = 3;

/// Whether a line is the header of TMY2: the zone, N or S with degrees and minutes, E or W with the same, the altitude.
bool starts_as_tmy2(std::string_view line) {
  return line.size() >= 57 && line.size() < 80 && line[0] == ' ' && (line[37] == 'N' || line[37] == 'S') &&
         (line[45] == 'E' || line[45] == 'W') && line.find(',') == std::string_view::npos;
}

WeatherFile parse_tmy2(std::string_view text, const std::string& source, const WeatherRequest& request) {
  WeatherFile file;
  file.format = WeatherFormat::tmy2;
  const std::string_view head = mtf::io::take_text_line(text);
  std::vector<std::string_view> cells;
  for (const auto& [at, characters] :
       {std::pair{33, 3}, {39, 2}, {42, 2}, {47, 3}, {51, 2}, {55, 4}})  // zone, latitude, longitude, altitude
    cells.push_back(mtf::io::trimmed_cell(head.substr(static_cast<std::size_t>(at), characters)));
  const RecordCells station(source, 1, cells);
  const double zone_h = zone_h_of(station, 0);
  const auto degrees = [&](std::size_t cell, bool negative) {
    const double value = station.number(cell, "degrees") + station.number(cell + 1, "minutes") / 60.0;
    return negative ? -value : value;
  };
  file.place = place_of_degrees(degrees(1, head[37] == 'S'), degrees(3, head[45] == 'W'),
                                station.number(5, "elevation"), source, 1);

  Weather all{.source = source, .stamp = stamp_of(request, Stamp::end, file, source), .time_s = {}, .values = {}};
  set_at_stamp(all);
  std::vector<HourStamp> stamps;
  for (std::size_t line = 2; !text.empty(); ++line) {
    const std::string_view row = mtf::io::take_text_line(text);
    if (mtf::io::trimmed_cell(row).empty()) continue;
    const std::size_t size = row.ends_with('\r') ? row.size() - 1 : row.size();
    cells.clear();
    const auto add = [&](std::size_t first, std::size_t characters) {
      if (size == kTmy2Characters) cells.push_back(mtf::io::trimmed_cell(row.substr(first, characters)));
    };
    for (std::size_t i = 0; i < 4; ++i) add(1 + 2 * i, 2);  // year, month, day, hour
    for (const Tmy2Column& column : kTmy2Columns) add(column.first, column.characters);
    add(kTmy2Humidity, kTmy2HumidityCharacters);
    const RecordCells record(source, line, cells);
    if (size != kTmy2Characters)
      record.fail(std::to_string(size) + " characters, " + std::to_string(kTmy2Characters) + " are needed");
    const HourStamp stamp{1900 + record.whole(0, "year"), record.whole(1, "month"), record.whole(2, "day"),
                          3600.0 * record.whole(3, "hour")};
    if (!is_day(stamp.month, stamp.day) || stamp.seconds < 3600.0 || stamp.seconds > 86400.0)
      record.fail("no such date or hour; hours are from 1 to 24");
    stamps.push_back(stamp);
    all.line.push_back(line);
    const auto value = [&](std::size_t cell, std::size_t characters, std::string_view name) {
      const bool missing = record.text(cell) == std::string(characters, '9');  // "  99" is a value
      return missing ? std::numeric_limits<double>::quiet_NaN() : record.number(cell, name);
    };
    for (std::size_t i = 0; i < kTmy2Columns.size(); ++i) {
      const Tmy2Column& column = kTmy2Columns[i];
      all[column.quantity].push_back(value(4 + i, column.characters, quantity_name(column.quantity)) * column.factor +
                                     column.offset);
    }
    add_humidity(record, value(4 + kTmy2Columns.size(), kTmy2HumidityCharacters, "relative humidity"), all);
  }
  finish_hours(std::move(all), stamps, zone_h, request.year, file);
  return file;
}

/// The first lines of a file, by which its format is known.
struct FirstLines {
  std::string_view first{}, second{}, row{};  ///< the row is the first one that is no comment
};

struct WeatherReader {
  std::string_view name, known_by;
  bool (*starts)(const FirstLines& lines);
  WeatherFile (*parse)(std::string_view text, const std::string& source, const WeatherRequest& request);
};

bool starts_as_surfrad(const FirstLines& lines) {
  const std::size_t version = lines.second.find("version");
  return version != std::string_view::npos && lines.second.substr(0, version).find(" m ") != std::string_view::npos &&
         lines.second.find_first_of(",;#") == std::string_view::npos;
}

bool starts_as_sam(const FirstLines& lines) {
  const std::string labels = "," + mtf::lower_case(lines.first);
  return labels.find(",lat") != std::string::npos && labels.find(",lon") != std::string::npos;
}

/// By WeatherFormat.
constexpr std::array kWeatherReaders{
    WeatherReader{"CSV", "a first column that has to be time, as in time,air_temperature (degC)",
                  [](const FirstLines& lines) {
                    return lines.row.empty() || mtf::io::trimmed_cell(lines.row).starts_with("time");
                  },
                  parse_weather_csv},
    WeatherReader{"EPW", "LOCATION, at the start",
                  [](const FirstLines& lines) { return lines.first.starts_with("LOCATION,"); }, parse_epw},
    WeatherReader{"TMY2", "a header of fixed columns: station, zone, N and W with degrees and minutes",
                  [](const FirstLines& lines) { return starts_as_tmy2(lines.first); }, parse_tmy2},
    WeatherReader{"TMY3", "Date (MM/DD/YYYY) in the second line",
                  [](const FirstLines& lines) { return lines.second.starts_with("Date (MM/DD/YYYY),"); }, parse_tmy3},
    WeatherReader{"SURFRAD", "the place and its version in the second line", starts_as_surfrad, parse_surfrad},
    WeatherReader{"SAM CSV (NSRDB)", "the labels Latitude and Longitude in the first line", starts_as_sam,
                  parse_sam_csv},
    WeatherReader{"PVGIS TMY", "Latitude (decimal degrees) or time(UTC) at the start",
                  [](const FirstLines& lines) {
                    return lines.first.starts_with("Latitude (decimal") || lines.first.starts_with("time(UTC)");
                  },
                  parse_pvgis}};

}  // namespace

std::string_view format_name(WeatherFormat format) { return kWeatherReaders[static_cast<std::size_t>(format)].name; }

WeatherFile parse_weather(std::string_view text, const std::string& source, const WeatherRequest& request) {
  text = mtf::io::without_mark(text);
  std::string_view rest = text;
  FirstLines lines{.first = mtf::io::take_text_line(rest)};
  lines.row = lines.first;
  for (std::string_view after = rest; mtf::io::is_comment(lines.row) && !after.empty();)
    lines.row = mtf::io::take_text_line(after);
  if (mtf::io::is_comment(lines.row)) lines.row = {};
  lines.second = mtf::io::take_text_line(rest);
  // What names its format comes before our own CSV, of which the first word alone is known.
  for (auto reader = kWeatherReaders.rbegin(); reader != kWeatherReaders.rend(); ++reader)
    if (reader->starts(lines)) return reader->parse(text, source, request);
  throw mtf::UsageError(error_at(source, 1) + "none of the formats of weather that are read: " +
                        mtf::joined(kWeatherReaders,
                                    [](const WeatherReader& reader) {
                                      return std::string(reader.name) + " (" + std::string(reader.known_by) + ")";
                                    }) +
                        "; convert the file to one of them");
}

WeatherFile read_weather(const std::string& path, const WeatherRequest& request) {
  return parse_weather(mtf::io::read_table_text(path, std::size_t{256} << 20), path, request);
}

}  // namespace apps::scene
