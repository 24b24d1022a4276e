// SPDX-License-Identifier: Apache-2.0

// Weather as services hand it out, in tables with columns by name.
//
// SAM CSV, of NREL's System Advisor Model, in which the National Solar Radiation Database (NSRDB) is handed out too
// (SAM help, "SAM CSV format for solar" and "Time convention and sun position"): a line of labels, a line of their
// values (place, zone, units), the names of the columns, records in local standard time. With a column Minute a record
// is of the time around its stamp, for which SAM takes the sun; temperature and the like hold at the stamp. Without it
// hours count from 0 and a record is of the hour that begins at its stamp. Missing are empty cells and values of -999
// and below.
//
// PVGIS, typical year of the European Commission's Joint Research Centre (PVGIS 5, "Typical Meteorological Year"):
// lines `name: value`, the year of each month, the names of the columns, records at whole hours of UTC,
// explanations. Sunlight is that of satellite images, or of hours, whose middle is `Irradiance Time Offset (h)` after
// the stamp, which files before 5.3 do not state; all else holds at the stamp.

#include <algorithm>
#include <array>
#include <limits>

#include "apps/scene/weather/weather_records.h"
#include "mtf/units.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sky.h"

namespace apps::scene {
namespace {

using radiometry::heat::Stamp;
using radiometry::heat::Weather;
using radiometry::heat::WeatherQuantity;
using enum radiometry::heat::WeatherQuantity;

using Words = std::array<std::string_view, 3>;

struct ServiceColumn {
  WeatherQuantity quantity;
  Words names;  ///< in small letters
  Words units;  ///< that they may be stated in
  double factor = 1.0, offset = 0.0;
};

constexpr Words kPerArea{"w/m2", "w/m^2", ""}, kDegrees{"c", "degc", "\u00b0c"}, kPercent{"%", "", ""};

constexpr std::array kSamColumns{
    ServiceColumn{global_horizontal, {"ghi", "gh", "global"}, kPerArea},
    ServiceColumn{direct_normal, {"dni", "dn", "beam"}, kPerArea},
    ServiceColumn{diffuse_horizontal, {"dhi", "df", "diffuse"}, kPerArea},
    ServiceColumn{air_temperature, {"temperature", "tdry", "dry bulb"}, kDegrees, 1.0, mtf::kZeroCelsius_k},
    ServiceColumn{pressure, {"pressure", "pres", ""}, {"mbar", "hpa", "millibar"}, 100.0},
    ServiceColumn{wind_speed, {"wind speed", "wspd", ""}, {"m/s", "", ""}}};
constexpr std::array kPvgisColumns{ServiceColumn{global_horizontal, {"g(h)"}, {}},
                                   ServiceColumn{direct_normal, {"gb(n)"}, {}},
                                   ServiceColumn{diffuse_horizontal, {"gd(h)"}, {}},
                                   ServiceColumn{longwave_down, {"ir(h)"}, {}},
                                   ServiceColumn{air_temperature, {"t2m"}, {}, 1.0, mtf::kZeroCelsius_k},
                                   ServiceColumn{pressure, {"sp"}, {}},
                                   ServiceColumn{wind_speed, {"ws10m"}, {}}};
constexpr Words kHumidityNames{"relative humidity", "rh", "rhum"}, kDewPointNames{"dew point", "tdew", "dewpoint"};
constexpr double kServiceMissingMark = -999.0;
constexpr std::size_t kAbsent = std::numeric_limits<std::size_t>::max();

/// The cell that has one of these names, in letters of any size.
std::size_t cell_named(const std::vector<std::string_view>& cells, std::span<const std::string_view> names) {
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (!cells[i].empty() && std::ranges::find(names, mtf::lower_case(cells[i])) != names.end()) return i;
  return kAbsent;
}
std::size_t cell_named(const std::vector<std::string_view>& cells, std::string_view name) {
  return cell_named(cells, std::span(&name, 1));
}

/// Where the columns of a table stand, and its records as weather.
class ServiceTable {
 public:
  ServiceTable(std::span<const ServiceColumn> columns, const RecordCells& header,
               const std::vector<std::string_view>& names)
      : columns_(columns) {
    std::vector<std::string_view> known;
    for (const ServiceColumn& column : columns) {
      cells_.push_back(cell_named(names, column.names));
      known.push_back(column.names.front());
    }
    humidity_ = cell_named(names, kHumidityNames);
    dew_point_ = humidity_ == kAbsent ? cell_named(names, kDewPointNames) : kAbsent;
    temperature_ = cells_[static_cast<std::size_t>(
        std::ranges::find(columns, air_temperature, &ServiceColumn::quantity) - columns.begin())];
    if (std::ranges::all_of(cells_, [](std::size_t cell) { return cell == kAbsent; }))
      header.fail("none of the columns has a name that is known: " + mtf::joined(known));
    if (humidity_ != kAbsent && temperature_ == kAbsent) header.fail("the humidity needs a column of the temperature");
  }

  /// Throws where a unit that the file states beside a name is another one. `unit_of` gives it, "" = it states none.
  template <class UnitOf>
  void check_units(const RecordCells& where, UnitOf unit_of) const {
    const auto check = [&](std::size_t cell, const Words& units) {
      if (cell == kAbsent) return;
      const std::string unit = mtf::lower_case(unit_of(cell));
      if (!unit.empty() && std::ranges::find(units, unit) == units.end())
        where.fail("column " + std::to_string(cell + 1) + " has the unit \"" + mtf::printable(unit, 20) + "\", and " +
                   std::string(units.front()) + " is needed; convert it");
    };
    for (std::size_t i = 0; i < cells_.size(); ++i) check(cells_[i], columns_[i].units);
    check(humidity_, kPercent);
    check(dew_point_, kDegrees);
  }

  void add(const RecordCells& record, std::size_t count, Weather& weather) const {
    const auto value = [&](std::size_t cell, std::string_view name) {
      if (cell >= count) record.fail(std::to_string(count) + " cells where the header has more");
      return record.text(cell).empty() ? std::nan("") : record.value(cell, name, kServiceMissingMark);
    };
    for (std::size_t i = 0; i < cells_.size(); ++i)
      if (cells_[i] != kAbsent)
        weather[columns_[i].quantity].push_back(
            value(cells_[i], quantity_name(columns_[i].quantity)) * columns_[i].factor + columns_[i].offset);
    if (humidity_ != kAbsent) add_humidity(record, value(humidity_, "relative humidity"), weather);
    if (dew_point_ != kAbsent)
      weather[vapour_pressure].push_back(
          radiometry::heat::saturation_pressure_pa(value(dew_point_, "dew point") + mtf::kZeroCelsius_k));
  }

 private:
  std::span<const ServiceColumn> columns_;
  std::vector<std::size_t> cells_;
  std::size_t humidity_ = kAbsent, dew_point_ = kAbsent, temperature_ = kAbsent;
};

/// A line in cells, which lives as long as both.
std::vector<std::string_view> next_cells(std::string_view& text) {
  const std::string_view row = mtf::io::take_text_line(text);
  return mtf::io::split_cells(row, ',', row.size());
}

HourStamp checked_stamp(const RecordCells& record, int year, int month, int day, int hour, int minute) {
  if (!is_day(month, day) || hour < 0 || hour > 23 || minute < 0 || minute > 59)
    record.fail("no such date or time; hours are from 0 to 23");
  return {year, month, day, 3600.0 * hour + 60.0 * minute};
}

/// "20160131:2300".
HourStamp pvgis_stamp(const RecordCells& record) {
  const std::string_view text = record.text(0);
  const auto part = [&](std::size_t at, std::size_t size) -> int {
    const auto value =
        text.size() == 13 && text[8] == ':' ? mtf::io::cell_number<int>(text.substr(at, size)) : std::nullopt;
    if (!value) record.fail("\"" + mtf::printable(text, 20) + "\" is no date and time; they are like 20160131:2300");
    return *value;
  };
  return checked_stamp(record, part(0, 4), part(4, 2), part(6, 2), part(9, 2), part(11, 2));
}

}  // namespace

WeatherFile parse_sam_csv(std::string_view text, const std::string& source, const WeatherRequest& request) {
  WeatherFile file;
  file.format = WeatherFormat::sam;
  const auto labels = next_cells(text), values = next_cells(text), names = next_cells(text);
  const RecordCells head(source, 2, values), header(source, 3, names);
  const auto stated = [&](std::initializer_list<std::string_view> label) {
    const std::size_t cell = cell_named(labels, std::span(label.begin(), label.size()));
    if (cell >= values.size()) head.fail("\"" + std::string(*label.begin()) + "\" has no value in the first two lines");
    return cell;
  };
  file.place = place_of_degrees(head.number(stated({"latitude", "lat"}), "latitude"),
                                head.number(stated({"longitude", "lon"}), "longitude"),
                                head.number(stated({"elevation", "elev"}), "elevation"), source, 2);
  const double zone_h = zone_h_of(head, stated({"time zone", "timezone", "tz"}));

  const ServiceTable table(kSamColumns, header, names);
  table.check_units(head, [&](std::size_t cell) -> std::string_view {
    const std::size_t label = cell_named(labels, mtf::lower_case(names[cell]) + " units");
    return label < values.size() ? values[label] : std::string_view();
  });
  std::array<std::size_t, 4> date{};
  constexpr std::array<std::string_view, 4> parts{"year", "month", "day", "hour"};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    date[i] = cell_named(names, parts[i]);
    if (date[i] == kAbsent) header.fail("the column \"" + std::string(parts[i]) + "\" is missing");
  }
  const std::size_t minute_cell = cell_named(names, "minute");
  const std::size_t last = std::max({date[0], date[1], date[2], date[3], minute_cell == kAbsent ? 0 : minute_cell});
  const Stamp format_stamp = minute_cell == kAbsent ? Stamp::begin : Stamp::middle;
  Weather all{.source = source, .stamp = stamp_of(request, format_stamp, file, source), .time_s = {}, .values = {}};
  if (minute_cell != kAbsent) set_at_stamp(all);
  std::vector<HourStamp> stamps;
  for (std::size_t line = 4; !text.empty(); ++line) {
    const auto cells = next_cells(text);
    if (cells.size() == 1 && cells.front().empty()) continue;
    const RecordCells record(source, line, cells);
    if (line == 4 && !mtf::io::cell_number(cells.front())) {  // units below the names
      table.check_units(record, [&](std::size_t cell) { return cell < cells.size() ? cells[cell] : ""; });
      continue;
    }
    if (cells.size() <= last) record.fail(std::to_string(cells.size()) + " cells where the header has more");
    stamps.push_back(checked_stamp(record, record.whole(date[0], "year"), record.whole(date[1], "month"),
                                   record.whole(date[2], "day"), record.whole(date[3], "hour"),
                                   minute_cell == kAbsent ? 0 : record.whole(minute_cell, "minute")));
    all.line.push_back(line);
    table.add(record, cells.size(), all);
  }
  finish_hours(std::move(all), stamps, zone_h, request.year, file);
  return file;
}

WeatherFile parse_pvgis(std::string_view text, const std::string& source, const WeatherRequest& request) {
  WeatherFile file;
  file.format = WeatherFormat::pvgis;
  std::array<std::optional<double>, 4> stated{};  // latitude, longitude, elevation, offset of sunlight in h
  constexpr std::array<std::string_view, 4> starts{"Latitude", "Longitude", "Elevation", "Irradiance Time Offset"};
  std::size_t line = 0;
  std::vector<std::string_view> names;
  while (!text.empty() && (names.empty() || !names.front().starts_with("time"))) {
    names = next_cells(text);
    ++line;
    for (std::size_t i = 0; i < starts.size(); ++i)
      if (const std::size_t colon = names.front().find(':');
          names.front().starts_with(starts[i]) && colon != std::string_view::npos) {
        const std::vector<std::string_view> value{mtf::io::trimmed_cell(names.front().substr(colon + 1))};
        stated[i] = RecordCells(source, line, value).number(0, starts[i]);
      }
  }
  const RecordCells header(source, line, names);
  if (names.empty() || !names.front().starts_with("time")) header.fail("no line of columns that begins with time");
  if (cell_named(names, "gb(i)") != kAbsent || cell_named(names, "g(i)") != kAbsent)
    header.fail(
        "hours of PVGIS on an inclined plane (i) do not tell sunlight on others; download its typical "
        "meteorological year (TMY) as CSV");
  if (stated[0] && stated[1] && stated[2])
    file.place = place_of_degrees(*stated[0], *stated[1], *stated[2], source, line);

  const ServiceTable table(kPvgisColumns, header, names);
  Weather all{.source = source, .stamp = stamp_of(request, Stamp::middle, file, source), .time_s = {}, .values = {}};
  set_at_stamp(all);
  all.at_stamp[static_cast<std::size_t>(longwave_down)] = true;
  if (stated[3] && std::abs(*stated[3]) > 1.0) header.fail("the irradiance time offset is outside of -1 ... 1 h");
  if (all.stamp == Stamp::middle) all.later_s = 3600.0 * stated[3].value_or(0.0);
  if (!stated[3])
    file.warnings.push_back(source +
                            ": warning: the file does not state its irradiance time offset, as those of PVGIS 5.3 do; "
                            "sunlight is taken to be that around the stamp, and may be up to half an hour off");
  std::vector<HourStamp> stamps;
  std::size_t explanation = 0;  // the line of the first
  while (!text.empty()) {
    const auto cells = next_cells(text);
    ++line;
    if (cells.size() == 1 && cells.front().empty()) continue;
    const bool digit = !cells.front().empty() && cells.front().front() >= '0' && cells.front().front() <= '9';
    if (digit && explanation > 0 && cells.size() == names.size())
      RecordCells(source, explanation, cells).fail("this line is no record, and records follow it; take it out");
    if (!digit && cells.size() < names.size() && explanation == 0) explanation = line;
    if (explanation > 0) continue;
    const RecordCells record(source, line, cells);
    stamps.push_back(pvgis_stamp(record));
    all.line.push_back(line);
    table.add(record, cells.size(), all);
  }
  finish_hours(std::move(all), stamps, 0.0, request.year, file);
  return file;
}

}  // namespace apps::scene
