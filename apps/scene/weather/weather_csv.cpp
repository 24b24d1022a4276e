// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/weather/weather_csv.h"

#include <algorithm>
#include <cmath>

#include "apps/scene/weather/timed_table.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/units.h"
#include "mtf/words.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sky.h"

namespace apps::scene {
namespace {

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
