// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/render/picture_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "apps/scene/heat/ground.h"
#include "apps/scene/heat/stopwatch.h"
#include "apps/text/words.h"
#include "mtf/error.h"
#include "radiometry/atmosphere/sky_radiance.h"
#include "radiometry/heat/weather/instant.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;
namespace render = radiometry::render;
using heat::WeatherQuantity;

std::string text_of(const char* format, double a, double b = 0.0) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), format, a, b);
  return text.data();
}

radiometry::Spectrum spectrum_of(const Emissivity& emissivity, const std::string& name) {
  return emissivity.spectrum ? *emissivity.spectrum
                             : radiometry::constant_spectrum(name + ": emissivity", emissivity.value, 1.0);
}

/// One finish for each material, one for the backs of each that is a sheet with another emissivity, and black.
void set_finishes(const SceneFile& file, const Surfaces& surfaces, render::RenderScene& scene) {
  std::vector<std::uint32_t> back(file.materials.size());
  for (const MaterialSection& material : file.materials)
    scene.finish.push_back({material.name, spectrum_of(material.emissivity, material.name)});
  for (std::size_t m = 0; m < back.size(); ++m) {
    back[m] = static_cast<std::uint32_t>(m);
    const auto& other = file.materials[m].inside.back_emissivity;
    if (!other) continue;
    back[m] = static_cast<std::uint32_t>(scene.finish.size());
    scene.finish.push_back({file.materials[m].name + " (back)", spectrum_of(*other, file.materials[m].name)});
  }
  const auto black = static_cast<std::uint32_t>(scene.finish.size());
  scene.finish.push_back({"black", radiometry::constant_spectrum("black", 1.0, 1.0)});
  for (std::uint32_t f = 0; f < surfaces.facets.size(); ++f) {
    const auto& material = file.regions[surfaces.region[f]].material;
    scene.finish_of.push_back(material ? static_cast<std::uint32_t>(*material) : black);
    scene.finish_of.push_back(!material                     ? black
                              : is_sheet(file, surfaces, f) ? back[*material]
                                                            : static_cast<std::uint32_t>(*material));
  }
  scene.ground.finish =
      file.ground && file.ground->material ? static_cast<std::uint32_t>(*file.ground->material) : black;
}

double ground_k(const SceneFile& file, const Surfaces& surfaces, double utc_s, double air_k) {
  constexpr double kTolerance_k = 0.1;
  constexpr int kDirections = 36;
  if (!file.ground) return air_k;
  if (file.ground->temperature) return value_at(file.ground->temperature->schedule, utc_s);
  const Surroundings s = surroundings_of(file, kDirections, kTolerance_k);
  const LevelRun level = level_run(s, file.time.start_s, surfaces.material[*file.ground->material], kTolerance_k);
  const double at = std::clamp(utc_s - file.time.start_s, s.time_s.front(), s.time_s.back());
  const auto above = std::upper_bound(s.time_s.begin() + 1, s.time_s.end() - 1, at);
  const auto k = static_cast<std::size_t>(above - s.time_s.begin());
  return std::lerp(level.kelvin[k - 1], level.kelvin[k], (at - s.time_s[k - 1]) / (s.time_s[k] - s.time_s[k - 1]));
}

constexpr int kSkyAngles = 4;  // Gauss's nodes of the flux: within 0.1 W/m2 of eight

void set_weather(const SceneFile& file, const Surfaces& surfaces, const PictureOptions& options, PictureScene& out) {
  const heat::WeatherSeries series = scene_weather(file);
  require(series, {WeatherQuantity::air_temperature, WeatherQuantity::direct_normal}, out.utc_s, out.utc_s);
  const heat::WeatherAt weather = weather_at(series, out.utc_s);
  const double air_k = weather[WeatherQuantity::air_temperature];
  std::optional<ClearSkyFlux> clear = clear_sky_of(file);
  const SkyLongwave sky = sky_longwave(file.sky, weather, clear ? &*clear : nullptr);
  out.scene.sky = {.longwave_w_m2 = sky.irradiance_w_m2, .cloud_cover = sky.cloud_cover, .cloud_k = air_k};

  if (options.air && options.sensor_air && file.atmosphere)
    throw mtf::UsageError(one_line(options.sensor_file) + " and " + one_line(file.file) +
                          " both have [atmosphere]; the air belongs to one of them");
  if (options.air && file.atmosphere) {
    const double vapour = weather[WeatherQuantity::vapour_pressure];
    const ClearSkyFlux model(*file.atmosphere, file.place.altitude_m);
    out.scene.air = model.air_at(air_k, std::isnan(vapour) ? std::nullopt : std::optional(vapour));
    out.closures.emplace_back("air",
                              "[atmosphere] of " + one_line(file.file) + ", its lowest 2 km as the weather has them");
  } else if (options.air && options.sensor_air) {
    out.scene.air = options.sensor_air;
    out.closures.emplace_back("air", "[atmosphere] of " + one_line(options.sensor_file));
  } else {
    out.closures.emplace_back("air", "none: the path is not in the picture");
  }
  const bool layered = out.scene.air && out.scene.air->profile.levels.size() > 1;
  // Where nothing else says how much of the sky is clear, as much as gives the long wave that was measured.
  if (layered && file.sky.longwave == LongwaveModel::measured && file.sky.cloud == CloudSource::none) {
    const double from_m = std::max(file.place.altitude_m, out.scene.air->profile.levels.front().altitude_m);
    const double clear_w_m2 = sky_flux(*out.scene.air, from_m, kSkyAngles).total_w_m2;
    out.scene.sky.cloud_cover = radiometry::atmosphere::cloud_cover(sky.irradiance_w_m2, clear_w_m2, air_k);
  }
  const double cover = out.scene.sky.cloud_cover;
  out.closures.emplace_back("sky", layered
                                       ? text_of("clear sky of the air, %.0f %% of it", 100.0 * (1.0 - cover)) +
                                             (cover > 0.0 ? text_of(", and clouds at %.1f K", air_k) : std::string())
                                       : text_of("blackbody of %.1f K for %.1f W/m2 of long wave",
                                                 heat::sky_temperature_k(sky.irradiance_w_m2), sky.irradiance_w_m2));
  const heat::SunPosition sun = sun_position(out.utc_s, file.place);
  const double direct = std::max(weather[WeatherQuantity::direct_normal], 0.0);
  if (sun.direction[2] > 0.0 && direct > 0.0)
    out.scene.sun = render::Sun{heat::in_scene_axes(sun.direction, file.north_rad), direct};
  out.closures.emplace_back("sun", out.scene.sun ? text_of("Planck at 5772 K, scaled to %.0f W/m2", direct) +
                                                       (layered ? ", through the air above" : "")
                                                 : std::string("none"));
  out.scene.ground.temperature_k = ground_k(file, surfaces, out.utc_s, air_k);
  out.closures.emplace_back("ground", text_of("level, %.2f K", out.scene.ground.temperature_k) + ", " +
                                          one_line(out.scene.finish[out.scene.ground.finish].name));
  out.scene.altitude_m = file.place.altitude_m;
}

}  // namespace

PictureSource::PictureSource(const SceneFile& file, PictureOptions options, std::optional<HeatRows> rows)
    : file_(file), options_(std::move(options)) {
  require_files(file_);
  const Stopwatch read;
  surfaces_ = read_surfaces(file_);
  timing_ms_.emplace_back("meshes", read.ms());
  const Stopwatch opened;
  if (rows)
    temperatures_.emplace(file_, surfaces_, std::move(*rows));
  else
    temperatures_.emplace(file_, surfaces_, options_.temperatures);
  set_finishes(file_, surfaces_, finishes_);
  timing_ms_.emplace_back("temperatures", opened.ms());
  const Stopwatch tree;
  rays_ = std::make_shared<const radiometry::scene::Rays>(std::move(surfaces_.facets));
  finishes_.rays = rays_.get();
  timing_ms_.emplace_back("tree", tree.ms());
}

PictureScene PictureSource::at(std::optional<double> utc_s, const PictureOptions& air) {
  PictureScene out;
  out.rays = rays_;
  out.scene = finishes_;
  out.warnings = surfaces_.warnings;
  out.timing_ms = timing_ms_;
  out.utc_s = utc_s ? *utc_s : options_.utc_s ? *options_.utc_s : temperatures_->default_utc_s();
  const Stopwatch reading;
  temperatures(out.utc_s, out.scene.temperature_k);
  out.timing_ms[1].second += reading.ms();
  const Stopwatch weather;
  set_weather(file_, surfaces_, air, out);
  out.timing_ms.emplace_back("weather", weather.ms());
  return out;
}

void PictureSource::temperatures(double utc_s, std::vector<float>& kelvin) {
  const std::scoped_lock guard(reading_);
  temperatures_->at(utc_s, kelvin);
}

PictureScene read_picture_scene(const SceneFile& file, const PictureOptions& options) {
  return PictureSource(file, options).at();
}

void require_above_ground(const PictureScene& picture, const radiometry::scene::Point& camera) {
  const radiometry::scene::Facets& facets = picture.rays->facets();
  const auto up = picture.rays->first_hit({camera, {0.0, 0.0, 1.0}});
  const auto down = picture.rays->first_hit({camera, {0.0, 0.0, -1.0}});
  if (!hits(up) || !up.back || hits(down) || facets.shells[facets.facet[up.facet].shell].closed) return;
  throw mtf::UsageError("the camera is " + significant(up.distance_m, 3) + " m below mesh '" +
                        one_line(facets.report[facets.facet[up.facet].mesh].name) +
                        "', with nothing under it: it stands below the ground; move its position up");
}

}  // namespace apps::scene
