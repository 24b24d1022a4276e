// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/weather/weather_records.h"

#include <algorithm>
#include <numbers>

#include "radiometry/weather/instant.h"
#include "radiometry/weather/sky.h"

namespace apps::scene {

using radiometry::heat::CalendarDate;
using radiometry::heat::Place;
using radiometry::heat::Stamp;
using radiometry::heat::Weather;
using enum radiometry::heat::WeatherQuantity;

bool is_day(int month, int day) { return radiometry::heat::is_date({2000, month, day}); }

void finish_hours(Weather&& records, const std::vector<HourStamp>& stamps, double zone_h, int year, WeatherFile& file) {
  if (stamps.empty()) throw mtf::UsageError(records.source + ": error: the file has no records");
  const bool typical = std::ranges::any_of(stamps, [&](const HourStamp& s) { return s.year != stamps.front().year; });
  const auto date_of = [&](const HourStamp& s) { return CalendarDate{typical ? year : s.year, s.month, s.day}; };
  for (std::size_t i = stamps.size(); i-- > 0;) {
    if (radiometry::heat::is_date(date_of(stamps[i]))) continue;
    if (!typical)
      throw mtf::UsageError(error_at(records.source, records.line[i]) + "the year " + std::to_string(stamps[i].year) +
                            " has no such day");
    records.line[i] = 0;  // to be left out
  }
  Weather& weather = file.weather;
  weather = {.source = records.source,
             .stamp = records.stamp,
             .time_s = {},
             .values = {},
             .at_stamp = records.at_stamp,
             .later_s = records.later_s};
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

double zone_h_of(const RecordCells& record, std::size_t cell) {
  const double zone_h = record.number(cell, "time zone");
  if (!(std::abs(zone_h) <= 14.0)) record.fail("the time zone is outside of -14 ... 14 h");
  return zone_h;
}

void add_humidity(const RecordCells& record, double percent, Weather& weather) {
  const double humidity = percent / 100.0;
  if (humidity < 0.0 || humidity > 1.1) record.fail("the relative humidity is outside of 0 ... 110 %");
  weather[vapour_pressure].push_back(humidity *
                                     radiometry::heat::saturation_pressure_pa(weather[air_temperature].back()));
}

}  // namespace apps::scene
