// SPDX-License-Identifier: Apache-2.0
#pragma once

// From a scene file and temperatures to what radiometry/render makes pictures of: facets, finishes and temperatures of
// all sides, sky, ground and sun of the weather at that time, and the air. Temperatures are those of a folder that `mtf
// heat` wrote or of a table of facets (read_temperatures.h); where neither is given, those that the regions of the file
// have. The ground is that of [ground], of given temperature or solved as a level surface from the start of the run;
// without it black and as warm as the air.
//   air  [atmosphere] of the scene file, its lowest 2 km as the weather has them; or that of the sensor file, as it
//        stands there
//   sky  with layered air its clear sky, and clouds as black as the air is warm: as many as [sky] says, or as give the
//        long wave that the weather has; else a blackbody of the long wave that [sky] makes of the weather
//   sun  of the weather's direct irradiance

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/scene/heat/read_thermal_scene.h"
#include "radiometry/render/render_scene.h"

namespace apps::scene {

struct PictureOptions {
  std::string temperatures{};     ///< folder of `mtf heat`, or a table of facets; "": of the file
  std::optional<double> utc_s{};  ///< else the last time of the temperatures, or the start of the file
  /// [atmosphere] of the sensor file.
  std::optional<radiometry::atmosphere::Air<double>> sensor_air{};
  std::string sensor_file{};  ///< for messages
  bool air = true;            ///< false: pictures of surfaces alone
};

struct PictureScene {
  std::shared_ptr<const radiometry::scene::Rays> rays;
  radiometry::render::RenderScene scene;  ///< refers to `rays`
  double utc_s = 0.0;
  std::vector<std::pair<std::string, std::string>> closures;  ///< what stands for sky, sun, ground and air: name, words
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, double>> timing_ms;
};

/// Air, sky and sun of the weather at the picture's time, and the words for them; returns the temperature of the air,
/// K. Throws UsageError for times that the weather does not have, and for air in both files.
double add_surroundings(const SceneFile& file, const PictureOptions& options, PictureScene& picture);

/// The regions of the file that have no temperature, as words: 'a', 'b'; "" where all have.
std::string regions_to_solve(const SceneFile& file);

/// Temperatures by the heat balance, of all facets from the output at or before `from_s` to the one at or after `to_s`
/// (UTC); the run begins where [time] says, and ends there. Throws UsageError for times that [time] does not have, and
/// as run_heat.
TemperatureRows solved_rows(const SceneFile& file, double from_s, double to_s, const HeatOptions& options,
                            const HeatProgress& progress);

/// The pictures' scene at one time or another: meshes are read once.
class PictureSource {
 public:
  /// `rows`: temperatures in place of those that `options` name. Throws UsageError for regions without a temperature
  /// (by name), rows that are not of its facets, air in both files, and as read_meshes; RuntimeError for files that
  /// cannot be read.
  PictureSource(const SceneFile& file, PictureOptions options, std::optional<TemperatureRows> rows = std::nullopt);

  /// All of it at `utc_s`, or else at PictureOptions::utc_s, the last time of the temperatures, or the start of the
  /// file. Throws UsageError for times that temperatures and weather do not have.
  PictureScene at(std::optional<double> utc_s = std::nullopt) { return at(utc_s, options_); }
  /// The same with air and sensor_air of `air`. From several threads at once, as `temperatures`.
  PictureScene at(std::optional<double> utc_s, const PictureOptions& air);
  /// The temperatures alone, of scene::index(side); NaN for the inside of solids. Throws UsageError for a time that
  /// they do not have, and for facets without a temperature, with their regions.
  void temperatures(double utc_s, std::vector<float>& kelvin);
  bool temperatures_change() const;
  /// The first and the last time that is known; nothing where they hold at all times.
  std::optional<std::array<double, 2>> temperatures_span_utc_s() const;
  /// Throws UsageError for a time that the temperatures do not have.
  void require_temperatures_at(double utc_s) const;
  const radiometry::scene::Rays& rays() const { return *rays_; }

 private:
  SceneFile file_;
  PictureOptions options_;
  ThermalScene surfaces_;  ///< without weather, and with its facets in `rays_`
  std::shared_ptr<const radiometry::scene::Rays> rays_;
  bool of_regions_ = false;  ///< temperatures are those that the regions are given
  TemperatureRows rows_;     ///< else these; of files the values about the last time that was asked for
  std::vector<bool> solid_;  ///< of each facet: its back is the inside of a solid
  std::mutex reading_;       ///< of temperatures
  radiometry::render::RenderScene finishes_;  ///< and their sides
  std::vector<std::pair<std::string, double>> timing_ms_;
  std::optional<radiometry::heat::Schedule> ground_;  ///< solved, from the start of the run; once it is asked for

  std::vector<const TemperatureRows*> tables() const;
};

/// One picture: PictureSource(file, options).at().
PictureScene read_picture_scene(const SceneFile& file, const PictureOptions& options);

/// The same without facets, for pictures from layers: finishes of the materials in their order, and what is around
/// them. Temperatures are of no account.
PictureScene read_layer_scene(const SceneFile& file, const PictureOptions& options);

/// Adds to the warnings what the model of the air of the scene file is not good for in a band, as the weather has it,
/// and tables of emissivity that end inside the band.
void add_band_limits(const SceneFile& file, const radiometry::Interval& band, PictureScene& picture);

/// Throws UsageError where the camera is below the ground: it looks at the back of an open surface above it, and
/// nothing is below.
void require_above_ground(const PictureScene& picture, const radiometry::scene::Point& camera);

}  // namespace apps::scene
