// SPDX-License-Identifier: Apache-2.0
#pragma once

// A scene file (TOML) as a struct of values, SI (scene_sections.h). Reading checks everything that stands in the file
// itself: all errors at once with file:line:column, units, ranges, names that are used and not defined. Weather and
// mesh files are named here and read by others; small tables that are part of a value (emissivities, schedules) are
// read with the file.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/scene/scene_file/clear_sky_flux.h"
#include "apps/scene/scene_file/scene_sections.h"
#include "apps/scene/weather/weather_file.h"
#include "mtf/io/config/config.h"
#include "radiometry/weather/sky.h"
#include "radiometry/weather/sun.h"
#include "radiometry/weather/weather_series.h"

namespace apps::scene {

/// The tables of a scene file.
inline constexpr std::array<std::string_view, 12> kTables{"schema", "place",      "time",     "weather",
                                                          "sky",    "atmosphere", "material", "mesh",
                                                          "region", "ground",     "measured", "camera"};

/// Mean of the spectrum weighted by the blackbody of that temperature: integral of e B / integral of B.
double planck_mean(const radiometry::Spectrum& emissivity, double temperature_k);

struct SceneFile {
  std::string file;    ///< as given by the user
  std::string text;    ///< the whole source
  std::string sha256;  ///< of the source, 64 hex digits
  radiometry::heat::Place place;
  double north_rad = 0.0;  ///< azimuth of +y, from north, clockwise
  TimeSection time;
  WeatherSection weather;
  SkySection sky;
  std::optional<radiometry::AtmosphereSettings> atmosphere;
  std::vector<MaterialSection> materials;
  std::vector<MeshSection> meshes;
  std::vector<RegionSection> regions;
  std::optional<GroundSection> ground;
  std::optional<MeasuredSection> measured;
  std::optional<CameraSection> camera;
  /// Numbers that stand as tables { value, fit, min, max, prior, stderr }, in the unit that the value was written in
  /// (spreads of degC in K). Where the file gives no min and max, they are those of the key.
  std::vector<mtf::io::FitSpec> fits;
  std::vector<std::string> files{};  ///< that the text names, beside `file`
};

/// All files that a scene is made of: its own, those it names, and the buffers of .gltf meshes.
std::vector<std::string> files_of(const SceneFile& scene);

/// The text of the scene with new values of its fits and the standard errors that `fits` hold; all else as written.
std::string scene_text_with(const SceneFile& scene, std::span<const mtf::io::FitSpec> fits,
                            std::span<const std::optional<double>> values);

struct SceneResult {
  SceneFile scene;                               ///< usable only when there is no error
  std::vector<mtf::io::Diagnostic> diagnostics;  ///< sorted by position: all errors of the file, then warnings
  bool ok() const;
};

/// Reads and checks; never throws for what is in the text. Names of files are relative to the folder of `file`.
SceneResult parse_scene(const std::string& text, const std::string& file);

/// Throws RuntimeError when the file cannot be read, UsageError with every error as "file:line:col: error: ..." lines
/// when it is wrong. Warnings go to `warnings` when given.
SceneFile load_scene(const std::string& file, std::vector<mtf::io::Diagnostic>* warnings = nullptr);

/// Throws RuntimeError with a line "file:line:col: error: ..." for each weather and mesh file that is not there.
void require_files(const SceneFile& scene);

/// The weather of a scene, ready for use: the file read, or the constant values, checked and prepared with the scene's
/// place, stamp, repeat and start. Warnings are in the series. Throws as read_weather and make_series.
radiometry::heat::WeatherSeries scene_weather(const SceneFile& scene);
/// The records that it is made of, averaged and changed as [weather] asks; of a scene whose weather is a file.
WeatherFile scene_weather_records(const SceneFile& scene);

/// Long-wave irradiance of a horizontal plane by the sky as [sky] has it, W/m2, with the cloud cover that it was made
/// with. `air`: of LongwaveModel::atmosphere. Throws UsageError where a column is missing.
struct SkyLongwave {
  double irradiance_w_m2 = 0.0;
  double cloud_cover = 0.0;
};
SkyLongwave sky_longwave(const SkySection& sky, const radiometry::heat::WeatherAt& weather,
                         ClearSkyFlux* air = nullptr);
/// The model of the clear sky that [sky] asks for; nothing where it asks for none.
std::optional<ClearSkyFlux> clear_sky_of(const SceneFile& scene);

}  // namespace apps::scene
