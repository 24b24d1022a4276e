// SPDX-License-Identifier: Apache-2.0
#pragma once

// Weather as functions of time: lines through common nodes.
//   instants    nodes at the stamps
//   means       nodes at the edges and in the middle of each interval. The edge between means a and b takes
//               e = min(line through the middles, 2a, 2b), the middle m = 2a - (e_left + e_right)/2. So the mean over
//               every interval is the record's, exactly (a = (e_left + 2m + e_right)/4), nothing leaves [0, 2 max], and
//               0 at night stays 0. (The idea: Rymes and Myers, Sol. Energy 71, 225 (2001).)
//   sunlight    means of an interval follow the course of the sun in it, times one number that keeps the mean, with
//               nodes 10 minutes apart and at sunrise and sunset. So light ends with the day, nothing is above what the
//               sun's height explains of a record, and from record to record the line jumps where the sky changed: a
//               line without jumps would have to overshoot, by up to the double
// A single record is constant weather, as it is given. Of others a missing one of direct normal B, diffuse D and global
// G is closed by G = B cos z + D with the true sun: of the instant, or of the interval, as its beam sees it; B is then
// at most the extraterrestrial irradiance and 0 while the mean cosine is below 0.01. Values that are missing for at
// most `longest_bridge_s` are bridged by a straight line between their neighbours, longer gaps are kept by name: an
// evaluation in one throws. Where instants stand beside means, the first and the last of them hold for the rest of the
// interval.

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "radiometry/weather/sun.h"
#include "radiometry/weather/weather.h"

namespace radiometry::heat {

enum class Repeat { none, day };
inline constexpr std::array<std::string_view, 2> kRepeatNames{"none", "day"};

struct SeriesOptions {
  Repeat repeat = Repeat::none;  ///< day: 24 h of records, used for every day; one more at the beginning is left out
  double longest_bridge_s = 3600.0;
  /// The time that is wanted: within it sunlight gets all its nodes, and is compared with the sun.
  double begin_s = -std::numeric_limits<double>::infinity(), end_s = std::numeric_limits<double>::infinity();
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
  /// Rising; a time stands twice where values jump, before and after it. One alone: constant weather.
  std::vector<double> node_s;
  std::array<std::vector<double>, kQuantities> value;  ///< at the nodes; empty: absent; NaN inside of gaps
  /// Instants beside means: their first and last time, before and after which they hold.
  double first_stamp_s = -std::numeric_limits<double>::infinity(),
         last_stamp_s = std::numeric_limits<double>::infinity();
  std::vector<WeatherGap> gaps;       ///< by quantity and time
  std::vector<std::string> warnings;  ///< bridged values, closures: sentences for the user

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

/// Where values jump, those after the time are meant unless it says otherwise.
enum class Limit { before, after };
/// Throws UsageError with the source, the quantity and the times for an instant before the first or after the last
/// record (unless the weather is constant or repeats) and for one inside of a gap.
WeatherAt weather_at(const WeatherSeries& series, double utc_s);
/// The same for one quantity, which has to be there.
double value_at(const WeatherSeries& series, WeatherQuantity quantity, double utc_s, Limit limit = Limit::after);
/// Exact mean over [begin_s, end_s], begin_s < end_s.
double mean_over(const WeatherSeries& series, WeatherQuantity quantity, double begin_s, double end_s);

/// Throws UsageError that names everything that is missing between the two times of the quantities asked for: absent
/// columns, gaps, time that the records do not cover. What a run calls before it starts.
void require(const WeatherSeries& series, const std::vector<WeatherQuantity>& quantities, double begin_s, double end_s);

/// The nodes strictly between the two times, in order: the times at which the slope of a line changes, or only those at
/// which a value jumps.
std::vector<double> break_times(const WeatherSeries& series, double begin_s, double end_s, bool jumps_alone = false);

// One quantity as a function of time, for schedules (temperature of an engine bay, a heat flux): straight lines between
// the samples, held at the first value before them and at the last after them. One sample is a constant.

struct Schedule {
  std::string source;          ///< file it came from, for messages
  std::vector<double> time_s;  ///< UTC (instant.h), strictly rising
  std::vector<double> value;   ///< finite, as many

  bool constant() const { return value.size() == 1; }
};

/// Throws UsageError, with the source, for no samples, sizes that differ, times that do not rise, and values that are
/// not finite.
Schedule make_schedule(std::string source, std::vector<double> time_s, std::vector<double> value);
Schedule constant_schedule(double value);

double value_at(const Schedule& schedule, double utc_s);

/// Whether its first or its last value is held somewhere from `begin_s` to `end_s`, in words; "" where it is not, and
/// of a constant.
std::string held_beyond(const Schedule& schedule, double begin_s, double end_s);

/// The sample times strictly between the two times.
std::vector<double> break_times(const Schedule& schedule, double begin_s, double end_s);

}  // namespace radiometry::heat
