// SPDX-License-Identifier: Apache-2.0
#pragma once

// A scene file (TOML) as a struct of values, SI: where and when, the weather, the sky, what the surfaces are made of,
// the meshes and which of their faces have which material, the ground, the camera. README.md has the keys. Reading
// checks everything that stands in the file itself: all errors at once with file:line:column, units, ranges, names that
// are used and not defined. Weather and mesh files are named here and read by others; small tables that are part of a
// value (emissivities, schedules) are read with the file.

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "apps/scene/scene_file/camera_path.h"
#include "apps/scene/scene_file/clear_sky_flux.h"
#include "apps/scene/weather/weather_file.h"
#include "mtf/io/config/config.h"
#include "radiometry/light/angular_emissivity.h"
#include "radiometry/light/spectrum.h"
#include "radiometry/weather/schedule.h"
#include "radiometry/weather/sky.h"
#include "radiometry/weather/sun.h"
#include "radiometry/weather/weather.h"
#include "radiometry/weather/weather_series.h"

namespace apps::scene {

/// [time]: UTC, seconds of radiometry/weather/instant.h.
struct TimeSection {
  double start_s = 0.0, end_s = 0.0;
  double step_s = 600.0;  ///< between outputs; a divisor of the span
};

/// What changes the records of a weather file: the same days, warmer or calmer. Each quantity by itself: vapour
/// pressure and the sky's long wave stay as they were recorded where the air gets warmer.
struct WeatherChange {
  double air_temperature_offset_k = 0.0;
  double wind_speed_factor = 1.0;
  double solar_factor = 1.0;  ///< of direct, diffuse and global irradiance
  double longwave_down_offset_w_m2 = 0.0;

  bool operator==(const WeatherChange&) const = default;
};

/// [weather]: a file, or constant values as one record.
struct WeatherSection {
  std::string file;                              ///< path, "" for constant values
  mtf::io::Position file_at{};                   ///< of its name, for messages
  radiometry::heat::Weather constant;            ///< one record at the start; empty where a file is named
  std::optional<radiometry::heat::Stamp> stamp;  ///< absent where the file does not say
  radiometry::heat::Repeat repeat = radiometry::heat::Repeat::none;
  double longest_bridge_s = 3600.0;  ///< longest gap that a straight line closes
  double average_s = 0.0;            ///< records become means over intervals of this length; 0: they stay
  WeatherChange change{};            ///< of a file's records
};

enum class LongwaveModel { measured, brunt, brutsaert, swinbank, atmosphere };
inline constexpr std::array<std::string_view, 5> kLongwaveNames{"measured", "brunt", "brutsaert", "swinbank",
                                                                "atmosphere"};

/// Where the cloud cover comes from: none (clear), the weather's measured long-wave against the formula, the weather's
/// own column, or a constant.
enum class CloudSource { none, from_longwave, from_weather, constant };
inline constexpr std::array<std::string_view, 4> kCloudNames{"none", "from_longwave", "from_weather", "constant"};

struct SkySection {
  LongwaveModel longwave = LongwaveModel::measured;
  CloudSource cloud = CloudSource::none;
  double cloud_cover = 0.0;  ///< of CloudSource::constant
};

/// A layer of a construction; layers go from the outside inwards.
struct LayerSection {
  double conductivity_w_m_k = 0.0;
  double density_kg_m3 = 0.0;
  double heat_capacity_j_kg_k = 0.0;
  double thickness_m = 0.0;
  radiometry::heat::Schedule source{};  ///< W/m3, heat that the layer generates; empty: none
};

/// Emissivity of a surface: the number that the balance takes, and the spectrum that it is the Planck mean of.
struct Emissivity {
  double value = 0.9;                              ///< at 300 K, to all sides
  std::optional<radiometry::Spectrum> spectrum{};  ///< samples, straight lines between them, held beyond both ends
  double along_normal = 0.9;  ///< where there is no spectrum; differs where it depends on the angle
};
/// Mean of the spectrum weighted by the blackbody of that temperature: integral of e B / integral of B.
double planck_mean(const radiometry::Spectrum& emissivity, double temperature_k);

enum class ConvectionModel {
  none,     ///< vacuum: h = 0
  mcadams,  ///< 5.7 + 3.8 v
  tarp,     ///< natural by inclination, and forced
  linear    ///< h0 + h1 v of the file
};
struct Convection {
  ConvectionModel model = ConvectionModel::mcadams;
  double h0_w_m2_k = 0.0, h1_j_m3_k = 0.0;  ///< linear: W/m2/K, and W/m2/K per m/s
};

enum class InsideKind {
  adiabatic,  ///< no heat passes
  fixed,      ///< the innermost node has a temperature
  film,       ///< h (T - T_inside)
  flux,       ///< a flux into the inner surface, W/m2
  sheet,      ///< the back is exposed as the front is
  pair        ///< the opposite face of a closed shell, found by a ray within `thickness`
};
inline constexpr std::array<std::string_view, 6> kInsideNames{"adiabatic", "fixed", "film", "flux", "sheet", "pair"};
struct Inside {
  InsideKind kind = InsideKind::adiabatic;
  double h_w_m2_k = 0.0;                           ///< film
  radiometry::heat::Schedule temperature{};        ///< K: fixed, film; empty otherwise
  radiometry::heat::Schedule flux{};               ///< W/m2: flux; empty otherwise
  std::optional<double> thickness_m{};             ///< pair: longest ray
  std::optional<double> back_solar_absorptance{};  ///< sheet: as the front where absent
  std::optional<Emissivity> back_emissivity{};     ///< sheet: as the front where absent
};

struct MaterialSection {
  std::string name;
  double solar_absorptance = 0.0;
  Emissivity emissivity;
  Convection convection;
  std::vector<LayerSection> layers;  ///< at least one
  Inside inside;
  double wet_fraction = 0.0;  ///< of the surface that evaporates, 0 to 1
  /// Emissivity by angle, relative to that along the normal; empty: the same at all angles.
  radiometry::AngularEmissivity by_angle{};
  double gloss = 0.0;  ///< share of the reflected light that a mirror would show, in pictures
};

struct MeshSection {
  std::string name;
  std::string file;     ///< path; "": one level square of 1 m, for a scene of [ground] alone
  double unit_m = 1.0;  ///< length of the file's unit
  mtf::io::Position file_at{};
};

/// Temperatures given instead of solved: a constant or a schedule, or the path of a facet table.
struct GivenTemperature {
  radiometry::heat::Schedule schedule{};  ///< K; empty where `table` is named
  std::string table;                      ///< path of an NPY or CSV of facets, as `mtf heat` writes them
};

/// Faces of a mesh: all of them, or those of a group or of a material of the mesh file.
struct RegionSection {
  std::string name;      ///< the file's `name`, else the group, else the mesh file's material, else the mesh
  std::size_t mesh = 0;  ///< index into meshes
  std::string group, mesh_material;  ///< as the mesh file has them; both empty: every face that no other region has
  std::optional<std::size_t> material{};  ///< index into materials; absent: a black surface of that temperature
  std::optional<GivenTemperature> temperature{};
};

/// What rays see that leave the scene below the horizon.
struct GroundSection {
  std::optional<std::size_t> material{};          ///< index into materials: solved as one open class
  std::optional<GivenTemperature> temperature{};  ///< instead of solving
};

/// [measured]: what the ground is known to have been, for a fit. Absent: the weather's long wave from the ground.
struct MeasuredSection {
  radiometry::heat::Schedule temperature{};  ///< K; empty: from the weather
  std::optional<double> sd_k{};              ///< of a value, independent of the others
};

struct CameraSection {
  std::array<double, 3> position_m{}, look_at_m{}, up{0.0, 0.0, 1.0};
  std::optional<CameraPath> path{};  ///< position_m and look_at_m are where it begins
};

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

/// The schedules that are in the file, of insides, regions and the ground: those of temperatures (K), and all of them.
std::vector<const radiometry::heat::Schedule*> temperature_schedules(const SceneFile& scene);
std::vector<const radiometry::heat::Schedule*> all_schedules(const SceneFile& scene);

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
