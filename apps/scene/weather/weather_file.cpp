// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/weather/weather_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "apps/scene/weather/timed_table.h"
#include "apps/scene/weather/weather_csv.h"
#include "apps/scene/weather/weather_formats.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/words.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

using radiometry::heat::CalendarDate;
using radiometry::heat::Place;
using radiometry::heat::Stamp;
using radiometry::heat::Weather;

constexpr std::array<std::string_view, 4> kFormatNames{"CSV", "EPW", "TMY3", "SURFRAD"};

WeatherFormat format_of(std::string_view text) {
  text = mtf::io::without_mark(text);
  const std::string_view first = mtf::io::take_text_line(text), second = mtf::io::take_text_line(text);
  if (first.starts_with("LOCATION,")) return WeatherFormat::epw;
  if (second.starts_with("Date (MM/DD/YYYY),")) return WeatherFormat::tmy3;
  const std::size_t version = second.find("version");
  const bool surfrad =
      version != std::string_view::npos && second.substr(0, version).find(" m ") != std::string_view::npos;
  return surfrad && second.find_first_of(",;#") == std::string_view::npos ? WeatherFormat::surfrad : WeatherFormat::csv;
}

}  // namespace

std::string_view format_name(WeatherFormat format) { return kFormatNames[static_cast<std::size_t>(format)]; }

WeatherFile parse_weather(std::string_view text, const std::string& source, const WeatherRequest& request) {
  switch (format_of(text)) {
    case WeatherFormat::epw:
      return parse_epw(text, source, request);
    case WeatherFormat::tmy3:
      return parse_tmy3(text, source, request);
    case WeatherFormat::surfrad:
      return parse_surfrad(text, source, request);
    case WeatherFormat::csv:
      break;
  }
  return parse_weather_csv(text, source, request);
}

WeatherFile read_weather(const std::string& path, const WeatherRequest& request) {
  return parse_weather(mtf::io::read_table_text(path, std::size_t{256} << 20), path, request);
}

void RecordCells::fail(const std::string& text) const { throw mtf::UsageError(error_at(source_, line_) + text); }

double RecordCells::number(std::size_t i, std::string_view name) const {
  const auto value = mtf::io::cell_number(cells_[i]);
  if (!value || !std::isfinite(*value))
    fail(std::string(name) + " \"" + mtf::printable(cells_[i], 40) + "\" is no number");
  return *value;
}

int RecordCells::whole(std::size_t i, std::string_view name) const {
  const double value = number(i, name);
  if (value != std::round(value) || std::abs(value) > 1e6)
    fail(std::string(name) + " \"" + mtf::printable(cells_[i], 40) + "\" is no whole number");
  return static_cast<int>(value);
}

double RecordCells::value(std::size_t i, std::string_view name, double mark) const {
  const double value = number(i, name);
  const bool missing = mark > 0.0 ? value >= mark : value <= mark;
  return missing ? std::nan("") : value;
}

void finish_hours(Weather&& records, const std::vector<HourStamp>& stamps, double zone_h, int year, WeatherFile& file) {
  if (stamps.empty()) throw mtf::UsageError(records.source + ": error: the file has no records");
  const bool typical =
      std::any_of(stamps.begin(), stamps.end(), [&](const HourStamp& s) { return s.year != stamps.front().year; });
  const auto date_of = [&](const HourStamp& s) { return CalendarDate{typical ? year : s.year, s.month, s.day}; };
  for (std::size_t i = stamps.size(); i-- > 0;) {
    if (radiometry::heat::is_date(date_of(stamps[i]))) continue;
    if (!typical)
      throw mtf::UsageError(error_at(records.source, records.line[i]) + "the year " + std::to_string(stamps[i].year) +
                            " has no such day");
    records.line[i] = 0;  // to be left out
  }
  Weather& weather = file.weather;
  weather = {
      .source = records.source, .stamp = records.stamp, .time_s = {}, .values = {}, .at_stamp = records.at_stamp};
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (records.line[i] == 0) continue;
    weather.time_s.push_back(radiometry::heat::instant_of(date_of(stamps[i]), stamps[i].seconds - 3600.0 * zone_h));
    weather.line.push_back(records.line[i]);
    for (std::size_t q = 0; q < radiometry::heat::kQuantities; ++q)
      if (!records.values[q].empty()) weather.values[q].push_back(records.values[q][i]);
  }
  if (weather.line.size() < stamps.size())
    file.warnings.push_back(records.source + ": warning: the records of 29 February are left out, as " +
                            std::to_string(year) + " has no such day");
  check_weather(weather);
}

Stamp stamp_of(const WeatherRequest& request, Stamp stated, WeatherFile& file, const std::string& source) {
  if (!request.stamp || *request.stamp == stated) return stated;
  file.warnings.push_back(source + ": warning: the stamps of " + std::string(format_name(file.format)) + " are the " +
                          std::string(stamp_name(stated)) + " of the interval; stamp = \"" +
                          std::string(stamp_name(*request.stamp)) + "\" is taken, as asked for");
  return *request.stamp;
}

void set_at_stamp(Weather& weather) {
  using enum radiometry::heat::WeatherQuantity;
  for (const auto quantity : {air_temperature, vapour_pressure, pressure, wind_speed, cloud_cover})
    weather.at_stamp[static_cast<std::size_t>(quantity)] = true;
}

Place place_of_degrees(double latitude_deg, double longitude_deg, double altitude_m, const std::string& source,
                       std::size_t line) {
  if (!(std::abs(latitude_deg) <= 90.0 && std::abs(longitude_deg) <= 360.0 && altitude_m >= -1000.0 &&
        altitude_m <= 1e4))
    throw mtf::UsageError(error_at(source, line) + "the station is not on the earth");
  constexpr double degree = std::numbers::pi / 180.0;
  return {latitude_deg * degree, longitude_deg * degree, altitude_m};
}

}  // namespace apps::scene
