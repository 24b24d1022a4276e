// SPDX-License-Identifier: Apache-2.0

// Weather series at a time and over a time.

#include <algorithm>
#include <cmath>
#include <limits>

#include "mtf/error.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/weather_series.h"

namespace radiometry::heat {
namespace {

constexpr double kTolerance_s = 1e-3;  // times that are equal but for rounding

std::string span_text(double begin_s, double end_s) { return instant_text(begin_s) + " to " + instant_text(end_s); }

/// The time within the day of the records for weather that repeats; the same time otherwise.
double folded(const WeatherSeries& series, double utc_s, Limit limit) {
  if (series.repeat != Repeat::day || series.constant()) return utc_s;
  const double first = series.node_s.front();
  double into_day = std::fmod(utc_s - first, kDay_s);
  if (into_day < 0.0) into_day += kDay_s;
  if (limit == Limit::before && into_day < kTolerance_s) into_day += kDay_s;
  if (limit == Limit::after && into_day > kDay_s - kTolerance_s) into_day -= kDay_s;
  return first + into_day;
}

/// A time between two nodes: value = (1 - weight) left + weight right.
struct Spot {
  std::size_t left = 0, right = 0;
  double weight = 0.0;
};

Spot spot_of(const WeatherSeries& series, double utc_s, Limit limit) {
  const auto& t = series.node_s;
  if (series.constant()) return {};
  const double time = folded(series, utc_s, limit);
  if (!(time >= t.front() - kTolerance_s && time <= t.back() + kTolerance_s))
    throw mtf::UsageError(series.source + ": error: there is no weather at " +
                          (std::isfinite(utc_s) ? instant_text(utc_s) : "a time that is not finite") +
                          "; the records cover " + span_text(t.front(), t.back()));
  const auto next = limit == Limit::before ? std::ranges::lower_bound(t, time - kTolerance_s)
                                           : std::ranges::upper_bound(t, time + kTolerance_s);
  const auto right = static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(next - t.begin(), 1, static_cast<std::ptrdiff_t>(t.size()) - 1));
  return {right - 1, right, std::clamp((time - t[right - 1]) / (t[right] - t[right - 1]), 0.0, 1.0)};
}

double value_of(const std::vector<double>& nodes, const Spot& spot) {
  // Exact at the nodes, so that a gap beside one does not spoil it.
  if (spot.weight == 0.0) return nodes[spot.left];
  if (spot.weight == 1.0) return nodes[spot.right];
  return (1.0 - spot.weight) * nodes[spot.left] + spot.weight * nodes[spot.right];  // std::lerp may drop a NaN
}

double checked_value(const WeatherSeries& series, std::size_t q, const Spot& spot, double utc_s) {
  const double value = value_of(series.value[q], spot);
  if (std::isnan(value))
    throw mtf::UsageError(series.source + ": error: " + std::string(kQuantityNames[q]) + " is missing at " +
                          instant_text(utc_s) + ", and the gap is too long for a straight line");
  return value;
}

/// The end of [begin, end] that is not covered, in words; "" where all of it is.
std::string uncovered(const WeatherSeries& series, double begin_s, double end_s) {
  if (series.constant() || series.repeat == Repeat::day) return {};
  const double first = series.node_s.front(), last = series.node_s.back();
  if (begin_s >= first - kTolerance_s && end_s <= last + kTolerance_s) return {};
  return "the run from " + span_text(begin_s, end_s) + " is not covered by the records, which go from " +
         span_text(first, last);
}

bool is_solar(WeatherQuantity quantity) {
  return quantity == WeatherQuantity::direct_normal || quantity == WeatherQuantity::diffuse_horizontal ||
         quantity == WeatherQuantity::global_horizontal;
}

bool meets(const WeatherSeries& series, const WeatherGap& gap, double begin_s, double end_s) {
  if (series.repeat == Repeat::none) return gap.begin_s < end_s && gap.end_s > begin_s;
  const double days = std::floor((begin_s - gap.begin_s) / kDay_s);
  for (int more = 0; more <= 1; ++more) {
    const double shift = (days + more) * kDay_s;
    if (gap.begin_s + shift < end_s && gap.end_s + shift > begin_s) return true;
  }
  return false;
}

}  // namespace

std::string held_beyond(const Schedule& schedule, double begin_s, double end_s) {
  const double first = schedule.time_s.empty() ? begin_s : schedule.time_s.front(),
               last = schedule.time_s.empty() ? end_s : schedule.time_s.back();
  if (schedule.constant() || (begin_s >= first - kTolerance_s && end_s <= last + kTolerance_s)) return {};
  return schedule.source + ": beyond its samples the first and the last value are held; they go from " +
         span_text(first, last) + ", and are asked for " +
         (begin_s < end_s ? "from " + span_text(begin_s, end_s) : "at " + instant_text(begin_s));
}

WeatherAt weather_at(const WeatherSeries& series, double utc_s) {
  const Spot spot = spot_of(series, utc_s, Limit::after);
  WeatherAt weather;
  for (std::size_t q = 0; q < kQuantities; ++q)
    weather.value[q] =
        series.value[q].empty() ? std::numeric_limits<double>::quiet_NaN() : checked_value(series, q, spot, utc_s);
  return weather;
}

double value_at(const WeatherSeries& series, WeatherQuantity quantity, double utc_s, Limit limit) {
  if (!series.has(quantity))
    throw mtf::UsageError(series.source + ": error: there is no " + std::string(quantity_name(quantity)));
  return checked_value(series, static_cast<std::size_t>(quantity), spot_of(series, utc_s, limit), utc_s);
}

double mean_over(const WeatherSeries& series, WeatherQuantity quantity, double begin_s, double end_s) {
  if (!(begin_s < end_s)) throw mtf::UsageError("mean_over: the end has to be after the beginning");
  double integral = 0.0, last_s = begin_s, last = value_at(series, quantity, begin_s);
  auto times = break_times(series, begin_s, end_s);
  times.push_back(end_s);
  for (const double t : times) {
    integral += (t - last_s) * (last + value_at(series, quantity, t, Limit::before)) / 2.0;
    last_s = t;
    last = value_at(series, quantity, t, t < end_s ? Limit::after : Limit::before);
  }
  return integral / (end_s - begin_s);
}

void require(const WeatherSeries& series, const std::vector<WeatherQuantity>& quantities, double begin_s,
             double end_s) {
  std::string faults;
  const auto add = [&](const std::string& text) {
    faults += (faults.empty() ? "" : "\n") + series.source + ": error: " + text;
  };
  if (const std::string text = uncovered(series, begin_s, end_s); !text.empty())
    add(text + "; choose another [time], or repeat = \"day\"");
  for (const WeatherQuantity quantity : quantities)
    if (!series.has(quantity))
      add("the weather has no " + std::string(quantity_name(quantity)) +
          (is_solar(quantity) ? "; give two of direct_normal, diffuse_horizontal and global_horizontal" : ""));
  for (const WeatherGap& gap : series.gaps)
    if (std::ranges::find(quantities, gap.quantity) != quantities.end() && meets(series, gap, begin_s, end_s))
      add(std::string(quantity_name(gap.quantity)) + " is missing from " + span_text(gap.begin_s, gap.end_s) +
          ", too long for a straight line; fill the gap or choose another [time]");
  if (!faults.empty()) throw mtf::UsageError(faults);
}

std::vector<double> break_times(const WeatherSeries& series, double begin_s, double end_s, bool jumps_alone) {
  std::vector<double> times;
  if (series.constant() || !(begin_s < end_s)) return times;
  const auto& t = series.node_s;
  const auto jumps = [&](std::size_t node) {
    const bool last = node + 1 == t.size();
    if (last ? series.repeat == Repeat::none : t[node + 1] != t[node]) return false;
    const std::size_t next = last ? 0 : node + 1;
    return std::ranges::any_of(series.value, [&](const auto& v) { return !v.empty() && v[node] != v[next]; });
  };
  const auto add = [&](double shift) {
    for (auto at = std::ranges::upper_bound(t, begin_s - shift); at != t.end() && *at + shift < end_s; ++at)
      if ((times.empty() || *at + shift > times.back() + kTolerance_s) &&
          (!jumps_alone || jumps(static_cast<std::size_t>(at - t.begin()))))
        times.push_back(*at + shift);
  };
  if (series.repeat == Repeat::none) {
    add(0.0);
    return times;
  }
  for (double day = std::floor((begin_s - t.front()) / kDay_s); t.front() + day * kDay_s < end_s; ++day)
    add(day * kDay_s);
  return times;
}

}  // namespace radiometry::heat
