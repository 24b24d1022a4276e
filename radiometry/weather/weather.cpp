// SPDX-License-Identifier: Apache-2.0
#include "radiometry/weather/weather.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/units.h"
#include "mtf/words.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sky.h"

namespace radiometry::heat {
namespace {

using enum WeatherQuantity;

/// What values of a quantity can be, and what is to be said of others.
struct Range {
  WeatherQuantity quantity;
  double lo, hi;
  std::string_view unit, below, above;
};

constexpr std::string_view kSolarHigh =
    "the sun gives at most 1500 W/m2 on the ground; is the column in W/m2, and not in J or kJ over the hour?";
constexpr std::string_view kSolarLow =
    "no pyranometer reads below -20 W/m2; mark missing values as nan or leave their cells empty";
constexpr std::array kRanges{
    Range{air_temperature, mtf::kZeroCelsius_k - 95.0, mtf::kZeroCelsius_k + 65.0, "K",
          "no air is that cold; are these degrees Celsius that were taken for kelvins?", ""},
    Range{wind_speed, 0.0, 120.0, "m/s", "a speed is not negative", "is the column in m/s?"},
    Range{vapour_pressure, 0.0, 12000.0, "Pa", "a pressure is not negative",
          "is the column in the unit of its header?"},
    Range{pressure, 20e3, 115e3, "Pa", "is the column in the unit of its header (1013 hPa at sea level)?",
          "is the column in the unit of its header (1013 hPa at sea level)?"},
    Range{direct_normal, -20.0, 1420.0, "W/m2", kSolarLow,
          "the sun gives at most 1420 W/m2 above the air; is the column in W/m2, and not in J or kJ over the hour?"},
    Range{diffuse_horizontal, -20.0, 1000.0, "W/m2", kSolarLow,
          "no sky scatters more than 1000 W/m2; is this the global irradiance?"},
    Range{global_horizontal, -20.0, 1500.0, "W/m2", kSolarLow, kSolarHigh},
    Range{longwave_down, 30.0, 700.0, "W/m2", "every sky radiates more than 30 W/m2; is this the net flux?",
          "no sky radiates that much; is the column in W/m2?"},
    Range{cloud_cover, 0.0, 1.0, "", "it is a fraction of the sky", "it is a fraction of the sky; are these tenths?"},
    Range{longwave_up, 30.0, 2000.0, "W/m2", "every ground radiates more than 30 W/m2; is this the net flux?",
          "no ground radiates that much; is the column in W/m2?"},
    Range{solar_up, -20.0, 1500.0, "W/m2", kSolarLow, kSolarHigh}};

std::string shown(double value) { return mtf::format_double(std::round(value * 100.0) / 100.0); }

/// "weather.csv:12: "
std::string place_of(const Weather& weather, std::size_t record) {
  return weather.source + ":" + (record < weather.line.size() ? std::to_string(weather.line[record]) + ":" : "") + " ";
}

/// Why air above the range is there: the numbers as they would have been read.
std::string hot_air(double largest_k) {
  const double c = largest_k - mtf::kZeroCelsius_k;
  if (c > 150.0) return "these look like kelvins that were taken for degrees Celsius";
  return "these look like degrees Fahrenheit (" + shown(c) + " degF are " + shown((c - 32.0) / 1.8) + " degC)";
}

void check_column(const Weather& weather, const Range& range, std::vector<std::string>& faults) {
  const auto& values = weather[range.quantity];
  const auto outside = [&](double v) { return v < range.lo || v > range.hi; };
  const auto bad = std::find_if(values.begin(), values.end(), outside);
  if (bad == values.end()) return;
  const auto count = std::count_if(bad, values.end(), outside);
  const bool low = *bad < range.lo;
  const double largest = *std::max_element(bad, values.end(), [](double a, double b) {
    return (std::isnan(a) ? -1e300 : a) < (std::isnan(b) ? -1e300 : b);
  });
  std::string text = place_of(weather, static_cast<std::size_t>(bad - values.begin())) +
                     "error: " + std::string(quantity_name(range.quantity)) + " " +
                     mtf::with_unit(shown(*bad), range.unit) + " is outside of " + shown(range.lo) + " ... " +
                     shown(range.hi);
  if (count > 1) text += " (and " + std::to_string(count - 1) + " more records)";
  faults.push_back(
      text + "; " +
      (range.quantity == air_temperature && !low ? hot_air(largest) : std::string(low ? range.below : range.above)));
}

void check_humidity(const Weather& weather, std::vector<std::string>& faults) {
  constexpr double kMost = 1.5;
  const auto &vapour = weather[vapour_pressure], &air = weather[air_temperature];
  for (std::size_t i = 0; i < std::min(vapour.size(), air.size()); ++i) {
    const double humidity = vapour[i] / saturation_pressure_pa(air[i]);
    if (!(humidity > kMost)) continue;
    faults.push_back(place_of(weather, i) + "error: vapour_pressure " + shown(vapour[i]) + " Pa in air of " +
                     shown(air[i]) + " K is a relative humidity of " + shown(100.0 * humidity) +
                     " %; are both columns in the units of their headers?");
    return;
  }
}

}  // namespace

void check_weather(const Weather& weather) {
  if (weather.time_s.empty()) throw mtf::UsageError(weather.source + ": error: the weather has no records");
  const std::size_t size = weather.time_s.size();
  std::vector<std::string> faults;
  for (std::size_t q = 0; q < kQuantities; ++q)
    if (!weather.values[q].empty() && weather.values[q].size() != size)
      throw mtf::UsageError(weather.source + ": error: " + std::string(kQuantityNames[q]) + " has " +
                            std::to_string(weather.values[q].size()) + " values for " + std::to_string(size) +
                            " times");
  for (std::size_t i = 0; i < size; ++i) {
    if (!std::isfinite(weather.time_s[i])) {
      faults.push_back(place_of(weather, i) + "error: the time is not finite");
      break;
    }
    if (i == 0 || weather.time_s[i] > weather.time_s[i - 1]) continue;
    const bool twice = weather.time_s[i] == weather.time_s[i - 1];
    faults.push_back(place_of(weather, i) + "error: the time " + instant_text(weather.time_s[i]) +
                     (twice ? " stands twice; remove one of the records"
                            : " is before that of the record above it, " + instant_text(weather.time_s[i - 1]) +
                                  "; sort the records"));
    break;
  }
  for (const Range& range : kRanges) check_column(weather, range, faults);
  check_humidity(weather, faults);
  if (!faults.empty()) throw mtf::UsageError(mtf::joined(faults, "\n"));
}

std::vector<std::string> doubts_of(const Weather& weather) {
  constexpr double kHotMean_k = mtf::kZeroCelsius_k + 42.0;
  constexpr double kMostHumid = 1.1, kWarmestSky = 1.5, kColdestSky = 0.35;
  std::vector<std::string> doubts;
  const std::vector<double>&air = weather[air_temperature], &sky = weather[longwave_down];
  double sum = 0.0, count = 0.0;
  for (const double value : air)
    if (!std::isnan(value)) {
      sum += value;
      count += 1.0;
    }
  if (count > 0.0 && sum / count > kHotMean_k)
    doubts.push_back("air_temperature: the mean is " +
                     mtf::format_double(std::round(sum / count - mtf::kZeroCelsius_k)) +
                     " degC; are the values degrees Fahrenheit?");
  const auto beyond = [&](WeatherQuantity quantity, double limit, const auto& ratio_of, const std::string& what) {
    const bool above = limit >= 1.0;
    std::size_t first = 0, times = 0;
    double extreme = limit;
    for (std::size_t i = 0; i < weather[quantity].size() && i < air.size(); ++i) {
      const double ratio = ratio_of(i);
      if (!(above ? ratio > limit : ratio < limit)) continue;
      if (times++ == 0) first = i;
      extreme = above ? std::max(extreme, ratio) : std::min(extreme, ratio);
    }
    if (times > 0)
      doubts.push_back(std::string(quantity_name(quantity)) + ": " + std::to_string(times) +
                       (times == 1 ? " record, at " : " records, the first at ") + instant_text(weather.time_s[first]) +
                       ", up to " + mtf::format_double(std::round(100.0 * extreme)) + what);
  };
  const auto humidity = [&](std::size_t i) { return weather[vapour_pressure][i] / saturation_pressure_pa(air[i]); };
  const auto sky_ratio = [&](std::size_t i) { return sky[i] / blackbody_w_m2(air[i]); };
  beyond(vapour_pressure, kMostHumid, humidity, " % of saturation over water: vapour above it condenses");
  beyond(longwave_down, kWarmestSky, sky_ratio,
         " % of what a black sky at the air temperature gives: no cloud is so much warmer than the air below it");
  beyond(longwave_down, kColdestSky, sky_ratio,
         " % of what a black sky at the air temperature gives: is it the net flux, or has it another unit?");
  return doubts;
}

Weather averaged(const Weather& weather, double step_s) {
  check_weather(weather);
  if (!(step_s > 0.0)) throw mtf::UsageError(weather.source + ": error: the interval of a mean has to be above 0 s");
  const auto& t = weather.time_s;
  // From a stamp to the middle of its interval, of records at equal distances but for gaps.
  std::vector<double> steps;
  for (std::size_t i = 1; i < t.size(); ++i) steps.push_back(t[i] - t[i - 1]);
  const auto usual = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), usual, steps.end());
  const double shift = steps.empty() ? 0.0 : *usual * to_middle(weather.stamp) + weather.later_s;
  Weather means{.source = weather.source, .stamp = Stamp::end};
  const auto end_of = [&](std::size_t q, std::size_t i) {
    return (std::floor((t[i] + (weather.is_mean(q) ? shift : 0.0)) / step_s) + 1.0) * step_s;
  };
  for (std::size_t q = 0; q < kQuantities; ++q)
    for (std::size_t i = 0; i < weather.values[q].size(); ++i) means.time_s.push_back(end_of(q, i));
  std::ranges::sort(means.time_s);
  const auto doubles = std::ranges::unique(means.time_s);
  means.time_s.erase(doubles.begin(), doubles.end());
  for (std::size_t q = 0; q < kQuantities; ++q) {
    if (weather.values[q].empty()) continue;
    std::vector<double> sum(means.time_s.size(), 0.0), count(means.time_s.size(), 0.0);
    for (std::size_t i = 0; i < t.size(); ++i) {
      if (std::isnan(weather.values[q][i])) continue;
      const auto k =
          static_cast<std::size_t>(std::ranges::lower_bound(means.time_s, end_of(q, i)) - means.time_s.begin());
      sum[k] += weather.values[q][i];
      count[k] += 1.0;
    }
    for (std::size_t k = 0; k < sum.size(); ++k) means.values[q].push_back(sum[k] / count[k]);  // NaN without values
  }
  return means;
}

}  // namespace radiometry::heat
