// SPDX-License-Identifier: Apache-2.0
#pragma once

// The tables of a scene file as values, SI: where and when, the weather, the sky, what the surfaces are made of, the
// meshes and which of their faces have which material, the ground, the camera. README.md has the keys.
//
// fields() of a type is its table in the file, a row a key beside the member that holds its value (mtf::FieldInfo).
// The reader, the schema that editors have (`mtf config schema scene`) and the page's sliders go through these rows;
// what a key may be is told by the type of its member: a Schedule is a number or the name of a schedule.csv, an
// Emissivity a number or the name of a table. Numbers are in FieldInfo::unit ("W/m/K") and may stand in any other.

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "apps/scene/scene_file/camera_path.h"
#include "mtf/io/config/config.h"
#include "radiometry/fields.h"
#include "radiometry/light/angular_emissivity.h"
#include "radiometry/light/spectrum.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/value_schedule.h"
#include "radiometry/weather/weather.h"
#include "radiometry/weather/weather_series.h"

namespace apps::scene {

using mtf::Field;
using mtf::FieldInfo;
using mtf::FieldType;
using mtf::optional_row;
using radiometry::heat::WeatherQuantity;

/// A row of a number from lo to hi that need not be given; `unit` as of weather/si_units.h, "" for plain numbers.
constexpr FieldInfo number_row(std::string_view name, std::string_view unit, double lo, double hi,
                               std::string_view example, std::string_view doc) {
  return optional_row(name, mtf::Dimension::none, unit, lo, hi, example, doc);
}
/// A row of a text.
constexpr FieldInfo text_row(std::string_view name, std::string_view example, std::string_view doc) {
  return of_type(FieldType::text, optional_row(name, example, doc));
}
constexpr FieldInfo word_row(std::string_view name, std::span<const std::string_view> words) {
  return of_type(FieldType::word, optional_row(name, "", ""), words);
}
/// Temperatures of surfaces that are given.
inline constexpr FieldInfo kTemperature =
    above(number_row("temperature", "K", 0.0, 3000.0, "\"80 degC\"", "a constant, or the name of a schedule.csv"));
inline constexpr FieldInfo kSolarAbsorptance =
    number_row("solar_absorptance", "", 0.0, 1.0, "0.7", "share of the sunlight that is absorbed");
inline constexpr FieldInfo kEmissivity = number_row("emissivity", "", 0.0, 1.0, "0.9", "or the name of a table");

/// Whether the row counts in a table whose `kind` is that word.
bool counts_with(const FieldInfo& row, std::string_view kind);

/// [place], as written.
struct PlaceSection {
  double latitude_deg = 0.0, longitude_deg = 0.0, altitude_m = 0.0, north_deg = 0.0;

  static constexpr auto fields() {
    using P = PlaceSection;
    return std::tuple{
        Field{required(number_row("latitude", "deg", -90.0, 90.0, "\"37.70 deg\"", "north positive")),
              &P::latitude_deg},
        Field{required(number_row("longitude", "deg", -360.0, 360.0, "\"-105.92 deg\"", "east positive")),
              &P::longitude_deg},
        Field{required(number_row("altitude", "m", -500.0, 9000.0, "\"2317 m\"", "above the sea")), &P::altitude_m},
        Field{number_row("north", "deg", -360.0, 360.0, "\"0 deg\"", "azimuth of +y"), &P::north_deg}};
  }
};

/// [time]: UTC, seconds of radiometry/weather/instant.h.
struct TimeSection {
  double start_s = 0.0, end_s = 0.0;
  double step_s = 600.0;  ///< between outputs; a divisor of the span

  static constexpr auto fields() {
    constexpr auto date = [](std::string_view name, std::string_view example, std::string_view doc) {
      return of_type(FieldType::date, required(optional_row(name, example, doc)));
    };
    using T = TimeSection;
    return std::tuple{
        Field{date("start", "2016-01-01T00:00:00Z", "with its time zone, such as 2016-01-01T00:00:00Z"), &T::start_s},
        Field{date("end", "2016-01-02T00:00:00Z", "after the start"), &T::end_s},
        Field{number_row("step", "s", 0.1, radiometry::heat::kDay_s, "\"10 min\"", "between outputs"), &T::step_s}};
  }
};

/// What changes the records of a weather file: the same days, warmer or calmer. Each quantity by itself: vapour
/// pressure and the sky's long wave stay as they were recorded where the air gets warmer.
struct WeatherChange {
  double air_temperature_offset_k = 0.0;
  double wind_speed_factor = 1.0;
  double solar_factor = 1.0;  ///< of direct, diffuse and global irradiance
  double longwave_down_offset_w_m2 = 0.0;

  bool operator==(const WeatherChange&) const = default;
  static constexpr auto fields() {
    using W = WeatherChange;
    return std::tuple{
        Field{number_row("air_temperature_offset", "K", -60.0, 60.0, "\"5 K\"",
                         "added to the file's air temperature; vapour pressure and long wave stay"),
              &W::air_temperature_offset_k},
        Field{number_row("wind_speed_factor", "", 0.0, 20.0, "0.5", "times the file's wind speed"),
              &W::wind_speed_factor},
        Field{number_row("solar_factor", "", 0.0, 1.5, "0.3", "times the file's direct, diffuse and global irradiance"),
              &W::solar_factor},
        Field{number_row("longwave_down_offset", "W/m2", -300.0, 300.0, "\"20 W/m2\"",
                         "added to the file's long wave of the sky"),
              &W::longwave_down_offset_w_m2}};
  }
};

constexpr FieldInfo constant_row(WeatherQuantity quantity, std::string_view unit, double lo, double hi,
                                 std::string_view example) {
  return number_row(radiometry::heat::quantity_name(quantity), unit, lo, hi, example, "");
}
/// Constant values that [weather] may have in place of a file, in the order of WeatherQuantity.
inline constexpr std::array kConstants{
    constant_row(WeatherQuantity::air_temperature, "K", 178.15, 338.15, "\"15 degC\""),
    constant_row(WeatherQuantity::wind_speed, "m/s", 0.0, 120.0, "\"3 m/s\""),
    constant_row(WeatherQuantity::vapour_pressure, "Pa", 0.0, 12000.0, "\"8 hPa\""),
    constant_row(WeatherQuantity::pressure, "Pa", 20e3, 115e3, "\"1013 hPa\""),
    constant_row(WeatherQuantity::direct_normal, "W/m2", 0.0, 1500.0, "\"800 W/m2\""),
    constant_row(WeatherQuantity::diffuse_horizontal, "W/m2", 0.0, 1500.0, "\"100 W/m2\""),
    constant_row(WeatherQuantity::global_horizontal, "W/m2", 0.0, 1500.0, "\"600 W/m2\""),
    constant_row(WeatherQuantity::longwave_down, "W/m2", 30.0, 700.0, "\"300 W/m2\""),
    constant_row(WeatherQuantity::cloud_cover, "", 0.0, 1.0, "0.3"),
};
static_assert(kConstants.back().name ==
              radiometry::heat::quantity_name(static_cast<WeatherQuantity>(kConstants.size() - 1)));
inline constexpr FieldInfo kHumidity =
    excluding("vapour_pressure", number_row("relative_humidity", "", 0.0, 1.1, "\"50 %\"", ""));

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

  /// The other keys of the table are kHumidity, those of WeatherChange, and kConstants.
  static constexpr auto fields() {
    using radiometry::heat::kDay_s;
    using W = WeatherSection;
    return std::tuple{
        Field{optional_row("file", "\"weather.csv\"", "CSV, EPW, TMY3 or SURFRAD"), &W::file},
        Field{word_row("stamp", radiometry::heat::kStampNames), &W::stamp},
        Field{word_row("repeat", radiometry::heat::kRepeatNames), &W::repeat},
        Field{number_row("bridge", "s", 0.0, kDay_s, "\"1 h\"", "longest gap that a straight line closes"),
              &W::longest_bridge_s},
        Field{number_row("average", "s", 0.0, kDay_s, "\"5 min\"", "records become means over so long"),
              &W::average_s}};
  }
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

  /// `cloud` is a share, or one of its words.
  static constexpr auto fields() {
    FieldInfo cover = number_row("cloud", "", 0.0, 1.0, "0.3", "share of the sky");
    cover.words = std::span(kCloudNames).first(3);
    return std::tuple{Field{word_row("longwave", kLongwaveNames), &SkySection::longwave},
                      Field{cover, &SkySection::cloud}};
  }
};

/// A layer of a construction; layers go from the outside inwards.
struct LayerSection {
  double conductivity_w_m_k = 1.0;
  double density_kg_m3 = 1.0;
  double heat_capacity_j_kg_k = 1.0;
  double thickness_m = 1.0;
  radiometry::heat::Schedule source{};  ///< W/m3, heat that the layer generates; empty: none

  static constexpr auto fields() {
    constexpr auto row = [](std::string_view name, std::string_view unit, double hi, std::string_view example,
                            std::string_view doc) {
      return required(above(number_row(name, unit, 0.0, hi, example, doc)));
    };
    using L = LayerSection;
    return std::tuple{Field{row("conductivity", "W/m/K", 1e4, "\"45 W/m/K\"", "thermal"), &L::conductivity_w_m_k},
                      Field{row("density", "kg/m3", 3e4, "\"7800 kg/m3\"", "mass per volume"), &L::density_kg_m3},
                      Field{row("heat_capacity", "J/kg/K", 2e4, "\"480 J/kg/K\"", "per mass, at constant pressure"),
                            &L::heat_capacity_j_kg_k},
                      Field{row("thickness", "m", 100.0, "\"20 mm\"", "of the layer"), &L::thickness_m},
                      Field{number_row("source", "W/m3", -1e9, 1e9, "\"500 W/m3\"",
                                       "heat that the layer generates; a constant, or the name of a schedule.csv"),
                            &L::source}};
  }
};

/// Emissivity of a surface: the number that the balance takes, and the spectrum that it is the Planck mean of.
struct Emissivity {
  double value = 0.9;                              ///< at 300 K, to all sides
  std::optional<radiometry::Spectrum> spectrum{};  ///< samples, straight lines between them, held beyond both ends
  double along_normal = 0.9;  ///< where there is no spectrum; differs where it depends on the angle
};

enum class ConvectionModel {
  none,     ///< vacuum: h = 0
  mcadams,  ///< 5.7 + 3.8 v
  tarp,     ///< natural by inclination, and forced
  linear    ///< h0 + h1 v of the file
};
inline constexpr std::array<std::string_view, 3> kConvectionWords{"none", "mcadams", "tarp"};
/// One of the words, or the table of the linear one.
struct Convection {
  ConvectionModel model = ConvectionModel::mcadams;
  double h0_w_m2_k = 0.0, h1_j_m3_k = 0.0;  ///< linear: W/m2/K, and W/m2/K per m/s

  static constexpr auto fields() {
    return std::tuple{
        Field{required(number_row("h0", "W/m2/K", 0.0, 1e5, "\"5 W/m2/K\"", "without wind")), &Convection::h0_w_m2_k},
        Field{required(number_row("h1", "J/m3/K", 0.0, 1e5, "\"3.8 W/m2/K/(m/s)\"", "per wind speed")),
              &Convection::h1_j_m3_k}};
  }
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

  static constexpr auto fields() {
    using I = Inside;
    return std::tuple{Field{required(word_row("kind", kInsideNames)), &I::kind},
                      Field{of_kinds("film", required(number_row("h", "W/m2/K", 0.0, 1e5, "\"10 W/m2/K\"",
                                                                 "heat transfer coefficient"))),
                            &I::h_w_m2_k},
                      Field{of_kinds("fixed film", required(kTemperature)), &I::temperature},
                      Field{of_kinds("flux", required(number_row("flux", "W/m2", -1e6, 1e6, "\"200 W/m2\"",
                                                                 "into the inner surface; a constant, or the name of a "
                                                                 "schedule.csv"))),
                            &I::flux},
                      Field{of_kinds("sheet", kSolarAbsorptance), &I::back_solar_absorptance},
                      Field{of_kinds("sheet", kEmissivity), &I::back_emissivity},
                      Field{of_kinds("pair", above(number_row("thickness", "m", 0.0, 100.0, "\"50 mm\"",
                                                              "longest distance to the opposite face"))),
                            &I::thickness_m}};
  }
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
  /// What `by_angle` was made of; at most one of the three.
  std::optional<double> schlick_exponent{}, refractive_index{};
  std::string emissivity_angles{};  ///< path of a table
  double gloss = 0.0;               ///< share of the reflected light that a mirror would show, in pictures

  static constexpr auto fields() {
    using M = MaterialSection;
    return std::tuple{
        Field{required(text_row("name", "\"armour\"", "which regions refer to")), &M::name},
        Field{required(kSolarAbsorptance), &M::solar_absorptance},
        Field{required(kEmissivity), &M::emissivity},
        Field{number_row("wet_fraction", "", 0.0, 1.0, "0.2", "of the surface that evaporates"), &M::wet_fraction},
        Field{optional_row("convection", "\"mcadams\"", ""), &M::convection},
        Field{required(optional_row("layers", "", "")), &M::layers},
        Field{optional_row("inside", "{ kind = \"adiabatic\" }", ""), &M::inside},
        Field{number_row("gloss", "", 0.0, 1.0, "0.8", "share of the reflected light that a mirror would show"),
              &M::gloss},
        Field{excluding("refractive_index emissivity_angles",
                        number_row("schlick_exponent", "", 1.0, 100.0, "5",
                                   "emissivity by angle: 1 - (1 - cos)^exponent of that along the normal")),
              &M::schlick_exponent},
        Field{excluding("schlick_exponent emissivity_angles",
                        above(number_row("refractive_index", "", 1.0, 10.0, "1.5",
                                         "emissivity by angle: Fresnel's law for a dielectric"))),
              &M::refractive_index},
        Field{excluding("schlick_exponent refractive_index",
                        optional_row("emissivity_angles", "\"angles.csv\"", "table of angle_deg,relative")),
              &M::emissivity_angles}};
  }
};

struct MeshSection {
  std::string name;
  std::string file;     ///< path; "": one level square of 1 m, for a scene of [ground] alone
  double unit_m = 1.0;  ///< length of the file's unit
  mtf::io::Position file_at{};

  static constexpr auto fields() {
    using M = MeshSection;
    return std::tuple{Field{required(text_row("name", "\"vehicle\"", "which regions refer to")), &M::name},
                      Field{required(optional_row("file", "\"vehicle.obj\"", "OBJ, PLY, STL or glTF 2")), &M::file},
                      Field{number_row("unit", "m", 1e-6, 1e4, "\"1 mm\"", "of the file's numbers"), &M::unit_m}};
  }
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
  std::string group{}, mesh_material{};  ///< as the mesh file has them; both empty: every face that no other region has
  std::optional<std::size_t> material{};  ///< index into materials; absent: a black surface of that temperature
  std::optional<GivenTemperature> temperature{};

  static constexpr auto fields() {
    using R = RegionSection;
    return std::tuple{Field{text_row("name", "\"hull\"", ""), &R::name},
                      Field{required(text_row("mesh", "\"vehicle\"", "")), &R::mesh},
                      Field{text_row("group", "\"hull\"", ""), &R::group},
                      Field{text_row("mesh_material", "\"steel\"", ""), &R::mesh_material},
                      Field{text_row("material", "\"armour\"", ""), &R::material},
                      Field{kTemperature, &R::temperature}};
  }
};

/// What rays see that leave the scene below the horizon.
struct GroundSection {
  std::optional<std::size_t> material{};          ///< index into materials: solved as one open class
  std::optional<GivenTemperature> temperature{};  ///< instead of solving

  static constexpr auto fields() {
    return std::tuple{Field{text_row("material", "\"soil\"", ""), &GroundSection::material},
                      Field{kTemperature, &GroundSection::temperature}};
  }
};

/// [measured]: what the ground is known to have been, for a fit. Absent: the weather's long wave from the ground.
struct MeasuredSection {
  radiometry::heat::Schedule temperature{};  ///< K; empty: from the weather
  std::optional<double> sd_k{};              ///< of a value, independent of the others

  static constexpr auto fields() {
    FieldInfo day = of_type(FieldType::file, kTemperature);
    day.example = "\"surface.csv\"";
    day.doc = "a table of times";
    return std::tuple{
        Field{day, &MeasuredSection::temperature},
        Field{above(number_row("sd", "K", 0.0, 100.0, "\"0.3 K\"", "of a value")), &MeasuredSection::sd_k}};
  }
};

struct CameraSection {
  std::array<double, 3> position_m{}, look_at_m{}, up{0.0, 0.0, 1.0};
  std::optional<CameraPath> path{};  ///< position_m and look_at_m are where it begins

  static constexpr auto fields() {
    constexpr std::string_view point = "[\"14 m\", \"-12 m\", \"5 m\"]";
    using C = CameraSection;
    return std::tuple{Field{excluding("path", optional_row("position", point, "of the camera")), &C::position_m},
                      Field{excluding("path", optional_row("look_at", point, "what it looks at")), &C::look_at_m},
                      Field{optional_row("up", "[\"0 m\", \"0 m\", \"1 m\"]", "what is up in the image"), &C::up},
                      Field{excluding("position look_at",
                                      optional_row("path", "\"path.csv\"", "CSV of both over time, in place of them")),
                            &C::path}};
  }
};

}  // namespace apps::scene
