// SPDX-License-Identifier: Apache-2.0
#include "radiometry/weather/sun_agreement.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mtf/units.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sun_course.h"

namespace radiometry::heat {
namespace {

using enum WeatherQuantity;

constexpr std::array kShifts{0.0, -1.0, -0.5, 0.5, 1.0};  // of an interval; what is assumed first
constexpr std::size_t kMostRecords = 240;
constexpr int kParts = 6;  // of an interval

std::string one_digit(double value) { return mtf::format_double(std::round(10.0 * value) / 10.0); }

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

}  // namespace

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

void LostBeam::add(double begin_s, double mean_w_m2) {
  constexpr double kTrace_w_m2 = 5.0;
  if (mean_w_m2 < kTrace_w_m2) return;
  if (records++ == 0) first_s = begin_s;
  most_w_m2 = std::max(most_w_m2, mean_w_m2);
}

std::string LostBeam::text() const {
  if (records == 0) return {};
  return "direct_normal: " + std::to_string(records) + (records == 1 ? " record has" : " records have") +
         " more light than the sun can give in that time, the first from " + instant_text(first_s) + " on, up to " +
         one_digit(most_w_m2) + " W/m2, and what is too much is left out; are the times and the place right?";
}

}  // namespace radiometry::heat
