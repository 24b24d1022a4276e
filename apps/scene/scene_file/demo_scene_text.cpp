// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/scene_file/demo_scene_text.h"

#include <cmath>
#include <numbers>

#include "apps/scene/scene_file/demo_engine.csv.h"
#include "apps/scene/scene_file/demo_scene.toml.h"
#include "apps/scene/weather/weather_file.h"
#include "radiometry/weather/demo_weather.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;

constexpr double kDegree = std::numbers::pi / 180.0;
const heat::Place kPlace{37.70 * kDegree, -105.92 * kDegree, 2317.0};
constexpr heat::CalendarDate kFirstDay{2026, 6, 21};
constexpr double kHours = 48.0;

}  // namespace

std::string demo_scene_text() { return std::string(mtf::embedded::demo_scene_toml); }
std::string demo_engine_text() { return std::string(mtf::embedded::demo_engine_csv); }

std::string demo_weather_text() {
  const double start = heat::instant_of(kFirstDay);
  heat::Weather weather = heat::demo_weather(kPlace, start, start + 3600.0 * kHours, 600.0);
  for (auto& values : weather.values)
    for (double& value : values)
      value = std::round(100.0 * value) / 100.0;  // the model is no better, the text readable
  return weather_csv(weather,
                     {"Two clear days by a model, not measured: Bird and Hulstrom's clear sky, a daily wave of",
                      "temperature and wind, constant vapour, Brutsaert's long wave."});
}

}  // namespace apps::scene
