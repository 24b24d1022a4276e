// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/surroundings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "mtf/error.h"
#include "mtf/words.h"
#include "radiometry/weather/instant.h"

namespace radiometry::thermal {
namespace {

namespace geometry = radiometry::scene;
constexpr double kLongestStep_s = 600.0, kShortestStep_s = 60.0;
constexpr double kOnHorizon = 1e-6;
constexpr double kSame_s = 1e-3;  // times closer than this are one node
constexpr double kJump_s = 1.0;   // a jump of the light is a line that is so long

/// Rising, without doubles.
std::vector<double> merged(std::vector<double> times) {
  std::sort(times.begin(), times.end());
  std::vector<double> kept;
  for (const double t : times)
    if (kept.empty() || t - kept.back() > kSame_s) kept.push_back(t);
  return kept;
}

/// Adds times after jumps. What follows a jump at once is not resolved: records of a minute have their own nodes.
void follow_jumps(std::vector<double>& times, double end) {
  constexpr std::array kAfter_s{10.0, 40.0, 150.0};
  std::vector<double> jumps;
  for (std::size_t k = 1; k < times.size(); ++k)
    if (is_jump(times[k - 1], times[k])) jumps.push_back(times[k]);
  jumps.push_back(end);
  for (std::size_t i = 0; i + 1 < jumps.size(); ++i)
    for (const double after : kAfter_s)
      if (10.0 * after < jumps[i + 1] - jumps[i]) times.push_back(jumps[i] + after);
  times = merged(std::move(times));
}

std::size_t node_at(const std::vector<double>& times, double t) {
  const auto at = std::lower_bound(times.begin(), times.end(), t - kSame_s);
  return std::min(static_cast<std::size_t>(at - times.begin()), times.size() - 1);
}

/// What the balance and the sky need; gaps in other columns do not matter.
std::vector<heat::WeatherQuantity> wanted_of(const ThermalScene& scene) {
  using enum heat::WeatherQuantity;
  std::vector<heat::WeatherQuantity> wanted{air_temperature, wind_speed, direct_normal, diffuse_horizontal};
  if (scene.sky.w_m2)
    wanted.insert(wanted.end(), scene.sky.columns.begin(), scene.sky.columns.end());
  else
    wanted.push_back(longwave_down);
  if (scene.evaporates() && std::ranges::find(wanted, vapour_pressure) == wanted.end())
    wanted.push_back(vapour_pressure);
  return wanted;
}

/// About so many directions a day, at the begin and the end of every stretch of daylight and at nodes between them, the
/// same times every day: so shadows repeat from day to day, and no more steps end than at nodes.
std::vector<heat::SunAt> shadow_directions(const heat::Place& place, double start, double end, int directions) {
  constexpr double step = kLongestStep_s;  // whatever the tolerance: the table does not depend on it
  // Begin and end of each stretch.
  std::vector<double> edges;
  if (sun_position(start, place).direction[2] > 0.0) edges.push_back(start);
  for (const heat::SunCrossing& crossing : sun_crossings(place, start, end)) edges.push_back(crossing.utc_s);
  if (edges.size() % 2 == 1) edges.push_back(end);
  double daylight_s = 0.0;
  for (std::size_t i = 0; i < edges.size(); i += 2) daylight_s += edges[i + 1] - edges[i];
  const double of_day = daylight_s / (end - start);
  const double between = heat::kDay_s / std::max(1.0, std::round(std::max(directions, 2) / std::max(of_day, 1e-3)));
  std::vector<heat::SunAt> table;
  const auto add = [&](double utc) { table.push_back({utc, sun_position(utc, place)}); };
  for (std::size_t i = 0; i < edges.size(); i += 2) {
    add(edges[i]);
    for (double at = 0.0; at < end - start; at += between) {
      const double utc = start + step * std::round(at / step);
      if (utc > table.back().utc_s + 0.5 * step && utc < edges[i + 1] - 0.5 * step) add(utc);
    }
    add(edges[i + 1]);
  }
  return table;
}

/// For the interval after each node the entry of the table of shadows that it begins in.
std::vector<int> entries_of(const Surroundings& s, const ThermalScene& scene) {
  std::vector<int> entry(s.nodes(), -1);
  std::size_t j = 0;
  for (std::size_t k = 0; k + 1 < s.nodes(); ++k) {
    const double middle = 0.5 * (s.time_s[k] + s.time_s[k + 1]);
    while (j + 1 < s.shadow_time_s.size() && s.shadow_time_s[j + 1] <= middle) ++j;
    if (j + 1 >= s.shadow_time_s.size() || s.shadow_time_s[j] > middle) continue;
    if (sun_position(scene.start_s + middle, scene.place).direction[2] > 0.0) entry[k] = static_cast<int>(j);
  }
  return entry;
}

}  // namespace

geometry::Vector Surroundings::sun_between(std::size_t node, double share) const {
  using geometry::operator*, geometry::operator+;
  // Of both ends, the parts across the axis turn by the same angle a second; those along it go as a straight line.
  const geometry::Vector &a = to_sun[node], &b = to_sun[node + 1];
  const double turn = 2.0 * std::numbers::pi * (time_s[node + 1] - time_s[node]) / heat::kDay_s;
  const double of_a = std::sin((1.0 - share) * turn) / std::sin(turn), of_b = std::sin(share * turn) / std::sin(turn);
  const double along = (1.0 - share - of_a) * geometry::dot(a, pole) + (share - of_b) * geometry::dot(b, pole);
  return geometry::unit(of_a * a + of_b * b + along * pole);
}

void require_weather(const ThermalScene& scene) {
  if (scene.evaporates() && !scene.weather.has(heat::WeatherQuantity::vapour_pressure))
    throw mtf::UsageError(mtf::one_line(scene.name) +
                          ": a material has wet_fraction, for which the weather needs vapour_pressure or "
                          "relative_humidity; give one of them, or leave wet_fraction out");
  const double end = scene.last_s();
  try {
    heat::require(scene.weather, wanted_of(scene), scene.start_s, end);
  } catch (const mtf::UsageError& e) {
    if (scene.end_s >= end) throw;
    throw mtf::UsageError(std::string(e.what()) +
                          " (a run of less than a day starts from the day that repeats, so that a whole day of weather "
                          "is needed; or write weather.repeat = \"day\")");
  }
}

Surroundings surroundings_of(const ThermalScene& scene, int directions, double tolerance_k) {
  using enum heat::WeatherQuantity;
  require_weather(scene);
  const heat::WeatherSeries& weather = scene.weather;
  const double start = scene.start_s, end = scene.last_s();
  Surroundings s;
  s.warnings = weather.warnings;
  s.pole = heat::in_scene_axes({0.0, std::cos(scene.place.latitude_rad), std::sin(scene.place.latitude_rad)},
                               scene.north_rad);
  std::vector<double> times{0.0, end - start};
  // The beam jumps where the sun rises and sets, and is there at that time itself.
  for (const heat::SunCrossing& crossing : sun_crossings(scene.place, start, end)) {
    const double dark = crossing.utc_s - start + (crossing.rises ? -kJump_s : kJump_s);
    if (dark > 0.0 && dark < end - start) times.push_back(dark);
  }
  // The exchange between surfaces is a parabola between nodes, whose error goes with the cube of their distance.
  const double step = std::clamp(kLongestStep_s * std::cbrt(10.0 * tolerance_k), kShortestStep_s, kLongestStep_s);
  for (const heat::SunAt& at : shadow_directions(scene.place, start, end, directions)) {
    s.shadow_time_s.push_back(at.utc_s - start);
    s.shadow_to_sun.push_back(heat::in_scene_axes(at.sun.direction, scene.north_rad));
    // At sunrise and sunset the sun is on the horizon: rounding may not put it below, where nothing is lit.
    s.shadow_to_sun.back()[2] = std::max(s.shadow_to_sun.back()[2], kOnHorizon);
    times.push_back(at.utc_s - start);
  }
  for (const double t : break_times(weather, start, end)) times.push_back(t - start);
  for (const double t : break_times(weather, start, end, true)) times.push_back(t - start + kJump_s);
  for (const heat::Schedule* schedule : scene.schedules())
    for (const double t : break_times(*schedule, start, end)) times.push_back(t - start);
  std::vector<double> outputs;
  const auto steps = std::llround((scene.end_s - start) / scene.step_s);
  for (std::int64_t i = 0; i <= steps; ++i) outputs.push_back(static_cast<double>(i) * scene.step_s);
  times.insert(times.end(), outputs.begin(), outputs.end());
  for (double t = 0.0; t < end - start; t += step) times.push_back(t);
  s.time_s = merged(std::move(times));
  follow_jumps(s.time_s, end - start);
  for (const double t : outputs) s.outputs.push_back(node_at(s.time_s, t));

  const std::vector<heat::WeatherQuantity> wanted = wanted_of(scene);
  for (const double t : s.time_s) {
    const double utc = std::min(start + t, end);
    heat::WeatherAt at;
    std::ranges::fill(at.value, std::numeric_limits<double>::quiet_NaN());
    for (const heat::WeatherQuantity quantity : wanted)
      at.value[static_cast<std::size_t>(quantity)] = value_at(weather, quantity, utc, heat::Limit::before);
    const heat::SunPosition sun = sun_position(utc, scene.place);
    const double up = sun.direction[2];
    s.air_k.push_back(at[air_temperature]);
    s.vapour_pa.push_back(std::isnan(at[vapour_pressure]) ? 0.0 : at[vapour_pressure]);
    s.wind_m_s.push_back(std::max(at[wind_speed], 0.0));
    s.direct_w_m2.push_back(up > -10.0 * kOnHorizon ? std::max(at[direct_normal], 0.0) : 0.0);
    s.diffuse_w_m2.push_back(std::max(at[diffuse_horizontal], 0.0));
    s.global_w_m2.push_back(s.direct_w_m2.back() * std::max(up, 0.0) + s.diffuse_w_m2.back());
    s.sky_longwave_w_m2.push_back(scene.sky.w_m2 ? scene.sky.w_m2(at) : at[longwave_down]);
    if (!std::isfinite(s.sky_longwave_w_m2.back()))
      throw mtf::UsageError(mtf::one_line(scene.name) + ": the sky's long-wave irradiance is not finite at " +
                            heat::instant_text(utc) + "; LongwaveSky::columns names the columns that it reads");
    s.to_sun.push_back(heat::in_scene_axes(sun.direction, scene.north_rad));
  }
  s.shadow_entry = entries_of(s, scene);
  return s;
}

}  // namespace radiometry::thermal
