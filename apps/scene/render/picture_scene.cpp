// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/render/picture_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "apps/scene/heat/read_temperatures.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/work/stopwatch.h"
#include "radiometry/atmosphere/sky_radiance.h"
#include "radiometry/atmosphere/spectral_path.h"
#include "radiometry/render/light_sources.h"
#include "radiometry/thermal/ground.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;
namespace render = radiometry::render;

constexpr int kSkyAngles = 4;  // Gauss's nodes of the flux: within 0.1 W/m2 of eight

std::string words(double value, int decimals, const char* unit) { return fixed(value, decimals) + " " + unit; }

bool has_layers(const std::optional<radiometry::atmosphere::Air<double>>& air) {
  return air && air->profile.levels.size() > 1;
}

void set_air(const SceneFile& file, const heat::WeatherAt& weather, const PictureOptions& options, double air_k,
             PictureScene& out) {
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
}

void set_sky(const SceneFile& file, const SkyLongwave& longwave, double air_k, PictureScene& out) {
  render::Sky& sky = out.scene.sky;
  const auto& air = out.scene.air;
  sky = {.longwave_w_m2 = longwave.irradiance_w_m2, .cloud_cover = longwave.cloud_cover, .cloud_k = air_k};
  if (!has_layers(air)) {
    out.closures.emplace_back("sky", "blackbody of " +
                                         words(heat::sky_temperature_k(longwave.irradiance_w_m2), 1, "K for ") +
                                         words(longwave.irradiance_w_m2, 1, "W/m2 of long wave"));
    return;
  }
  const double from_m = std::max(file.place.altitude_m, air->profile.levels.front().altitude_m);
  const auto clear = sky_flux(*air, from_m, kSkyAngles);
  // Where nothing else says how much of the sky is clear, as much as gives the long wave that was measured.
  if (file.sky.longwave == LongwaveModel::measured && file.sky.cloud == CloudSource::none)
    sky.cloud_cover = radiometry::atmosphere::cloud_cover(longwave.irradiance_w_m2, clear.total_w_m2, sky.cloud_k);
  const double cover = sky.cloud_cover;
  const double flux = under_clouds(clear, {cover, sky.cloud_k}).total_w_m2;
  out.closures.emplace_back("sky", "clear sky of the air, " + fixed(100.0 * (1.0 - cover), 0) + " % of it" +
                                       (cover > 0.0 ? ", and clouds at " + words(sky.cloud_k, 1, "K") : std::string()) +
                                       ": " + words(flux, 1, "W/m2 of long wave, ") +
                                       words(longwave.irradiance_w_m2, 1, "W/m2 in the heat balance"));
}

radiometry::Spectrum spectrum_of(const Emissivity& emissivity, const std::string& name) {
  return emissivity.spectrum ? *emissivity.spectrum
                             : radiometry::constant_spectrum(name + ": emissivity", emissivity.along_normal, 1.0);
}

/// Whether the back of that facet is exposed and has a temperature of its own.
bool is_sheet(const ThermalScene& scene, std::uint32_t facet) {
  const auto& material = scene.regions[scene.region_of[facet]].material;
  return material && scene.materials[*material].is_sheet();
}

/// One finish for each material, one for the backs of each that is a sheet with another emissivity, and black.
void set_finishes(const SceneFile& file, const ThermalScene& surfaces, render::RenderScene& scene) {
  std::vector<std::uint32_t> back(file.materials.size());
  for (const MaterialSection& material : file.materials)
    scene.finish.push_back(
        {material.name, spectrum_of(material.emissivity, material.name), material.by_angle, material.gloss});
  for (std::size_t m = 0; m < back.size(); ++m) {
    back[m] = static_cast<std::uint32_t>(m);
    const auto& other = file.materials[m].inside.back_emissivity;
    if (!other) continue;
    back[m] = static_cast<std::uint32_t>(scene.finish.size());
    scene.finish.push_back({file.materials[m].name + " (back)", spectrum_of(*other, file.materials[m].name),
                            file.materials[m].by_angle, file.materials[m].gloss});
  }
  const auto black = static_cast<std::uint32_t>(scene.finish.size());
  scene.finish.push_back({"black", radiometry::constant_spectrum("black", 1.0, 1.0), {}, 0.0});
  for (std::uint32_t f = 0; f < surfaces.facets.size(); ++f) {
    const auto& material = surfaces.regions[surfaces.region_of[f]].material;
    scene.finish_of.push_back(material ? static_cast<std::uint32_t>(*material) : black);
    scene.finish_of.push_back(!material               ? black
                              : is_sheet(surfaces, f) ? back[*material]
                                                      : static_cast<std::uint32_t>(*material));
  }
  scene.ground.finish =
      file.ground && file.ground->material ? static_cast<std::uint32_t>(*file.ground->material) : black;
}

double ground_k(const SceneFile& file, const ThermalScene& surfaces, double utc_s, double air_k,
                std::optional<heat::Schedule>& solved) {
  constexpr double kTolerance_k = 0.1;
  constexpr int kDirections = 36;
  if (!file.ground) return air_k;
  if (file.ground->temperature) return value_at(file.ground->temperature->schedule, utc_s);
  if (!solved) {
    const Surroundings s = surroundings_of(file, kDirections, kTolerance_k);
    solved = {"the ground", s.time_s,
              level_run(s, file.time.start_s, surfaces.materials[*file.ground->material], kTolerance_k).kelvin};
  }
  return value_at(*solved, utc_s - file.time.start_s);
}

/// Throws UsageError, with the regions, where a front has no temperature.
void require_all(const ThermalScene& surfaces, const std::string& source, const std::vector<float>& kelvin) {
  std::vector<std::size_t> unknown(surfaces.regions.size(), 0);
  for (std::size_t f = 0; f < surfaces.region_of.size(); ++f)
    if (!(kelvin[2 * f] > 0.0F)) ++unknown[surfaces.region_of[f]];
  std::string missing;
  for (std::size_t r = 0; r < unknown.size(); ++r)
    if (unknown[r] > 0)
      missing += (missing.empty() ? "'" : ", '") + one_line(surfaces.regions[r].name) + "' (" +
                 std::to_string(unknown[r]) + " facets)";
  if (!missing.empty())
    throw mtf::UsageError(one_line(source) + ": has no temperature for facets of the regions " + missing);
}

/// Where the picture's time is beyond the samples of a temperature.
void warn_of_held(const heat::Schedule& schedule, PictureScene& out) {
  if (std::string text = held_beyond(schedule, out.utc_s, out.utc_s); !text.empty())
    out.warnings.push_back(std::move(text));
}

/// With the ground, and the altitude.
void surround(const SceneFile& file, const ThermalScene& surfaces, const PictureOptions& options,
              std::optional<heat::Schedule>& ground, PictureScene& out) {
  const double air_k = add_surroundings(file, options, out);
  out.scene.ground.temperature_k = ground_k(file, surfaces, out.utc_s, air_k, ground);
  out.closures.emplace_back("ground", "level, " + fixed(out.scene.ground.temperature_k, 2) + " K, " +
                                          one_line(out.scene.finish[out.scene.ground.finish].name));
  out.scene.altitude_m = file.place.altitude_m;
  if (file.ground && file.ground->temperature) warn_of_held(file.ground->temperature->schedule, out);
}

}  // namespace

double add_surroundings(const SceneFile& file, const PictureOptions& options, PictureScene& picture) {
  const heat::WeatherSeries series = scene_weather(file);
  require(series, {WeatherQuantity::air_temperature, WeatherQuantity::direct_normal}, picture.utc_s, picture.utc_s);
  const heat::WeatherAt weather = weather_at(series, picture.utc_s);
  const double air_k = weather[WeatherQuantity::air_temperature];
  set_air(file, weather, options, air_k, picture);
  std::optional<ClearSkyFlux> clear = clear_sky_of(file);
  set_sky(file, sky_longwave(file.sky, weather, clear ? &*clear : nullptr), air_k, picture);

  const heat::SunPosition sun = sun_position(picture.utc_s, file.place);
  double direct = std::max(weather[WeatherQuantity::direct_normal], 0.0);
  const bool shines = sun.direction[2] > 0.0 && direct > 0.0, layered = has_layers(picture.scene.air);
  if (shines && layered) {
    constexpr double kMost = 1.5;  // models of clear air are within a third of measured beams
    const radiometry::atmosphere::Air<double>& air = *picture.scene.air;
    const double from_m = std::max(file.place.altitude_m, air.profile.levels.front().altitude_m);
    const double passed = extraterrestrial_normal_w_m2(sun) * render::sunlight_passed(air, from_m, sun.zenith_rad);
    if (direct > kMost * passed)
      picture.warnings.push_back(
          "the sun: direct_normal of the weather is more than half as much again as the air of [atmosphere] lets "
          "through, and no more than that is taken; it is " +
          words(direct, 0, "W/m2, and through the air come ") + words(passed, 1, "W/m2: make one fit the other"));
    direct = std::min(direct, kMost * passed);
  }
  if (shines) picture.scene.sun = render::Sun{heat::in_scene_axes(sun.direction, file.north_rad), direct};
  picture.closures.emplace_back("sun", shines ? "Planck at 5772 K, scaled to " + words(direct, 0, "W/m2") +
                                                    (layered ? ", through the air above" : "")
                                              : std::string("none"));
  return air_k;
}

std::string regions_to_solve(const SceneFile& file) {
  std::string missing;
  for (const RegionSection& region : file.regions)
    if (!region.temperature) missing += (missing.empty() ? "'" : ", '") + one_line(region.name) + "'";
  return missing;
}

TemperatureRows solved_rows(const SceneFile& file, double from_s, double to_s, const HeatOptions& options,
                            const HeatProgress& progress) {
  using heat::instant_text;
  SceneFile until = file;
  TimeSection& time = until.time;
  if (!(from_s >= time.start_s && to_s <= time.end_s))
    throw mtf::UsageError("--time: " + instant_text(from_s) + (to_s > from_s ? " to " + instant_text(to_s) : "") +
                          " is outside of the run of " + one_line(file.file) + ", which goes from " +
                          instant_text(time.start_s) + " to " + instant_text(time.end_s));
  // Two outputs at least, between which temperatures are straight lines.
  const double steps = std::max(std::ceil((to_s - time.start_s) / time.step_s), 1.0);
  time.end_s = std::min(time.start_s + steps * time.step_s, time.end_s);
  TemperatureRows rows{.source = file.file};
  const HeatScene scene = prepare_heat(until, options);
  run_heat(
      scene, options,
      [&](const HeatOutput& output) {
        const double utc_s = time.start_s + output.time_s;
        if (utc_s + time.step_s < from_s) return;
        rows.append(utc_s, output.front_k, output.back_k);
      },
      progress);
  return rows;
}

PictureScene read_layer_scene(const SceneFile& file, const PictureOptions& options) {
  require_files(file);
  PictureScene out;
  out.utc_s = options.utc_s.value_or(file.time.start_s);
  ThermalScene surfaces = values_of(file);
  read_meshes(file, surfaces);
  set_finishes(file, surfaces, out.scene);
  std::optional<heat::Schedule> ground;
  surround(file, surfaces, options, ground, out);
  return out;
}

PictureSource::PictureSource(const SceneFile& file, PictureOptions options, std::optional<TemperatureRows> rows)
    : file_(file), options_(std::move(options)) {
  require_files(file_);
  const mtf::Stopwatch read;
  surfaces_ = values_of(file_);
  read_meshes(file_, surfaces_);
  timing_ms_.emplace_back("meshes", read.ms());
  const mtf::Stopwatch opened;
  of_regions_ = !rows && options_.temperatures.empty();
  if (rows) {
    require_valid(*rows, surfaces_.facets.size(), one_line(file_.file));
    rows_ = std::move(*rows);
  } else if (!of_regions_) {
    constexpr double kLast = std::numeric_limits<double>::infinity();
    rows_ = read_temperatures(options_.temperatures, surfaces_.facets.size(), options_.utc_s.value_or(kLast));
  } else {
    if (const std::string missing = regions_to_solve(file_); !missing.empty())
      throw mtf::UsageError(one_line(file_.file) + ": no temperature is given for the regions " + missing +
                            "; name the folder that `mtf heat` wrote with --temperatures, or give each region a "
                            "temperature");
    read_tables(file_, surfaces_);
  }
  const radiometry::scene::Facets& facets = surfaces_.facets;
  for (std::uint32_t f = 0; f < facets.size(); ++f)
    solid_.push_back(facets.shells[facets.facet[f].shell].outward && !is_sheet(surfaces_, f));
  set_finishes(file_, surfaces_, finishes_);
  timing_ms_.emplace_back("temperatures", opened.ms());
  const mtf::Stopwatch tree;
  rays_ = std::make_shared<const radiometry::scene::Rays>(std::move(surfaces_.facets));
  finishes_.rays = rays_.get();
  timing_ms_.emplace_back("tree", tree.ms());
}

PictureScene PictureSource::at(std::optional<double> utc_s, const PictureOptions& air) {
  PictureScene out;
  out.rays = rays_;
  out.scene = finishes_;
  out.warnings = rays_->facets().warnings;
  out.timing_ms = timing_ms_;
  out.utc_s = utc_s                 ? *utc_s
              : options_.utc_s      ? *options_.utc_s
              : rows_.utc_s.empty() ? file_.time.start_s
                                    : rows_.utc_s.back();
  const mtf::Stopwatch reading;
  temperatures(out.utc_s, out.scene.temperature_k);
  constexpr float kCold_k = 150.0F;
  if (const auto cold = std::count_if(out.scene.temperature_k.begin(), out.scene.temperature_k.end(),
                                      [](float kelvin) { return kelvin < kCold_k; });
      cold > 0)
    out.warnings.push_back(
        std::to_string(cold) + " sides are colder than 150 K, the coldest at " +
        significant(static_cast<double>(
                        *std::min_element(out.scene.temperature_k.begin(), out.scene.temperature_k.end(),
                                          [](float a, float b) { return a < b || (std::isnan(b) && !std::isnan(a)); })),
                    3) +
        " K: are the temperatures in degrees Celsius? Tables are in kelvin");
  for (const Region& region : surfaces_.regions)
    if (of_regions_) warn_of_held(region.temperature, out);
  out.timing_ms[1].second += reading.ms();
  const mtf::Stopwatch weather;
  {
    const std::scoped_lock guard(reading_);
    surround(file_, surfaces_, air, ground_, out);
  }
  out.timing_ms.emplace_back("weather", weather.ms());
  return out;
}

void PictureSource::temperatures(double utc_s, std::vector<float>& kelvin) {
  const std::scoped_lock guard(reading_);
  if (of_regions_) {
    given_rows(surfaces_, utc_s).sides_at(utc_s, kelvin);
  } else {
    if (!rows_.has(rows_.place_of(utc_s))) {
      TemperatureRows read = read_temperatures(options_.temperatures, rows_.facets, utc_s);
      if (read.utc_s != rows_.utc_s)
        throw mtf::RuntimeError(one_line(rows_.source) + ": its times are not those that it had; start anew");
      rows_.front_k.swap(read.front_k), rows_.back_k.swap(read.back_k), rows_.first = read.first;
    }
    rows_.sides_at(utc_s, kelvin);
  }
  require_all(surfaces_, of_regions_ ? surfaces_.name : rows_.source, kelvin);
  for (std::size_t f = 0; f < solid_.size(); ++f)
    if (solid_[f]) kelvin[2 * f + 1] = std::numeric_limits<float>::quiet_NaN();
}

/// What the temperatures are taken from.
std::vector<const TemperatureRows*> PictureSource::tables() const {
  if (!of_regions_) return {&rows_};
  std::vector<const TemperatureRows*> tables;
  for (const Region& region : surfaces_.regions)
    if (region.table) tables.push_back(region.table.get());
  return tables;
}

bool PictureSource::temperatures_change() const {
  return std::ranges::any_of(tables(), &TemperatureRows::change) ||
         (of_regions_ && std::ranges::any_of(surfaces_.regions,
                                             [](const Region& region) { return region.temperature.value.size() > 1; }));
}

std::optional<std::array<double, 2>> PictureSource::temperatures_span_utc_s() const {
  std::optional<std::array<double, 2>> all;
  for (const TemperatureRows* rows : tables())
    if (const auto span = rows->span_utc_s()) {
      if (!all) all = span;
      const double begin = std::max((*all)[0], (*span)[0]);
      all = {begin, std::max(std::min((*all)[1], (*span)[1]), begin)};
    }
  return all;
}

void PictureSource::require_temperatures_at(double utc_s) const {
  for (const TemperatureRows* rows : tables()) rows->require(utc_s);
}

PictureScene read_picture_scene(const SceneFile& file, const PictureOptions& options) {
  return PictureSource(file, options).at();
}

void add_band_limits(const SceneFile& file, const radiometry::Interval& band, PictureScene& picture) {
  const auto add = [&](const std::string& text) {
    if (std::ranges::find(picture.warnings, text) == picture.warnings.end()) picture.warnings.push_back(text);
  };
  if (file.atmosphere && picture.scene.air)  // that of a sensor file is said where it is read
    for (const std::string& limit : radiometry::atmosphere::limits_of(*picture.scene.air, band))
      add("[atmosphere]: " + limit);
  constexpr double kSame = 1e-9;  // relative: wavelengths in other units are rounded
  std::set<std::uint32_t> used(picture.scene.finish_of.begin(), picture.scene.finish_of.end());
  used.insert(picture.scene.ground.finish);
  for (const std::uint32_t finish : used) {
    const radiometry::Spectrum& curve = picture.scene.finish[finish].emissivity;
    const radiometry::Interval own = range_of(curve);
    if (curve.value.size() > 1 && (own.lo_um > band.lo_um * (1.0 + kSame) || own.hi_um < band.hi_um * (1.0 - kSame)))
      add(one_line(curve.source) + ": the emissivity ends inside the band, and its last value is held; it covers " +
          describe(own) + ", the band is " + describe(band));
  }
}

void require_above_ground(const PictureScene& picture, const radiometry::scene::Point& camera) {
  const radiometry::scene::Facets& facets = picture.rays->facets();
  const double ground_m = facets.lowest_m;
  if (camera[2] < ground_m)
    throw mtf::UsageError("the camera is at a height of " + significant(camera[2], 3) +
                          " m, and the ground beyond the " + "facets lies at " + significant(ground_m, 3) +
                          " m, as low as the lowest of them: it stands " +
                          "below the ground; move its position up, or give the scene a facet that is as low");
  const auto up = picture.rays->first_hit({camera, {0.0, 0.0, 1.0}});
  const auto down = picture.rays->first_hit({camera, {0.0, 0.0, -1.0}});
  if (!hits(up) || !up.back || hits(down) || facets.shells[facets.facet[up.facet].shell].closed) return;
  throw mtf::UsageError("the camera is " + significant(up.distance_m, 3) + " m below mesh '" +
                        one_line(facets.report[facets.facet[up.facet].mesh].name) +
                        "', with nothing under it: it stands below the ground; move its position up");
}

}  // namespace apps::scene
