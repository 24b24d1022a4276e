// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/weather/weather_file.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/units.h"
#include "mtf/words.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sky.h"

namespace apps::scene {
namespace {

using mtf::printable;

/// "air_temperature (degC)" or "air_temperature [degC]" in its two parts.
struct HeaderCell {
  std::string name, unit;
};

HeaderCell header_cell(std::string_view cell) {
  const std::size_t open = cell.find_first_of("([");
  HeaderCell parts{std::string(mtf::io::trimmed_cell(cell.substr(0, open))), {}};
  if (open == std::string_view::npos) return parts;
  const std::size_t close = cell.find_last_of(")]");
  if (close != std::string_view::npos && close > open) parts.unit = cell.substr(open + 1, close - open - 1);
  return parts;
}

class TableReader {
 public:
  TableReader(const std::string& source, double origin_s) : source_(source), origin_s_(origin_s) {}

  TimedTable read(std::string_view text) {
    text = mtf::io::without_mark(text);
    for (line_ = 1; !text.empty(); ++line_) {
      const std::string_view row = mtf::io::take_text_line(text);
      if (mtf::io::is_comment(row)) continue;
      if (table_.header_line == 0)
        read_header(row);
      else
        read_record(row);
    }
    if (table_.header_line == 0)
      throw mtf::UsageError(source_ + ": error: the table is empty; its first line has to name the columns: time, ...");
    if (table_.time_s.empty()) throw mtf::UsageError(source_ + ": error: a header and no records; add at least one");
    return std::move(table_);
  }

 private:
  [[noreturn]] void fail(const std::string& text) const { throw mtf::UsageError(error_at(source_, line_) + text); }

  void read_header(std::string_view row) {
    table_.header_line = line_;
    separator_ = mtf::io::separator_of(row);
    const auto cells = mtf::io::split_cells(row, separator_);
    const HeaderCell time = header_cell(cells.front());
    if (time.name != "time")
      fail("the first column is \"" + printable(cells.front(), 40) +
           "\"; it has to be time, as ISO 8601 with a zone, or time (s) from the start of the run");
    if (cells.size() < 2) fail("the table has no column but time (separators are comma, semicolon and tab)");
    if (cells.size() > mtf::io::kMaxTableColumns)
      fail("more than " + std::to_string(mtf::io::kMaxTableColumns) + " columns");
    if (!time.unit.empty()) {
      const auto unit = parse_unit(time.unit);
      if (!unit || !same_dimension(*unit, parse_unit("s").value()))
        fail("time (" + printable(time.unit, 20) + ") has no unit of time; write time (s), time (min) or time (h)");
      time_unit_s_ = unit->factor;
    }
    for (std::size_t i = 1; i < cells.size(); ++i) {
      const HeaderCell cell = header_cell(cells[i]);
      if (cell.name.empty()) fail("column " + std::to_string(i + 1) + " has no name");
      if (cell.unit.empty())
        fail("column \"" + printable(cell.name, 40) + "\" has no unit; write it in brackets: " +
             printable(cell.name, 40) + " (degC), (m/s), (W/m2), (hPa), (%)");
      const auto unit = parse_unit(cell.unit);
      if (!unit) fail("column \"" + printable(cell.name, 40) + "\": unknown unit \"" + printable(cell.unit, 40) + "\"");
      for (const TimedColumn& other : table_.columns)
        if (other.name == cell.name) fail("column \"" + printable(cell.name, 40) + "\" stands twice");
      table_.columns.push_back({cell.name, *unit, {}});
    }
  }

  double time_of(std::string_view cell) const {
    if (time_unit_s_) {
      const auto value = mtf::io::cell_number(cell);
      if (!value || !std::isfinite(*value)) fail("time \"" + printable(cell, 40) + "\" is no number");
      return origin_s_ + *value * *time_unit_s_;
    }
    radiometry::heat::InstantError error;
    const auto instant = radiometry::heat::parse_instant(cell, error);
    if (!instant) fail("time \"" + printable(cell, 40) + "\": " + error.text);
    return *instant;
  }

  void read_record(std::string_view row) {
    const auto cells = mtf::io::split_cells(row, separator_);
    if (cells.size() != table_.columns.size() + 1)
      fail(std::to_string(cells.size()) + " values where the header has " + std::to_string(table_.columns.size() + 1) +
           "; numbers have a decimal point, not a comma");
    if (table_.time_s.size() == mtf::io::kMaxTableRows) fail("more than a million records; thin the table out");
    table_.time_s.push_back(time_of(cells.front()));
    table_.line.push_back(line_);
    for (std::size_t i = 0; i < table_.columns.size(); ++i) {
      TimedColumn& column = table_.columns[i];
      const std::string_view cell = cells[i + 1];
      double value = std::numeric_limits<double>::quiet_NaN();
      if (!cell.empty() && cell != "nan" && cell != "NaN") {
        const auto number = mtf::io::cell_number(cell);
        if (!number || !std::isfinite(*number))
          fail("\"" + printable(cell, 40) + "\" in the column " + printable(column.name, 40) +
               " is no number; leave the cell empty where the value is missing");
        value = *number * column.unit.factor + column.unit.offset;
      }
      column.value.push_back(value);
    }
  }

  const std::string& source_;
  double origin_s_;
  std::size_t line_ = 0;
  char separator_ = ',';
  std::optional<double> time_unit_s_;
  TimedTable table_;
};

using radiometry::heat::kQuantities;
using radiometry::heat::kQuantityNames;
using radiometry::heat::Schedule;
using radiometry::heat::Stamp;
using radiometry::heat::Weather;
using radiometry::heat::WeatherQuantity;

constexpr std::string_view kRelativeHumidity = "relative_humidity", kDewPoint = "dew_point";

/// SI units by WeatherQuantity; "1" for a plain number.
constexpr std::array<std::string_view, kQuantities> kSiUnits{"K",    "m/s",  "Pa", "Pa",   "W/m2", "W/m2",
                                                             "W/m2", "W/m2", "1",  "W/m2", "W/m2"};

void require_unit(const TimedTable& table, const TimedColumn& column, std::string_view si, const std::string& source) {
  if (same_dimension(column.unit, parse_unit(si).value())) return;
  throw mtf::UsageError(error_at(source, table.header_line) + "column " + column.name +
                        " has a unit that does not fit; its SI unit is " +
                        std::string(si == "1" ? "a plain number or %" : si));
}

/// Vapour pressure from relative humidity, for the temperature of each record.
std::vector<double> from_humidity(const TimedTable& table, const TimedColumn& humidity,
                                  const std::vector<double>& temperature_k, const std::string& source) {
  std::vector<double> vapour(humidity.value.size());
  for (std::size_t i = 0; i < vapour.size(); ++i) {
    const double h = humidity.value[i];
    // Hygrometers read a little above 100 % in fog.
    if (h < 0.0 || h > 1.1)
      throw mtf::UsageError(error_at(source, table.line[i]) + "relative_humidity " + mtf::format_double(100.0 * h) +
                            " % is outside of 0 ... 110 %; is the unit in the header right?");
    vapour[i] = h * radiometry::heat::saturation_pressure_pa(temperature_k[i]);
  }
  return vapour;
}

}  // namespace

std::string error_at(const std::string& source, std::size_t line) {
  return source + ":" + std::to_string(line) + ": error: ";
}

TimedTable parse_timed_table(std::string_view text, const std::string& source, double origin_s) {
  return TableReader(source, origin_s).read(text);
}

WeatherFile parse_weather_csv(std::string_view text, const std::string& source, const WeatherRequest& request) {
  TimedTable table = parse_timed_table(text, source, request.origin_s);
  WeatherFile file;
  file.format = WeatherFormat::csv;
  Weather& weather = file.weather;
  weather.source = source;
  weather.stamp = request.stamp.value_or(Stamp::instant);
  const TimedColumn *humidity = nullptr, *dew_point = nullptr;
  for (TimedColumn& column : table.columns) {
    if (column.name == kRelativeHumidity) {
      require_unit(table, column, "1", source);
      humidity = &column;
      continue;
    }
    if (column.name == kDewPoint) {
      require_unit(table, column, "K", source);
      dew_point = &column;
      continue;
    }
    const auto found = std::find(kQuantityNames.begin(), kQuantityNames.end(), column.name);
    if (found == kQuantityNames.end()) {
      std::vector<std::string_view> known(kQuantityNames.begin(), kQuantityNames.end());
      known.insert(known.end(), {kRelativeHumidity, kDewPoint});
      const auto guess = column.name.size() <= 64 ? mtf::nearest(column.name, known) : std::nullopt;
      std::string all;
      for (const std::string_view name : known) mtf::io::append_word(all, name);
      throw mtf::UsageError(error_at(source, table.header_line) + "unknown column \"" +
                            mtf::printable(column.name, 40) + "\"" +
                            (guess ? "; did you mean \"" + *guess + "\"?" : "") + " (known: " + all + ")");
    }
    const auto q = static_cast<std::size_t>(found - kQuantityNames.begin());
    require_unit(table, column, kSiUnits[q], source);
    weather.values[q] = std::move(column.value);
  }
  const int humidities = (humidity != nullptr ? 1 : 0) + (dew_point != nullptr ? 1 : 0) +
                         (weather.has(WeatherQuantity::vapour_pressure) ? 1 : 0);
  if (humidities > 1)
    throw mtf::UsageError(error_at(source, table.header_line) +
                          "the humidity is given more than once; keep one of vapour_pressure, relative_humidity and "
                          "dew_point");
  if (humidity != nullptr) {
    if (!weather.has(WeatherQuantity::air_temperature))
      throw mtf::UsageError(error_at(source, table.header_line) +
                            "relative_humidity needs the column air_temperature; without it give vapour_pressure");
    weather[WeatherQuantity::vapour_pressure] =
        from_humidity(table, *humidity, weather[WeatherQuantity::air_temperature], source);
  }
  if (dew_point != nullptr)
    for (const double t : dew_point->value)
      weather[WeatherQuantity::vapour_pressure].push_back(radiometry::heat::saturation_pressure_pa(t));
  weather.time_s = std::move(table.time_s);
  weather.line = std::move(table.line);
  check_weather(weather);
  return file;
}

std::string weather_csv(const Weather& weather, const std::vector<std::string>& comments) {
  std::string text;
  for (const std::string& comment : comments) text += "# " + comment + "\n";
  text += "time";
  for (std::size_t q = 0; q < kQuantities; ++q)
    if (!weather.values[q].empty())
      text += "," + std::string(kQuantityNames[q]) + " (" + std::string(kSiUnits[q]) + ")";
  for (std::size_t i = 0; i < weather.time_s.size(); ++i) {
    text += "\n" + radiometry::heat::instant_text(weather.time_s[i]);
    for (const auto& values : weather.values)
      if (!values.empty()) text += "," + (std::isnan(values[i]) ? std::string() : mtf::io::number_text(values[i]));
  }
  return text + "\n";
}

Schedule parse_schedule(std::string_view text, const std::string& source, std::string_view si_unit, double origin_s) {
  TimedTable table = parse_timed_table(text, source, origin_s);
  if (table.columns.size() != 1)
    throw mtf::UsageError(error_at(source, table.header_line) + "a schedule has one column beside time, not " +
                          std::to_string(table.columns.size()));
  TimedColumn& column = table.columns.front();
  require_unit(table, column, si_unit, source);
  for (std::size_t i = 0; i < column.value.size(); ++i) {
    if (std::isnan(column.value[i]))
      throw mtf::UsageError(error_at(source, table.line[i]) + "a schedule has no missing values; remove the line");
    if (i > 0 && !(table.time_s[i] > table.time_s[i - 1]))
      throw mtf::UsageError(error_at(source, table.line[i]) +
                            "the time is not after that of the line above it; a jump " + "is two lines a second apart");
  }
  return radiometry::heat::make_schedule(source, std::move(table.time_s), std::move(column.value));
}

Schedule read_schedule(const std::string& path, std::string_view si_unit, double origin_s) {
  return parse_schedule(mtf::io::read_table_text(path), path, si_unit, origin_s);
}

}  // namespace apps::scene
