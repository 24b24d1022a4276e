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

#include "mtf/io/config/config.h"
#include "radiometry/fields.h"
#include "radiometry/light/angular_emissivity.h"
#include "radiometry/light/spectrum.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/weather.h"
#include "radiometry/weather/weather_series.h"

namespace apps::scene {

using mtf::Field;
using mtf::FieldInfo;
using mtf::FieldType;
using mtf::optional;
using mtf::optional_row;
using mtf::required;
using radiometry::heat::WeatherQuantity;

/// A row of a number from lo to hi that need not be given; `unit` as of weather/si_units.h, "" for plain numbers.
constexpr FieldInfo number_row(std::string_view name, std::string_view unit, double lo, double hi,
                               std::string_view example, std::string_view doc) {
  return optional_row(name, mtf::Dimension::none, unit, lo, hi, example, doc);
}
/// Rows of a member, as mtf::required and mtf::optional make them: a number in such a unit, a text, one of the words.
template <class Member, class... Cells>
constexpr auto number(Member member, const Cells&... cells) {
  return Field{member, number_row(cells...)};
}
template <class Member>
constexpr auto text(Member member, std::string_view name, std::string_view example, std::string_view doc) {
  return of_type(FieldType::text, optional(member, name, example, doc));
}
template <class Member>
constexpr auto word(Member member, std::string_view name, std::span<const std::string_view> words) {
  return of_type(FieldType::word, optional(member, name, "", ""), words);
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
        required(number(&P::latitude_deg, "latitude", "deg", -90.0, 90.0, "\"37.70 deg\"", "north positive")),
        required(number(&P::longitude_deg, "longitude", "deg", -360.0, 360.0, "\"-105.92 deg\"", "east positive")),
        required(number(&P::altitude_m, "altitude", "m", -500.0, 9000.0, "\"2317 m\"", "above the sea")),
        number(&P::north_deg, "north", "deg", -360.0, 360.0, "\"0 deg\"", "azimuth of +y")};
  }
};

/// [time]: UTC, seconds of radiometry/weather/instant.h.
struct TimeSection {
  double start_s = 0.0, end_s = 0.0;
  double step_s = 600.0;  ///< between outputs; a divisor of the span

  static constexpr auto fields() {
    constexpr auto date = [](auto member, const auto&... cells) {
      return of_type(FieldType::date, required(member, cells...));
    };
    using T = TimeSection;
    return std::tuple{
        date(&T::start_s, "start", "2016-01-01T00:00:00Z", "with its time zone, such as 2016-01-01T00:00:00Z"),
        date(&T::end_s, "end", "2016-01-02T00:00:00Z", "after the start"),
        number(&T::step_s, "step", "s", 0.1, radiometry::heat::kDay_s, "\"10 min\"", "between outputs")};
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
        number(&W::air_temperature_offset_k, "air_temperature_offset", "K", -60.0, 60.0, "\"5 K\"",
               "added to the file's air temperature; vapour pressure and long wave stay"),
        number(&W::wind_speed_factor, "wind_speed_factor", "", 0.0, 20.0, "0.5", "times the file's wind speed"),
        number(&W::solar_factor, "solar_factor", "", 0.0, 1.5, "0.3",
               "times the file's direct, diffuse and global irradiance"),
        number(&W::longwave_down_offset_w_m2, "longwave_down_offset", "W/m2", -300.0, 300.0, "\"20 W/m2\"",
               "added to the file's long wave of the sky")};
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
        optional(&W::file, "file", "\"weather.csv\"", "CSV, EPW, TMY2, TMY3, SAM CSV (NSRDB), SURFRAD or PVGIS TMY"),
        word(&W::stamp, "stamp", radiometry::heat::kStampNames),
        word(&W::repeat, "repeat", radiometry::heat::kRepeatNames),
        number(&W::longest_bridge_s, "bridge", "s", 0.0, kDay_s, "\"1 h\"", "longest gap that a straight line closes"),
        number(&W::average_s, "average", "s", 0.0, kDay_s, "\"5 min\"", "records become means over so long")};
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
    return std::tuple{word(&SkySection::longwave, "longwave", kLongwaveNames), Field{&SkySection::cloud, cover}};
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
    constexpr auto row = [](auto member, std::string_view name, std::string_view unit, double hi,
                            const auto&... cells) {
      return required(above(number(member, name, unit, 0.0, hi, cells...)));
    };
    using L = LayerSection;
    return std::tuple{row(&L::conductivity_w_m_k, "conductivity", "W/m/K", 1e4, "\"45 W/m/K\"", "thermal"),
                      row(&L::density_kg_m3, "density", "kg/m3", 3e4, "\"7800 kg/m3\"", "mass per volume"),
                      row(&L::heat_capacity_j_kg_k, "heat_capacity", "J/kg/K", 2e4, "\"480 J/kg/K\"",
                          "per mass, at constant pressure"),
                      row(&L::thickness_m, "thickness", "m", 100.0, "\"20 mm\"", "of the layer"),
                      number(&L::source, "source", "W/m3", -1e9, 1e9, "\"500 W/m3\"",
                             "heat that the layer generates; a constant, or the name of a schedule.csv")};
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
        required(number(&Convection::h0_w_m2_k, "h0", "W/m2/K", 0.0, 1e5, "\"5 W/m2/K\"", "without wind")),
        required(number(&Convection::h1_j_m3_k, "h1", "J/m3/K", 0.0, 1e5, "\"3.8 W/m2/K/(m/s)\"", "per wind speed"))};
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
    return std::tuple{required(word(&I::kind, "kind", kInsideNames)),
                      of_kinds("film", required(number(&I::h_w_m2_k, "h", "W/m2/K", 0.0, 1e5, "\"10 W/m2/K\"",
                                                       "heat transfer coefficient"))),
                      Field{&I::temperature, of_kinds("fixed film", required(kTemperature))},
                      of_kinds("flux", required(number(&I::flux, "flux", "W/m2", -1e6, 1e6, "\"200 W/m2\"",
                                                       "into the inner surface; a constant, or the name of a "
                                                       "schedule.csv"))),
                      Field{&I::back_solar_absorptance, of_kinds("sheet", kSolarAbsorptance)},
                      Field{&I::back_emissivity, of_kinds("sheet", kEmissivity)},
                      of_kinds("pair", above(number(&I::thickness_m, "thickness", "m", 0.0, 100.0, "\"50 mm\"",
                                                    "longest distance to the opposite face")))};
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
        required(text(&M::name, "name", "\"armour\"", "which regions refer to")),
        Field{&M::solar_absorptance, required(kSolarAbsorptance)},
        Field{&M::emissivity, required(kEmissivity)},
        number(&M::wet_fraction, "wet_fraction", "", 0.0, 1.0, "0.2", "of the surface that evaporates"),
        optional(&M::convection, "convection", "\"mcadams\"", ""),
        required(&M::layers, "layers", "", ""),
        optional(&M::inside, "inside", "{ kind = \"adiabatic\" }", ""),
        number(&M::gloss, "gloss", "", 0.0, 1.0, "0.8", "share of the reflected light that a mirror would show"),
        excluding("refractive_index emissivity_angles",
                  number(&M::schlick_exponent, "schlick_exponent", "", 1.0, 100.0, "5",
                         "emissivity by angle: 1 - (1 - cos)^exponent of that along the normal")),
        excluding("schlick_exponent emissivity_angles",
                  above(number(&M::refractive_index, "refractive_index", "", 1.0, 10.0, "1.5",
                               "emissivity by angle: Fresnel's law for a dielectric"))),
        excluding("schlick_exponent refractive_index", optional(&M::emissivity_angles, "emissivity_angles",
                                                                "\"angles.csv\"", "table of angle_deg,relative"))};
  }
};

struct MeshSection {
  std::string name;
  std::string file;     ///< path; "": one level square of 1 m, for a scene of [ground] alone
  double unit_m = 1.0;  ///< length of the file's unit
  mtf::io::Position file_at{};

  static constexpr auto fields() {
    using M = MeshSection;
    return std::tuple{required(text(&M::name, "name", "\"vehicle\"", "which regions refer to")),
                      required(&M::file, "file", "\"vehicle.obj\"", "OBJ, PLY, STL or glTF 2"),
                      number(&M::unit_m, "unit", "m", 1e-6, 1e4, "\"1 mm\"", "of the file's numbers")};
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
    return std::tuple{
        text(&R::name, "name", "\"hull\"", ""),           required(text(&R::mesh, "mesh", "\"vehicle\"", "")),
        text(&R::group, "group", "\"hull\"", ""),         text(&R::mesh_material, "mesh_material", "\"steel\"", ""),
        text(&R::material, "material", "\"armour\"", ""), Field{&R::temperature, kTemperature}};
  }
};

/// What rays see that leave the scene below the horizon.
struct GroundSection {
  std::optional<std::size_t> material{};          ///< index into materials: solved as one open class
  std::optional<GivenTemperature> temperature{};  ///< instead of solving

  static constexpr auto fields() {
    using G = GroundSection;
    return std::tuple{text(&G::material, "material", "\"soil\"", ""), Field{&G::temperature, kTemperature}};
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
    return std::tuple{Field{&MeasuredSection::temperature, day},
                      above(number(&MeasuredSection::sd_k, "sd", "K", 0.0, 100.0, "\"0.3 K\"", "of a value"))};
  }
};

// Where a camera is over time, from a CSV file:
//   time (s),x (m),y (m),z (m),look_x (m),look_y (m),look_z (m)
//   0,200,-150,60,0,0,1
//   20,60,-40,25,0,0,1
// `time` counts from the first frame; x, y and z are the position, look_x, look_y and look_z what the camera looks at.
// Between lines both go along straight lines. Lengths in any unit; comments, separators and times as in weather files
// (weather_file.h).

struct CameraPlace {
  std::array<double, 3> position_m{}, look_at_m{};
};

struct CameraPath {
  std::string source;
  std::vector<double> time_s;  ///< rising, from the first frame
  std::vector<CameraPlace> place;

  /// Throws UsageError for a time that the path does not have.
  CameraPlace at(double time_s) const;
};

/// Throws RuntimeError where the file cannot be read, UsageError "file:line: error: ..." for a wrong or missing column,
/// times that do not rise or are instants, a camera that looks at itself or jumps (above 3000 m/s).
CameraPath read_camera_path(const std::string& path);
CameraPath parse_camera_path(std::string_view text, const std::string& source);

struct CameraSection {
  std::array<double, 3> position_m{}, look_at_m{}, up{0.0, 0.0, 1.0};
  std::optional<CameraPath> path{};  ///< position_m and look_at_m are where it begins

  static constexpr auto fields() {
    constexpr std::string_view point = "[\"14 m\", \"-12 m\", \"5 m\"]";
    using C = CameraSection;
    return std::tuple{excluding("path", optional(&C::position_m, "position", point, "of the camera")),
                      excluding("path", optional(&C::look_at_m, "look_at", point, "what it looks at")),
                      optional(&C::up, "up", "[\"0 m\", \"0 m\", \"1 m\"]", "what is up in the image"),
                      excluding("position look_at",
                                optional(&C::path, "path", "\"path.csv\"", "CSV of both over time, in place of them"))};
  }
};

}  // namespace apps::scene
