// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/fit/measured_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "radiometry/light/constants.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// Records that are missing leave longer ones.
std::optional<double> smallest_step(const std::vector<double>& time_s) {
  if (time_s.size() < 2) return std::nullopt;
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < time_s.size(); ++i) step = std::min(step, time_s[i] - time_s[i - 1]);
  return step;
}

/// On equal steps, with nothing where a record is missing: the correlation of neighbours is that of neighbours in time.
MeasuredSurface on_equal_steps(const MeasuredSurface& given) {
  const std::optional<double> step = smallest_step(given.time_s);
  if (!step) return given;
  constexpr double kOffGrid = 0.01, kMostSteps = 1e6;
  const double last = (given.time_s.back() - given.time_s.front()) / *step;
  if (!(last <= kMostSteps))
    throw mtf::UsageError(one_line(given.source) + ": the shortest time between two records is " +
                          mtf::format_double(*step) + " s, of which the run has more than a million; average them");
  MeasuredSurface even{.source = given.source, .from_longwave = given.from_longwave, .time_s = {}, .kelvin = {}};
  for (std::size_t i = 0; i < given.time_s.size(); ++i) {
    const double place = (given.time_s[i] - given.time_s.front()) / *step;
    if (std::abs(place - std::round(place)) > kOffGrid)
      throw mtf::UsageError(one_line(given.source) + ": the records are not equally spaced; " +
                            mtf::format_double(given.time_s[i]) + " s after the start is no multiple of " +
                            mtf::format_double(*step) + " s from the first: give equal steps, or means over them");
    while (even.time_s.size() < static_cast<std::size_t>(std::llround(place))) {
      even.time_s.push_back(given.time_s.front() + static_cast<double>(even.time_s.size()) * *step);
      even.kelvin.push_back(kMissing);
    }
    even.time_s.push_back(given.time_s[i]);
    even.kelvin.push_back(given.kelvin[i]);
  }
  return even;
}

MeasuredSurface from_longwave(const SceneFile& scene, double emissivity) {
  using enum heat::WeatherQuantity;
  if (scene.weather.file.empty())
    throw mtf::UsageError(one_line(scene.file) +
                          ": the weather is constant and tells no temperature of the ground; write [measured] with "
                          "temperature = \"surface.csv\"");
  const heat::Weather weather = scene_weather_records(scene).weather;
  if (!weather.has(longwave_up) || !weather.has(longwave_down))
    throw mtf::UsageError(
        one_line(scene.weather.file) +
        ": has no longwave_up beside longwave_down, which tell the temperature of the ground; or write "
        "[measured] with temperature = \"surface.csv\"");
  MeasuredSurface measured{.source = scene.weather.file, .from_longwave = true, .time_s = {}, .kelvin = {}};
  const double interval =
      scene.weather.average_s > 0.0 ? scene.weather.average_s : smallest_step(weather.time_s).value_or(0.0);
  for (std::size_t i = 0; i < weather.time_s.size(); ++i) {
    const double emitted = weather[longwave_up][i] - (1.0 - emissivity) * weather[longwave_down][i];
    measured.time_s.push_back(weather.time_s[i] + to_middle(weather.stamp) * interval - scene.time.start_s);
    measured.kelvin.push_back(
        emitted > 0.0 ? std::pow(emitted / (emissivity * radiometry::kStefanBoltzmann_w_m2_k4), 0.25) : kMissing);
  }
  return measured;
}

}  // namespace

MeasuredSurface measured_surface(const SceneFile& scene, double emissivity) {
  MeasuredSurface measured;
  if (scene.measured && !scene.measured->temperature.value.empty()) {
    const heat::Schedule& table = scene.measured->temperature;
    measured.source = table.source;
    measured.kelvin = table.value;
    for (const double t : table.time_s) measured.time_s.push_back(t - scene.time.start_s);
  } else {
    measured = from_longwave(scene, emissivity);
  }
  MeasuredSurface inside{
      .source = measured.source, .from_longwave = measured.from_longwave, .time_s = {}, .kelvin = {}};
  for (std::size_t i = 0; i < measured.time_s.size(); ++i) {
    if (measured.time_s[i] < 0.0 || measured.time_s[i] > scene.time.end_s - scene.time.start_s) continue;
    inside.time_s.push_back(measured.time_s[i]);
    inside.kelvin.push_back(measured.kelvin[i]);
  }
  if (inside.time_s.empty())
    throw mtf::UsageError(one_line(measured.source) + ": no record lies between the start of the run, " +
                          heat::instant_text(scene.time.start_s) + ", and its end");
  return on_equal_steps(inside);
}

}  // namespace apps::scene
