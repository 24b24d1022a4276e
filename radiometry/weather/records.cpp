// SPDX-License-Identifier: Apache-2.0
#include "radiometry/weather/records.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mtf/error.h"
#include "mtf/units.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sun_course.h"

namespace radiometry::heat {
namespace {

using enum WeatherQuantity;

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

Span span_of(const std::vector<double>& t, std::size_t i, double step, double most, Stamp stamp) {
  const double before = i > 0 && t[i] - t[i - 1] <= most ? t[i] - t[i - 1] : step;
  const double after = i + 1 < t.size() && t[i + 1] - t[i] <= most ? t[i + 1] - t[i] : step;
  if (stamp == Stamp::begin) return {t[i], t[i] + after};
  if (stamp == Stamp::middle) return {t[i] - 0.5 * before, t[i] + 0.5 * after};
  if (stamp == Stamp::end) return {t[i] - before, t[i]};
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

}  // namespace

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
    const Span span = span_of(t, i, records.step_s, most, means ? weather.stamp : Stamp::instant);
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

}  // namespace radiometry::heat
