// SPDX-License-Identifier: Apache-2.0
#include "radiometry/weather/weather_series.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/records.h"
#include "radiometry/weather/sun_agreement.h"
#include "radiometry/weather/sun_course.h"

namespace radiometry::heat {
namespace {

using enum WeatherQuantity;

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr std::array kLight{direct_normal, diffuse_horizontal, global_horizontal, solar_up};

bool is_light(std::size_t q) { return std::ranges::find(kLight, static_cast<WeatherQuantity>(q)) != kLight.end(); }

/// Value at the edge between two touching means a and b of intervals of the lengths la and lb.
double edge_between(double a, double la, double b, double lb) {
  if (std::isnan(a)) return b;
  if (std::isnan(b)) return a;
  return std::min({(a * lb + b * la) / (la + lb), 2.0 * a, 2.0 * b});
}

/// The nodes of an interval, its begin and end among them.
struct IntervalNodes {
  std::vector<double> time_s;
  std::vector<SunPosition> sun;  ///< at each, where there is light to be spread; else empty
};

bool has_light(const Records& means, std::size_t i) {
  return std::ranges::any_of(kLight, [&](WeatherQuantity q) { return !means[q].empty() && means[q][i] > 0.0; });
}

IntervalNodes nodes_of(const Records& means, std::size_t i, const Records* instants, const Place& place,
                       const SeriesOptions& options) {
  constexpr double kLongestPart_s = 600.0;
  const double begin = means.begin_s[i], end = means.end_s[i];
  const bool wanted = options.repeat == Repeat::day || (end >= options.begin_s && begin <= options.end_s);
  IntervalNodes nodes{{begin, means.middle(i), end}, {}};
  const bool lit = wanted && has_light(means, i);
  if (lit) {
    const int parts = std::clamp(static_cast<int>(std::ceil(means.length_s(i) / kLongestPart_s)), 1, 1000);
    for (int k = 1; k < parts; ++k) nodes.time_s.push_back(begin + means.length_s(i) * k / parts);
    for (const SunCrossing& crossing : sun_crossings(place, begin, end)) nodes.time_s.push_back(crossing.utc_s);
  }
  if (instants != nullptr) {
    const auto& t = instants->begin_s;
    for (auto at = std::ranges::upper_bound(t, begin); at != t.end() && *at < end; ++at) nodes.time_s.push_back(*at);
  }
  std::ranges::sort(nodes.time_s);
  const auto doubles = std::ranges::unique(nodes.time_s);
  nodes.time_s.erase(doubles.begin(), doubles.end());
  if (lit)
    for (const double t : nodes.time_s) nodes.sun.push_back(sun_position(t, place));
  return nodes;
}

/// A mean spread over its interval by the sun's course; as it is where the sun has none. False for a beam that is more
/// than the sun has.
bool spread_light(const IntervalNodes& nodes, bool beam, double mean, std::vector<double>& values) {
  const std::size_t n = nodes.time_s.size();
  std::vector<double> course(n, 1.0);
  for (std::size_t k = 0; k < nodes.sun.size(); ++k) {
    const double sine = nodes.sun[k].direction[2];
    course[k] = beam ? beam_course(sine) : sky_course(sine);
  }
  const double length_s = nodes.time_s.back() - nodes.time_s.front();
  double integral = 0.0;
  for (std::size_t k = 0; k + 1 < n; ++k)
    integral += 0.5 * (course[k] + course[k + 1]) * (nodes.time_s[k + 1] - nodes.time_s[k]);
  // Light from the sky is at most twice its mean, whatever a twilight does: a constant is added that keeps it so.
  if (const double more = std::ranges::max(course) - 2.0 * integral / length_s; !beam && more > 0.0) {
    for (double& value : course) value += more;
    integral += more * length_s;
  }
  const double scale = mean * length_s / integral;
  bool possible = integral > 0.0 || !beam;
  for (std::size_t k = 0; k < n; ++k) {
    const double value = integral > 0.0 ? scale * course[k] : mean;
    const double most = beam && !nodes.sun.empty() ? extraterrestrial_normal_w_m2(nodes.sun[k]) : value;
    possible = possible && value <= most;
    values.push_back(std::isnan(value) ? value : std::min(value, most));
  }
  return possible;
}

/// A line through instants, which hold beyond their ends.
double line_at(const Records& instants, const std::vector<double>& values, double time_s, bool daily) {
  const std::vector<double>& t = instants.begin_s;
  if (daily && time_s < t.front()) time_s += kDay_s;
  const auto right = static_cast<std::size_t>(std::ranges::lower_bound(t, time_s) - t.begin());
  if (right == t.size()) return values.back();
  if (right == 0 || t[right] == time_s) return values[right];
  const double share = (time_s - t[right - 1]) / (t[right] - t[right - 1]);
  return (1.0 - share) * values[right - 1] + share * values[right];
}

/// Lines through means, and through instants beside them, over common nodes.
void lines_through_means(const Records& means, const Records* instants, const Place& place,
                         const SeriesOptions& options, WeatherSeries& series) {
  const std::size_t n = means.size();
  const bool daily = series.repeat == Repeat::day;
  std::array<std::vector<double>, kQuantities> edges;
  for (std::size_t q = 0; q < kQuantities; ++q) {
    const auto& v = means.values[q];
    if (v.empty() || is_light(q)) continue;
    std::vector<double>& edge = edges[q];
    edge.resize(n + 1);
    for (std::size_t i = 1; i < n; ++i)
      edge[i] = edge_between(v[i - 1], means.length_s(i - 1), v[i], means.length_s(i));
    edge[0] = daily ? edge_between(v[n - 1], means.length_s(n - 1), v[0], means.length_s(0)) : v[0];
    edge[n] = daily ? edge[0] : v[n - 1];
  }
  LostBeam lost;
  for (std::size_t i = 0; i < n; ++i) {
    const IntervalNodes nodes = nodes_of(means, i, instants, place, options);
    series.node_s.insert(series.node_s.end(), nodes.time_s.begin(), nodes.time_s.end());
    for (std::size_t q = 0; q < kQuantities; ++q) {
      std::vector<double>& values = series.value[q];
      const auto& v = means.values[q];
      if (instants != nullptr && !instants->values[q].empty()) {
        for (const double t : nodes.time_s) values.push_back(line_at(*instants, instants->values[q], t, daily));
      } else if (!v.empty() && is_light(q)) {
        const bool beam = q == static_cast<std::size_t>(direct_normal);
        if (!spread_light(nodes, beam, v[i], values) && !std::isnan(v[i])) lost.add(means.begin_s[i], v[i]);
      } else if (!v.empty()) {
        const double left = edges[q][i], right = edges[q][i + 1];
        double middle = 2.0 * v[i] - (left + right) / 2.0;
        // A fraction of the sky stays one, and its mean is kept only where it can be.
        if (q == static_cast<std::size_t>(cloud_cover)) middle = std::clamp(middle, 0.0, 1.0);
        for (const double t : nodes.time_s) {
          const double place_in = 2.0 * (t - means.begin_s[i]) / means.length_s(i);
          values.push_back(place_in < 1.0   ? left + place_in * (middle - left)
                           : place_in > 1.0 ? middle + (place_in - 1.0) * (right - middle)
                                            : middle);
        }
      }
    }
  }
  if (const std::string text = lost.text(); !text.empty()) series.warnings.push_back(text);
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
  for (const WeatherQuantity quantity : kLight)
    for (double& value : clean[quantity])
      if (value < 0.0) value = 0.0;  // the night offset of a pyranometer; NaN stays

  for (std::string& doubt : doubts_of(clean)) series.warnings.push_back(std::move(doubt));
  if (clean.time_s.size() == 1) {
    series.node_s = clean.time_s;
    series.value = clean.values;
    if (clean.has(global_horizontal) && clean.has(direct_normal) && clean.has(diffuse_horizontal))
      series.warnings.push_back(
          "global_horizontal is not used: direct_normal and diffuse_horizontal, which are constant, say all");
    return series;
  }
  const auto prepared = [&](bool means) -> std::optional<Records> {
    Records records = records_of(clean, means);
    if (std::ranges::all_of(records.values, [](const auto& values) { return values.empty(); })) return std::nullopt;
    if (options.repeat == Repeat::day) close_day(records, series.source);
    bridge(records, options, series.warnings);
    for (std::string& text : disagreements(records, clean.stamp, place, options))
      series.warnings.push_back(std::move(text));
    close_solar(records, place, series.warnings);
    return records;
  };
  std::optional<Records> means = prepared(true), instants = prepared(false);
  if (means) {
    lines_through_means(*means, instants ? &*instants : nullptr, place, options, series);
  } else if (instants) {
    series.node_s = std::move(instants->begin_s);
    series.value = std::move(instants->values);
  } else {
    series.node_s = clean.time_s;
  }
  if (means && instants && options.repeat == Repeat::none) {
    series.first_stamp_s = instants->begin_s.front();
    series.last_stamp_s = instants->begin_s.back();
  }
  find_gaps(series);
  return series;
}

}  // namespace radiometry::heat
