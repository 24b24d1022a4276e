// SPDX-License-Identifier: Apache-2.0
#pragma once

// Weather as records over time, as a station writes them. Values are SI; a column may be absent as a whole, and a
// single value may be missing (NaN). What a record's time stands for is said by `stamp`: the instant of the values, or
// the begin, the middle or the end of an interval whose means they are. In files of that kind some columns may hold at
// the stamp itself: hours of sunlight stand beside the temperature at the end of the hour. weather_series.h makes of it
// functions of time.

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace radiometry::heat {

enum class WeatherQuantity {
  air_temperature,     ///< K
  wind_speed,          ///< m/s
  vapour_pressure,     ///< Pa, partial pressure of water vapour
  pressure,            ///< Pa, at the station
  direct_normal,       ///< W/m2, beam of the sun on a plane that faces it
  diffuse_horizontal,  ///< W/m2, solar without the beam
  global_horizontal,   ///< W/m2, both on a horizontal plane
  longwave_down,       ///< W/m2, thermal irradiance of a horizontal plane
  cloud_cover,         ///< fraction of the sky, 0 to 1
  longwave_up,         ///< W/m2, thermal irradiance from the ground: tells its temperature
  solar_up             ///< W/m2, solar irradiance from the ground: tells its albedo
};
inline constexpr std::size_t kQuantities = 11;

/// "air_temperature", ...: the names of columns in files and of keys in scene files.
inline constexpr std::array<std::string_view, kQuantities> kQuantityNames{
    "air_temperature",   "wind_speed",    "vapour_pressure", "pressure",    "direct_normal", "diffuse_horizontal",
    "global_horizontal", "longwave_down", "cloud_cover",     "longwave_up", "solar_up"};
constexpr std::string_view quantity_name(WeatherQuantity quantity) {
  return kQuantityNames[static_cast<std::size_t>(quantity)];
}

enum class Stamp { instant, begin, end, middle };
inline constexpr std::array<std::string_view, 4> kStampNames{"instant", "begin", "end", "middle"};
constexpr std::string_view stamp_name(Stamp stamp) { return kStampNames[static_cast<std::size_t>(stamp)]; }
/// From the stamp to the middle of what it stands for, in intervals.
constexpr double to_middle(Stamp stamp) { return stamp == Stamp::begin ? 0.5 : stamp == Stamp::end ? -0.5 : 0.0; }

struct Weather {
  std::string source;  ///< file it came from, for messages
  Stamp stamp = Stamp::instant;
  std::vector<double> time_s{};                           ///< UTC (instant.h), strictly rising
  std::array<std::vector<double>, kQuantities> values{};  ///< by WeatherQuantity, as long as time_s; empty: absent
  std::vector<std::size_t> line{};                        ///< of the source, by record; empty where there are no lines
  std::array<bool, kQuantities> at_stamp{};               ///< columns that hold at the stamp, whatever it stands for
  double later_s = 0.0;  ///< by which the intervals of means lie later than `stamp` says, as where satellites look

  bool is_mean(std::size_t quantity) const { return stamp != Stamp::instant && !at_stamp[quantity]; }
  bool has(WeatherQuantity quantity) const { return !values[static_cast<std::size_t>(quantity)].empty(); }
  std::vector<double>& operator[](WeatherQuantity quantity) { return values[static_cast<std::size_t>(quantity)]; }
  const std::vector<double>& operator[](WeatherQuantity quantity) const {
    return values[static_cast<std::size_t>(quantity)];
  }
};

/// Refuses what no weather is: no records, columns of another length, times that do not rise, solar irradiance above
/// 1500 W/m2 (a beam above that of space, 1420 W/m2, diffuse light above 1000 W/m2) or below -20 W/m2 (a little below 0
/// is a night reading of a pyranometer), air outside of -95 ... 65 degC (values in degrees Fahrenheit, or kelvins taken
/// for degrees Celsius, are said to look so), wind above 120 m/s or below 0, pressures that no place has, long-wave
/// irradiance outside of 30 ... 700 W/m2, cloud cover outside of 0 ... 1, and vapour of more than one and a half times
/// saturation over water at the air temperature of the same record. Throws UsageError with "source:line: ..." lines,
/// one for each kind of fault in each column.
void check_weather(const Weather& weather);

/// What the numbers can be, but seldom are: vapour above saturation, a sky that is much warmer or colder than the air,
/// air that is hot on average. A sentence for each, with the first time and the extreme.
std::vector<std::string> doubts_of(const Weather& weather);

/// Means over longer intervals, [k step, (k + 1) step) of UTC, stamped at their end: measured minutes as 5-min means.
/// Each value counts where its middle is, or its stamp; missing ones are left out of a mean, and one without any is
/// missing.
/// Throws UsageError for a step that is not positive, and as check_weather does.
Weather averaged(const Weather& weather, double step_s);

}  // namespace radiometry::heat
