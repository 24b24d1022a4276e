// SPDX-License-Identifier: Apache-2.0
#pragma once

// Weather as functions of time: every quantity a continuous line through common nodes.
//   stamp = instant      nodes at the records.
//   stamp = begin, end   nodes at the edges and in the middle of each interval. The edge between means a and b takes
//                        e = min(line through the middles, 2a, 2b), the middle m = 2a - (e_left + e_right)/2. So the
//                        mean over every interval is the record's, exactly (a = (e_left + 2m + e_right)/4), nothing
//                        leaves [0, 2 max], and 0 at night stays 0. (The idea: Rymes and Myers, Sol. Energy 71, 225
//                        (2001).)
// A single record is constant weather, as it is given. Of others a missing one of direct normal B, diffuse D and global
// G is closed by G = B cos z + D with the true sun: of the instant, or of the mean of max(cos z, 0) over the interval;
// B is then at most the extraterrestrial irradiance and 0 while the mean cosine is below 0.01. Values that are missing
// for at most `longest_bridge_s` are bridged by a straight line between their neighbours, longer gaps are kept by name:
// an evaluation in one throws.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "radiometry/heat/weather/sun.h"
#include "radiometry/heat/weather/weather.h"

namespace radiometry::heat {

enum class Repeat { none, day };
inline constexpr std::array<std::string_view, 2> kRepeatNames{"none", "day"};

struct SeriesOptions {
  Repeat repeat = Repeat::none;  ///< day: 24 h of records, used for every day; one more at the beginning is left out
  double longest_bridge_s = 3600.0;
};

/// Values of one quantity that are missing between two times and are not bridged.
struct WeatherGap {
  WeatherQuantity quantity = WeatherQuantity::air_temperature;
  double begin_s = 0.0, end_s = 0.0;
};

/// Weather ready for use; made by make_series.
struct WeatherSeries {
  std::string source;
  Repeat repeat = Repeat::none;
  std::vector<double> node_s;                          ///< strictly rising; one alone: constant weather
  std::array<std::vector<double>, kQuantities> value;  ///< at the nodes; empty: absent; NaN inside of gaps
  std::vector<WeatherGap> gaps;                        ///< by quantity and time
  std::vector<std::string> warnings;                   ///< bridged values, closures: sentences for the user

  bool has(WeatherQuantity quantity) const { return !value[static_cast<std::size_t>(quantity)].empty(); }
  bool constant() const { return node_s.size() == 1; }
};

/// Checks (check_weather) and prepares. `place` closes the solar columns. Throws UsageError with the source.
WeatherSeries make_series(const Weather& weather, const Place& place, const SeriesOptions& options = {});

/// All quantities at an instant, SI as in weather.h; NaN for an absent one.
struct WeatherAt {
  std::array<double, kQuantities> value{};
  double operator[](WeatherQuantity quantity) const { return value[static_cast<std::size_t>(quantity)]; }
};

/// Throws UsageError with the source, the quantity and the times for an instant before the first or after the last
/// record (unless the weather is constant or repeats) and for one inside of a gap.
WeatherAt weather_at(const WeatherSeries& series, double utc_s);
/// The same for one quantity, which has to be there.
double value_at(const WeatherSeries& series, WeatherQuantity quantity, double utc_s);
/// Exact mean over [begin_s, end_s], begin_s < end_s.
double mean_over(const WeatherSeries& series, WeatherQuantity quantity, double begin_s, double end_s);

/// Throws UsageError that names everything that is missing between the two times of the quantities asked for: absent
/// columns, gaps, time that the records do not cover. What a run calls before it starts.
void require(const WeatherSeries& series, const std::vector<WeatherQuantity>& quantities, double begin_s, double end_s);

/// The nodes strictly between the two times, in order: the times at which the slope of a line changes.
std::vector<double> break_times(const WeatherSeries& series, double begin_s, double end_s);

}  // namespace radiometry::heat
