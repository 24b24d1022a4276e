// SPDX-License-Identifier: Apache-2.0

// The weather and the sky that a scene file asks for, at run time.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/scene/scene_file/scene_file.h"
#include "mtf/error.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;

/// Degrees of latitude and longitude by which the place of a weather file may differ before it is said.
constexpr double kNear_deg = 0.5;

double value_of(const heat::WeatherAt& weather, WeatherQuantity quantity, std::string_view what) {
  const double value = weather[quantity];
  if (std::isnan(value))
    throw mtf::UsageError("[sky] " + std::string(what) + " needs " + std::string(heat::quantity_name(quantity)) +
                          ", which the weather does not have");
  return value;
}

heat::SkyModel model_of(LongwaveModel longwave) {
  return longwave == LongwaveModel::brunt      ? heat::SkyModel::brunt
         : longwave == LongwaveModel::swinbank ? heat::SkyModel::swinbank
                                               : heat::SkyModel::brutsaert;
}

void apply(const WeatherChange& change, heat::Weather& weather) {
  const auto for_values = [&](WeatherQuantity quantity, double factor, double offset) {
    for (double& value : weather[quantity]) value = factor * value + offset;
  };
  for_values(WeatherQuantity::air_temperature, 1.0, change.air_temperature_offset_k);
  for_values(WeatherQuantity::wind_speed, change.wind_speed_factor, 0.0);
  for (const WeatherQuantity quantity :
       {WeatherQuantity::direct_normal, WeatherQuantity::diffuse_horizontal, WeatherQuantity::global_horizontal})
    for_values(quantity, change.solar_factor, 0.0);
  for_values(WeatherQuantity::longwave_down, 1.0, change.longwave_down_offset_w_m2);
  try {
    heat::check_weather(weather);
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError(std::string("with the offsets and factors of [weather]: ") + error.what());
  }
}

}  // namespace

WeatherFile scene_weather_records(const SceneFile& scene) {
  const WeatherSection& section = scene.weather;
  WeatherFile file = read_weather(
      section.file,
      {.stamp = section.stamp, .origin_s = scene.time.start_s, .year = heat::date_of(scene.time.start_s).year});
  if (file.weather.time_s.size() == 1)
    throw mtf::UsageError(section.file +
                          ": it has one record, which says nothing of other times; for constant weather write its "
                          "values in [weather]");
  if (section.average_s > 0.0) file.weather = averaged(file.weather, section.average_s);
  if (section.change != WeatherChange{}) apply(section.change, file.weather);
  return file;
}

heat::WeatherSeries scene_weather(const SceneFile& scene) {
  const WeatherSection& section = scene.weather;
  const double start_s = scene.time.start_s, end_s = std::max(scene.time.end_s, start_s + heat::kDay_s);
  const heat::SeriesOptions options{
      .repeat = section.repeat, .longest_bridge_s = section.longest_bridge_s, .begin_s = start_s, .end_s = end_s};
  if (section.file.empty()) return make_series(section.constant, scene.place, options);
  const WeatherFile file = scene_weather_records(scene);
  heat::WeatherSeries series = make_series(file.weather, scene.place, options);
  series.warnings.insert(series.warnings.begin(), file.warnings.begin(), file.warnings.end());
  if (start_s < series.first_stamp_s || end_s > series.last_stamp_s)
    series.warnings.push_back(section.file + ": the run reaches beyond the stamps, from " +
                              heat::instant_text(series.first_stamp_s) + " to " +
                              heat::instant_text(series.last_stamp_s) +
                              "; what holds at a stamp is taken to stay for the rest of the hour");
  if (file.place) {
    constexpr double degree = std::numbers::pi / 180.0;
    const double north_deg = (file.place->latitude_rad - scene.place.latitude_rad) / degree;
    const double east_deg = std::remainder((file.place->longitude_rad - scene.place.longitude_rad) / degree, 360.0);
    if (std::hypot(north_deg, east_deg) > kNear_deg)
      series.warnings.push_back(section.file + ": the station is " +
                                mtf::format_double(std::round(10.0 * std::hypot(north_deg, east_deg)) / 10.0) +
                                " deg away from [place]; is it the right one?");
  }
  return series;
}

std::optional<ClearSkyFlux> clear_sky_of(const SceneFile& scene) {
  if (scene.sky.longwave != LongwaveModel::atmosphere) return std::nullopt;
  if (!scene.atmosphere)
    throw mtf::UsageError(scene.file +
                          ": [sky] longwave = \"atmosphere\" needs [atmosphere], for example with model = "
                          "\"mid_latitude_summer\"");
  try {
    return ClearSkyFlux(*scene.atmosphere, scene.place.altitude_m);
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError(scene.file + ": " + error.what());
  }
}

SkyLongwave sky_longwave(const SkySection& sky, const heat::WeatherAt& weather, ClearSkyFlux* air) {
  if (sky.longwave == LongwaveModel::atmosphere && air == nullptr)
    throw mtf::UsageError("[sky] longwave = \"atmosphere\" needs the air of [atmosphere] (clear_sky_of)");
  const auto clear = [&](std::string_view what) {
    if (air != nullptr)
      return air->at(value_of(weather, WeatherQuantity::air_temperature, what),
                     value_of(weather, WeatherQuantity::vapour_pressure, what));
    const heat::SkyModel model = model_of(sky.longwave);
    const double vapour =
        model == heat::SkyModel::swinbank ? 0.0 : value_of(weather, WeatherQuantity::vapour_pressure, what);
    return heat::clear_sky_longwave_w_m2(model, value_of(weather, WeatherQuantity::air_temperature, what), vapour);
  };
  double cover = 0.0;
  if (sky.cloud == CloudSource::constant) cover = sky.cloud_cover;
  if (sky.cloud == CloudSource::from_weather)
    cover = value_of(weather, WeatherQuantity::cloud_cover, "cloud = \"from_weather\"");
  if (sky.cloud == CloudSource::from_longwave) {
    constexpr std::string_view what = "cloud = \"from_longwave\"";
    cover = heat::cloud_cover_from_longwave(value_of(weather, WeatherQuantity::longwave_down, what), clear(what));
  }
  if (sky.longwave == LongwaveModel::measured)
    return {value_of(weather, WeatherQuantity::longwave_down, "longwave = \"measured\""), cover};
  const std::string what = "longwave = \"" + std::string(kLongwaveNames[static_cast<std::size_t>(sky.longwave)]) + "\"";
  return {clear(what) * heat::cloud_factor(cover), cover};
}

}  // namespace apps::scene
