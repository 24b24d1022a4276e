// SPDX-License-Identifier: Apache-2.0
#include "radiometry/weather/weather_series.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "mtf/error.h"
#include "mtf/units.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sun.h"

namespace radiometry::heat {
namespace {

using enum WeatherQuantity;

// How light changes with the height of the sun within a record, h, but for a factor: what an hour's mean is spread by.
//   beam, normal          sin h / (sin h + 0.15) above the horizon: a clear sky's within a tenth above 5 degrees
//   on a horizontal plane sin h + 0.1, down to the end of civil twilight: from the sky, and all of it

constexpr double beam_course(double sine) {
  constexpr double kHalf = 0.15;
  return sine > 0.0 ? sine / (sine + kHalf) : 0.0;
}

constexpr double sky_course(double sine) {
  constexpr double kTwilight = 0.1;  // of 6 degrees
  return std::max(0.0, sine + kTwilight);
}

/// Records of a station with the time that each of them stands for: the step between a file and functions of time.
/// `begin_s` = `end_s` for instants. Time that no record covers is a record without values, so that neighbours touch.
struct Records {
  bool means = false;
  double step_s = 0.0;  ///< usual distance of records
  std::vector<double> begin_s{}, end_s{};
  std::array<std::vector<double>, kQuantities> values{};

  std::size_t size() const { return begin_s.size(); }
  double length_s(std::size_t i) const { return end_s[i] - begin_s[i]; }
  double middle(std::size_t i) const { return begin_s[i] + length_s(i) / 2.0; }
  const std::vector<double>& operator[](WeatherQuantity quantity) const {
    return values[static_cast<std::size_t>(quantity)];
  }
  void add(double begin, double end) {
    begin_s.push_back(begin);
    end_s.push_back(end);
  }
};

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr std::array kSolar{direct_normal, diffuse_horizontal, global_horizontal};

double median_step(const std::vector<double>& time_s) {
  std::vector<double> steps(time_s.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = time_s[i + 1] - time_s[i];
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

/// The time that each record stands for: of a mean its interval, which ends at the next one or begins at the last where
/// they touch.
struct Span {
  double begin_s, end_s;
};

Span span_of(const std::vector<double>& t, std::size_t i, double step, double most, Stamp stamp, double later_s) {
  const double before = i > 0 && t[i] - t[i - 1] <= most ? t[i] - t[i - 1] : step;
  const double after = i + 1 < t.size() && t[i + 1] - t[i] <= most ? t[i + 1] - t[i] : step;
  const double at = t[i] + later_s;
  if (stamp == Stamp::begin) return {at, at + after};
  if (stamp == Stamp::middle) return {at - 0.5 * before, at + 0.5 * after};
  if (stamp == Stamp::end) return {at - before, at};
  return {t[i], t[i]};
}

/// Time without a value from the end of the record before `first` to the begin of the record `after`.
double missing_time(const Records& records, std::size_t first, std::size_t after) {
  const double open = records.begin_s[after] - records.end_s[first - 1];
  return records.means ? open : open - records.step_s;
}

/// The cosine of the zenith angle as a beam of that mean sees it, so that the mean on a horizontal plane is the mean
/// beam times it, and the mean extraterrestrial irradiance, over the time of a record.
struct MeanSun {
  double cosine = 0.0, extraterrestrial_w_m2 = 0.0;
};

MeanSun mean_sun(const Records& records, std::size_t i, const Place& place) {
  constexpr double kLongestPart_s = 300.0;
  const double begin = records.begin_s[i], length = records.length_s(i);
  const int parts = std::clamp(static_cast<int>(std::ceil(length / kLongestPart_s)), 1, 1000);
  MeanSun mean;
  double course = 0.0;
  for (int k = 0; k < parts; ++k) {
    const SunPosition sun = sun_position(begin + length * (k + 0.5) / parts, place);
    const double sine = sun.direction[2], beam = beam_course(sine);
    course += beam;
    mean.cosine += beam * sine;
    mean.extraterrestrial_w_m2 += extraterrestrial_normal_w_m2(sun) / parts;
  }
  mean.cosine = course > 0.0 ? mean.cosine / course : 0.0;
  return mean;
}

/// Of weather with at least two records; the columns that hold at the stamps, or those that are means. Records are more
/// than 1.5 usual steps apart where time is missing.
Records records_of(const Weather& weather, bool means) {
  constexpr double kMostSteps = 1.5;
  const auto& t = weather.time_s;
  Records records{.means = means, .step_s = median_step(t)};
  const double most = kMostSteps * records.step_s;
  const auto add_values = [&](std::size_t i, bool there) {
    for (std::size_t q = 0; q < kQuantities; ++q)
      if (!weather.values[q].empty() && weather.is_mean(q) == means)
        records.values[q].push_back(there ? weather.values[q][i] : kMissing);
  };
  for (std::size_t i = 0; i < t.size(); ++i) {
    const Span span = span_of(t, i, records.step_s, most, means ? weather.stamp : Stamp::instant, weather.later_s);
    if (i > 0 && t[i] - t[i - 1] > most) {
      const double last = records.end_s.back(), middle = last + (span.begin_s - last) / 2.0;
      records.add(means ? last : middle, means ? span.begin_s : middle);
      add_values(i, false);
    }
    records.add(span.begin_s, span.end_s);
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

std::string one_digit(double value) { return mtf::format_double(std::round(10.0 * value) / 10.0); }

/// Beams that the sun cannot give in the time they stand for; in place of one what is left of it on a level plane.
struct LostBeam {
  std::size_t records = 0;
  double first_s = 0.0, most_w_m2 = 0.0;

  void add(double begin_s, double mean_w_m2) {
    constexpr double kTrace_w_m2 = 5.0;
    if (mean_w_m2 < kTrace_w_m2) return;
    if (records++ == 0) first_s = begin_s;
    most_w_m2 = std::max(most_w_m2, mean_w_m2);
  }
  /// A sentence; "" where there are none but traces.
  std::string text() const {
    if (records == 0) return {};
    return "direct_normal: " + std::to_string(records) + (records == 1 ? " record has" : " records have") +
           " more light than the sun can give in that time, the first from " + instant_text(first_s) + " on, up to " +
           one_digit(most_w_m2) + " W/m2, and what is too much is left out; are the times and the place right?";
  }
};

/// The missing one of beam B, diffuse D and global G where two are there: G = B cos z + D.
void close_solar(Records& records, const Place& place, std::vector<std::string>& warnings) {
  constexpr double kLeastCosine = 0.01, kRest_w_m2 = 20.0;
  const auto column = [&](WeatherQuantity quantity) -> auto& {
    return records.values[static_cast<std::size_t>(quantity)];
  };
  const auto missing = [&](WeatherQuantity quantity) { return column(quantity).empty(); };
  if (std::count_if(kSolar.begin(), kSolar.end(), missing) != 1) return;
  const WeatherQuantity absent = *std::find_if(kSolar.begin(), kSolar.end(), missing);
  const auto &b = column(direct_normal), &d = column(diffuse_horizontal), &g = column(global_horizontal);
  std::vector<double> closed(records.size());
  LostBeam lost;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const MeanSun sun = mean_sun(records, i, place);
    if (absent == global_horizontal)
      closed[i] = b[i] * sun.cosine + d[i];
    else if (absent == diffuse_horizontal)
      closed[i] = std::isnan(g[i] + b[i]) ? kMissing : std::max(g[i] - b[i] * sun.cosine, 0.0);
    else if (std::isnan(g[i] + d[i]))
      closed[i] = kMissing;
    else {
      closed[i] =
          sun.cosine < kLeastCosine ? 0.0 : std::clamp((g[i] - d[i]) / sun.cosine, 0.0, sun.extraterrestrial_w_m2);
      // A station's clock and its horizon leave as much at sunrise.
      if (const double left = g[i] - d[i] - closed[i] * sun.cosine; left > kRest_w_m2)
        lost.add(records.begin_s[i], left);
    }
  }
  column(absent) = std::move(closed);
  warnings.push_back(
      std::string(quantity_name(absent)) +
      " is absent and follows from the other two solar columns: global = direct normal x cos z + diffuse");
  if (const std::string text = lost.text(); !text.empty()) warnings.push_back(text);
}

/// Beams at instants at which the sun is down, where nothing gets them. Those of means are seen as they are spread.
void find_beams_at_night(const Records& r, const Place& place, const SeriesOptions& options,
                         std::vector<std::string>& warnings) {
  constexpr double kSet = -0.13;  // as a sine: means that are taken for instants have light half an hour longer
  LostBeam lost;
  for (std::size_t i = 0; !r.means && i < r[direct_normal].size(); ++i)
    if (const double t = r.begin_s[i]; r[direct_normal][i] > 0.0 && t >= options.begin_s && t <= options.end_s &&
                                       sun_position(t, place).direction[2] < kSet)
      lost.add(t, r[direct_normal][i]);
  if (const std::string text = lost.text(); !text.empty()) warnings.push_back(text);
}

// Whether sunlight that a station writes fits the sun: global G = B cos z + D of beam B and diffuse D with the cosine
// of the time that a record is taken to stand for. A stamp that is taken for another one shows by half an hour or a
// whole one: 40 W/m2 rms and more on clear days, where G - D - B cos z is a few W/m2 otherwise.

constexpr std::array kShifts{0.0, -1.0, -0.5, 0.5, 1.0};  // of an interval; what is assumed first
constexpr std::size_t kMostRecords = 240;
constexpr int kParts = 6;  // of an interval

/// B cos z for the mean of an interval, or at an instant.
double on_horizontal(double beam, double begin_s, double end_s, const Place& place) {
  double course = 0.0, seen = 0.0;
  for (int k = 0; k < kParts; ++k) {
    const double sine = sun_position(begin_s + (end_s - begin_s) * (k + 0.5) / kParts, place).direction[2];
    course += beam_course(sine);
    seen += beam_course(sine) * sine;
    if (end_s == begin_s) break;
  }
  return course > 0.0 ? beam * seen / course : 0.0;
}

std::vector<std::size_t> compared(const Records& r, const SeriesOptions& options) {
  constexpr double kLeast_w_m2 = 50.0;
  std::vector<std::size_t> all, some;
  for (std::size_t i = 0; i < r.size(); ++i)
    if (r[global_horizontal][i] > kLeast_w_m2 && r[direct_normal][i] >= 0.0 && r[diffuse_horizontal][i] >= 0.0 &&
        (options.repeat == Repeat::day || (r.end_s[i] >= options.begin_s && r.begin_s[i] <= options.end_s)))
      all.push_back(i);
  const std::size_t step = 1 + all.size() / kMostRecords;
  for (std::size_t k = 0; k < all.size(); k += step) some.push_back(all[k]);
  return some;
}

/// Sentences: the records fit the sun at another time than the one they are taken for, and which stamp says so; or they
/// fit it at none. Records that are compared are spread over the time that `options` want.
std::vector<std::string> disagreements(const Records& r, Stamp stamp, const Place& place,
                                       const SeriesOptions& options) {
  constexpr double kShortest_s = 600.0;  // of steps, within which half of one shows
  constexpr double kNoticed_w_m2 = 10.0, kBetter = 0.5, kWrong_w_m2 = 30.0, kWrongShare = 0.1;
  if (r[direct_normal].empty() || r[diffuse_horizontal].empty() || r[global_horizontal].empty()) return {};
  const std::vector<std::size_t> records = compared(r, options);
  if (records.empty()) return {};
  const std::size_t shifts = r.step_s >= kShortest_s ? kShifts.size() : 1;
  std::array<double, kShifts.size()> rms{};
  double mean = 0.0;
  for (const std::size_t i : records) {
    mean += r[global_horizontal][i] / static_cast<double>(records.size());
    for (std::size_t s = 0; s < shifts; ++s) {
      const double by = kShifts[s] * r.step_s;
      const double rest = r[global_horizontal][i] - r[diffuse_horizontal][i] -
                          on_horizontal(r[direct_normal][i], r.begin_s[i] + by, r.end_s[i] + by, place);
      rms[s] += rest * rest / static_cast<double>(records.size());
    }
  }
  for (double& one : rms) one = std::sqrt(one);
  const auto best = static_cast<std::size_t>(std::min_element(rms.begin(), rms.begin() + shifts) - rms.begin());
  const std::string rest = "global - diffuse - direct normal x cos z is " + one_digit(rms[0]) + " W/m2 rms";
  if (rms[0] > kNoticed_w_m2 && rms[best] < kBetter * rms[0]) {
    const double wanted = to_middle(r.means ? stamp : Stamp::instant) + kShifts[best];
    const std::string by = mtf::format_double(std::abs(kShifts[best]) * r.step_s / 60.0) + " min " +
                           (kShifts[best] < 0.0 ? "earlier" : "later");
    std::string remedy = "look at the time zone of the file and at the longitude of [place]";
    for (const Stamp other : {Stamp::begin, Stamp::middle, Stamp::end})
      if (wanted == to_middle(other)) remedy = "stamp = \"" + std::string(stamp_name(other)) + "\" says so";
    return {"the sunlight does not fit the sun: " + rest + ", and " + one_digit(rms[best]) +
            " W/m2 where the records are taken to be " + by + "; " + remedy};
  }
  if (rms[0] > std::max(kWrong_w_m2, kWrongShare * mean))
    return {"global_horizontal contradicts direct_normal and diffuse_horizontal, which are used: " + rest +
            " where the global irradiance is " + one_digit(mean) + " W/m2 in the mean"};
  return {};
}

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
    find_beams_at_night(records, place, options, series.warnings);
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

Schedule make_schedule(std::string source, std::vector<double> time_s, std::vector<double> value) {
  const auto refuse = [&](const std::string& why) { throw mtf::UsageError(source + ": " + why); };
  if (value.empty() || value.size() != time_s.size())
    refuse(std::to_string(time_s.size()) + " times for " + std::to_string(value.size()) +
           " values; a schedule needs at least one, each with its time");
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (!std::isfinite(time_s[i]) || !std::isfinite(value[i])) refuse("a time or a value that is not finite");
    if (i > 0 && !(time_s[i] > time_s[i - 1]))
      refuse("the time " + instant_text(time_s[i]) + " is not after the one before it; sort the samples");
  }
  return {std::move(source), std::move(time_s), std::move(value)};
}

Schedule constant_schedule(double value) { return make_schedule("constant", {0.0}, {value}); }

double value_at(const Schedule& schedule, double utc_s) {
  const auto& t = schedule.time_s;
  const auto& v = schedule.value;
  const auto after = static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), utc_s) - t.begin());
  if (after == 0) return v.front();
  if (after == t.size()) return v.back();
  return std::lerp(v[after - 1], v[after], (utc_s - t[after - 1]) / (t[after] - t[after - 1]));
}

std::vector<double> break_times(const Schedule& schedule, double begin_s, double end_s) {
  const auto& t = schedule.time_s;
  const auto first = std::upper_bound(t.begin(), t.end(), begin_s);
  const auto last = std::lower_bound(first, t.end(), end_s);
  return {first, std::max(first, last)};
}

}  // namespace radiometry::heat
