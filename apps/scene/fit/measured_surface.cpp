// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/fit/measured_surface.h"

#include <cmath>
#include <limits>

#include "apps/text/words.h"
#include "mtf/error.h"
#include "radiometry/heat/weather/instant.h"
#include "radiometry/light/constants.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// Of a record's stamp, where it stands for an interval: the middle, from the stamp.
double to_middle_s(heat::Stamp stamp, double interval_s) {
  return stamp == heat::Stamp::begin ? 0.5 * interval_s : stamp == heat::Stamp::end ? -0.5 * interval_s : 0.0;
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
  const std::size_t n = weather.time_s.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double interval = scene.weather.average_s > 0.0 ? scene.weather.average_s
                            : i > 0                       ? weather.time_s[i] - weather.time_s[i - 1]
                            : n > 1                       ? weather.time_s[1] - weather.time_s[0]
                                                          : 0.0;
    const double emitted = weather[longwave_up][i] - (1.0 - emissivity) * weather[longwave_down][i];
    measured.time_s.push_back(weather.time_s[i] + to_middle_s(weather.stamp, interval) - scene.time.start_s);
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
  return inside;
}

}  // namespace apps::scene
