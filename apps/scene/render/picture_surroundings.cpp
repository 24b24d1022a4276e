// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/render/picture_surroundings.h"

#include <algorithm>
#include <cmath>

#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "radiometry/atmosphere/sky_radiance.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;

constexpr int kSkyAngles = 4;  // Gauss's nodes of the flux: within 0.1 W/m2 of eight

std::string words(double value, int decimals, const char* unit) { return fixed(value, decimals) + " " + unit; }

void set_air(const SceneFile& file, const heat::WeatherAt& weather, const PictureAir& air, PictureSurroundings& out) {
  if (air.wanted && air.of_sensor && file.atmosphere)
    throw mtf::UsageError(one_line(air.sensor_file) + " and " + one_line(file.file) +
                          " both have [atmosphere]; the air belongs to one of them");
  if (air.wanted && file.atmosphere) {
    const double vapour = weather[WeatherQuantity::vapour_pressure];
    const ClearSkyFlux model(*file.atmosphere, file.place.altitude_m);
    out.air = model.air_at(out.air_k, std::isnan(vapour) ? std::nullopt : std::optional(vapour));
    out.closures.emplace_back("air",
                              "[atmosphere] of " + one_line(file.file) + ", its lowest 2 km as the weather has them");
  } else if (air.wanted && air.of_sensor) {
    out.air = air.of_sensor;
    out.closures.emplace_back("air", "[atmosphere] of " + one_line(air.sensor_file));
  } else {
    out.closures.emplace_back("air", "none: the path is not in the picture");
  }
}

void set_sky(const SceneFile& file, const SkyLongwave& sky, PictureSurroundings& out) {
  out.sky = {.longwave_w_m2 = sky.irradiance_w_m2, .cloud_cover = sky.cloud_cover, .cloud_k = out.air_k};
  if (!out.air || out.air->profile.levels.size() < 2) {
    out.closures.emplace_back("sky", "blackbody of " +
                                         words(heat::sky_temperature_k(sky.irradiance_w_m2), 1, "K for ") +
                                         words(sky.irradiance_w_m2, 1, "W/m2 of long wave"));
    return;
  }
  const double from_m = std::max(file.place.altitude_m, out.air->profile.levels.front().altitude_m);
  const auto clear = sky_flux(*out.air, from_m, kSkyAngles);
  // Where nothing else says how much of the sky is clear, as much as gives the long wave that was measured.
  if (file.sky.longwave == LongwaveModel::measured && file.sky.cloud == CloudSource::none)
    out.sky.cloud_cover = radiometry::atmosphere::cloud_cover(sky.irradiance_w_m2, clear.total_w_m2, out.sky.cloud_k);
  const double cover = out.sky.cloud_cover;
  const double flux = under_clouds(clear, {cover, out.sky.cloud_k}).total_w_m2;
  out.closures.emplace_back(
      "sky", "clear sky of the air, " + fixed(100.0 * (1.0 - cover), 0) + " % of it" +
                 (cover > 0.0 ? ", and clouds at " + words(out.sky.cloud_k, 1, "K") : std::string()) + ": " +
                 words(flux, 1, "W/m2 of long wave, ") + words(sky.irradiance_w_m2, 1, "W/m2 in the heat balance"));
}

}  // namespace

PictureSurroundings picture_surroundings(const SceneFile& file, double utc_s, const PictureAir& air) {
  const heat::WeatherSeries series = scene_weather(file);
  require(series, {WeatherQuantity::air_temperature, WeatherQuantity::direct_normal}, utc_s, utc_s);
  const heat::WeatherAt weather = weather_at(series, utc_s);
  PictureSurroundings out;
  out.air_k = weather[WeatherQuantity::air_temperature];
  set_air(file, weather, air, out);
  std::optional<ClearSkyFlux> clear = clear_sky_of(file);
  set_sky(file, sky_longwave(file.sky, weather, clear ? &*clear : nullptr), out);

  const heat::SunPosition sun = sun_position(utc_s, file.place);
  const double direct = std::max(weather[WeatherQuantity::direct_normal], 0.0);
  if (sun.direction[2] > 0.0 && direct > 0.0)
    out.sun = radiometry::render::Sun{heat::in_scene_axes(sun.direction, file.north_rad), direct};
  const bool layered = out.air && out.air->profile.levels.size() > 1;
  out.closures.emplace_back("sun", out.sun ? "Planck at 5772 K, scaled to " + words(direct, 0, "W/m2") +
                                                 (layered ? ", through the air above" : "")
                                           : std::string("none"));
  return out;
}

}  // namespace apps::scene
