// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/weather/weather_series.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mtf/error.h"
#include "mtf/units.h"
#include "radiometry/heat/weather/instant.h"

namespace radiometry::heat {
namespace {

using enum WeatherQuantity;

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr std::array kSolar{direct_normal, diffuse_horizontal, global_horizontal};

/// Records with the time that each stands for; `begin_s` = `end_s` for instants. Time that no record covers is a record
/// without values, so that neighbours touch.
struct Records {
  bool means = false;
  double step_s = 0.0;  ///< usual distance of records
  std::vector<double> begin_s, end_s;
  std::array<std::vector<double>, kQuantities> values;

  std::size_t size() const { return begin_s.size(); }
  double middle(std::size_t i) const { return begin_s[i] + (end_s[i] - begin_s[i]) / 2.0; }
  void add(double begin, double end) {
    begin_s.push_back(begin);
    end_s.push_back(end);
  }
};

double median_step(const std::vector<double>& time_s) {
  std::vector<double> steps(time_s.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = time_s[i + 1] - time_s[i];
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

/// Records of weather with at least two of them. Records are more than 1.5 usual steps apart where time is missing.
Records records_of(const Weather& weather) {
  constexpr double kMostSteps = 1.5;
  const auto& t = weather.time_s;
  Records records{
      .means = weather.stamp != Stamp::instant, .step_s = median_step(t), .begin_s = {}, .end_s = {}, .values = {}};
  const double step = records.step_s;
  const auto add_values = [&](std::size_t i, bool there) {
    for (std::size_t q = 0; q < kQuantities; ++q)
      if (!weather.values[q].empty()) records.values[q].push_back(there ? weather.values[q][i] : kMissing);
  };
  for (std::size_t i = 0; i < t.size(); ++i) {
    const bool touches_last = i > 0 && t[i] - t[i - 1] <= kMostSteps * step;
    const bool touches_next = i + 1 < t.size() && t[i + 1] - t[i] <= kMostSteps * step;
    double begin = t[i], end = t[i];
    if (weather.stamp == Stamp::end) begin = touches_last ? t[i - 1] : t[i] - step;
    if (weather.stamp == Stamp::begin) end = touches_next ? t[i + 1] : t[i] + step;
    if (i > 0 && !touches_last) {
      const double last = records.end_s.back();
      if (records.means)
        records.add(last, begin);
      else
        records.add(last + (begin - last) / 2.0, last + (begin - last) / 2.0);
      add_values(i, false);
    }
    records.add(begin, end);
    add_values(i, true);
  }
  return records;
}

/// Makes the records those of one day, to be used again and again: instants get the first one as that of the next day.
/// A record too many at the beginning, as of 0 h and 24 h or of a mean that begins on the day before, is left out.
void close_day(Records& records, const std::string& source) {
  constexpr double tolerance_s = 1e-3;
  const double covered = records.end_s.back() - records.begin_s.front() + (records.means ? 0.0 : records.step_s);
  if (covered > kDay_s + records.step_s + tolerance_s)
    throw mtf::UsageError(source + ": error: the records cover " +
                          mtf::format_double(std::round(covered / 36.0) / 100.0) +
                          " h, but repeat = \"day\" repeats those of one day; leave out the others");
  if (covered > kDay_s + tolerance_s) {
    records.begin_s.erase(records.begin_s.begin());
    records.end_s.erase(records.end_s.begin());
    for (auto& values : records.values)
      if (!values.empty()) values.erase(values.begin());
  }
  const double missing_s =
      records.begin_s.front() + kDay_s - records.end_s.back() - (records.means ? 0.0 : records.step_s);
  const double next = records.begin_s.front() + kDay_s;
  if (missing_s > (records.means ? tolerance_s : 0.5 * records.step_s)) {
    const double begin = records.end_s.back(), middle = begin + (next - begin) / 2.0;
    records.add(records.means ? begin : middle, records.means ? next : middle);
    for (auto& values : records.values)
      if (!values.empty()) values.push_back(kMissing);
  }
  if (records.means) return;
  records.add(next, next);
  for (auto& values : records.values)
    if (!values.empty()) values.push_back(values.front());
}

/// Time without a value from the end of the record before `first` to the begin of the record `after`.
double missing_time(const Records& records, std::size_t first, std::size_t after) {
  const double open = records.begin_s[after] - records.end_s[first - 1];
  return records.means ? open : open - records.step_s;
}

/// Straight lines over short stretches of missing values; longer ones and those at the ends stay.
void bridge(Records& records, const SeriesOptions& options, std::vector<std::string>& warnings) {
  for (std::size_t q = 0; q < kQuantities; ++q) {
    auto& v = records.values[q];
    std::size_t bridged = 0, first_bridged = 0;
    for (std::size_t i = 1; i < v.size(); ++i) {
      if (!std::isnan(v[i]) || std::isnan(v[i - 1])) continue;
      std::size_t after = i;
      while (after < v.size() && std::isnan(v[after])) ++after;
      if (after == v.size() || missing_time(records, i, after) > options.longest_bridge_s) continue;
      if (bridged == 0) first_bridged = i;
      bridged += after - i;
      const double t0 = records.middle(i - 1), t1 = records.middle(after);
      for (std::size_t k = i; k < after; ++k)
        v[k] = std::lerp(v[i - 1], v[after], (records.middle(k) - t0) / (t1 - t0));
    }
    if (bridged > 0)
      warnings.push_back(std::string(kQuantityNames[q]) + ": " + std::to_string(bridged) +
                         (bridged == 1 ? " missing record is" : " missing records are") +
                         " bridged by straight lines, the first at " + instant_text(records.end_s[first_bridged]));
  }
}

/// Mean of max(cos z, 0) and of the extraterrestrial irradiance over the time of a record.
struct MeanSun {
  double cosine = 0.0, extraterrestrial_w_m2 = 0.0;
};

MeanSun mean_sun(const Records& records, std::size_t i, const Place& place) {
  constexpr double kLongestPart_s = 300.0;
  const double begin = records.begin_s[i], length = records.end_s[i] - begin;
  const int parts = std::clamp(static_cast<int>(std::ceil(length / kLongestPart_s)), 1, 1000);
  MeanSun mean;
  for (int k = 0; k < parts; ++k) {
    const SunPosition sun = sun_position(begin + length * (k + 0.5) / parts, place);
    mean.cosine += std::max(sun.direction[2], 0.0) / parts;
    mean.extraterrestrial_w_m2 += extraterrestrial_normal_w_m2(sun) / parts;
  }
  return mean;
}

/// The missing one of beam B, diffuse D and global G where two are there: G = B cos z + D.
void close_solar(Records& records, const Place& place, std::vector<std::string>& warnings) {
  constexpr double kLeastCosine = 0.01;
  const auto column = [&](WeatherQuantity quantity) -> auto& {
    return records.values[static_cast<std::size_t>(quantity)];
  };
  const auto missing = [&](WeatherQuantity quantity) { return column(quantity).empty(); };
  if (std::count_if(kSolar.begin(), kSolar.end(), missing) != 1) return;
  const WeatherQuantity absent = *std::find_if(kSolar.begin(), kSolar.end(), missing);
  const auto &b = column(direct_normal), &d = column(diffuse_horizontal), &g = column(global_horizontal);
  std::vector<double> closed(records.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    const MeanSun sun = mean_sun(records, i, place);
    if (absent == global_horizontal)
      closed[i] = b[i] * sun.cosine + d[i];
    else if (absent == diffuse_horizontal)
      closed[i] = std::isnan(g[i] + b[i]) ? kMissing : std::max(g[i] - b[i] * sun.cosine, 0.0);
    else if (std::isnan(g[i] + d[i]))
      closed[i] = kMissing;
    else
      closed[i] =
          sun.cosine < kLeastCosine ? 0.0 : std::clamp((g[i] - d[i]) / sun.cosine, 0.0, sun.extraterrestrial_w_m2);
  }
  column(absent) = std::move(closed);
  warnings.push_back(
      std::string(quantity_name(absent)) +
      " is absent and follows from the other two solar columns: global = direct normal x cos z + diffuse");
}

/// Air that is this warm on average is more often in degrees Fahrenheit than in a desert.
void warn_of_heat(const Weather& weather, std::vector<std::string>& warnings) {
  constexpr double kHotMean_k = mtf::kZeroCelsius_k + 42.0;
  double sum = 0.0, count = 0.0;
  for (const double value : weather[air_temperature])
    if (!std::isnan(value)) {
      sum += value;
      count += 1.0;
    }
  if (count > 0.0 && sum / count > kHotMean_k)
    warnings.push_back("air_temperature: the mean is " +
                       mtf::format_double(std::round(sum / count - mtf::kZeroCelsius_k)) +
                       " degC; are the values degrees Fahrenheit?");
}

/// Lines of instants: the records themselves.
void lines_through_instants(Records&& records, WeatherSeries& series) {
  series.node_s = std::move(records.begin_s);
  series.value = std::move(records.values);
}

/// Value at the edge between two touching means a and b of intervals of the lengths la and lb.
double edge_between(double a, double la, double b, double lb) {
  if (std::isnan(a)) return b;
  if (std::isnan(b)) return a;
  return std::min({(a * lb + b * la) / (la + lb), 2.0 * a, 2.0 * b});
}

/// Lines that keep the means: nodes at the edges and in the middles.
void lines_through_means(const Records& records, WeatherSeries& series) {
  const std::size_t n = records.size();
  series.node_s.reserve(2 * n + 1);
  for (std::size_t i = 0; i < n; ++i) {
    series.node_s.push_back(records.begin_s[i]);
    series.node_s.push_back(records.middle(i));
  }
  series.node_s.push_back(records.end_s.back());
  const auto length = [&](std::size_t i) { return records.end_s[i] - records.begin_s[i]; };
  for (std::size_t q = 0; q < kQuantities; ++q) {
    const auto& v = records.values[q];
    if (v.empty()) continue;
    std::vector<double> edge(n + 1);
    const bool wraps = series.repeat == Repeat::day;
    for (std::size_t i = 1; i < n; ++i) edge[i] = edge_between(v[i - 1], length(i - 1), v[i], length(i));
    edge[0] = wraps ? edge_between(v[n - 1], length(n - 1), v[0], length(0)) : v[0];
    edge[n] = wraps ? edge[0] : v[n - 1];
    auto& nodes = series.value[q];
    nodes.reserve(2 * n + 1);
    for (std::size_t i = 0; i < n; ++i) {
      const double middle = 2.0 * v[i] - (edge[i] + edge[i + 1]) / 2.0;
      nodes.push_back(edge[i]);
      // A fraction of the sky stays one, and its mean is kept only where it can be.
      nodes.push_back(q == static_cast<std::size_t>(cloud_cover) ? std::clamp(middle, 0.0, 1.0) : middle);
    }
    nodes.push_back(edge[n]);
  }
}

/// Columns without any value are absent ones; the others' missing stretches get names.
void find_gaps(WeatherSeries& series) {
  const auto& t = series.node_s;
  for (std::size_t q = 0; q < kQuantities; ++q) {
    const auto& v = series.value[q];
    for (std::size_t i = 0; i < v.size(); ++i) {
      if (!std::isnan(v[i])) continue;
      std::size_t after = i;
      while (after < v.size() && std::isnan(v[after])) ++after;
      series.gaps.push_back({static_cast<WeatherQuantity>(q), t[i == 0 ? 0 : i - 1], t[std::min(after, v.size() - 1)]});
      i = after;
    }
  }
}

}  // namespace

WeatherSeries make_series(const Weather& weather, const Place& place, const SeriesOptions& options) {
  check_weather(weather);
  WeatherSeries series;
  series.source = weather.source;
  series.repeat = options.repeat;
  Weather clean = weather;
  for (std::size_t q = 0; q < kQuantities; ++q) {
    auto& values = clean.values[q];
    if (std::all_of(values.begin(), values.end(), [](double v) { return std::isnan(v); })) {
      if (!values.empty())
        series.warnings.push_back(std::string(kQuantityNames[q]) + ": every value is missing; the column is left out");
      values.clear();
    }
  }
  for (const WeatherQuantity quantity : {direct_normal, diffuse_horizontal, global_horizontal, solar_up})
    for (double& value : clean[quantity])
      if (value < 0.0) value = 0.0;  // the night offset of a pyranometer; NaN stays

  warn_of_heat(clean, series.warnings);
  if (clean.time_s.size() == 1) {
    series.node_s = clean.time_s;
    series.value = clean.values;
    return series;
  }
  Records records = records_of(clean);
  if (options.repeat == Repeat::day) close_day(records, series.source);
  bridge(records, options, series.warnings);
  close_solar(records, place, series.warnings);
  if (records.means)
    lines_through_means(records, series);
  else
    lines_through_instants(std::move(records), series);
  find_gaps(series);
  return series;
}

}  // namespace radiometry::heat
