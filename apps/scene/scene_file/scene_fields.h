// SPDX-License-Identifier: Apache-2.0
#pragma once

// The keys of scene files, with the unit, the range and an example of each number: what reads them and what describes
// them to others (`mtf config schema scene`) take them from here.

#include <array>
#include <string_view>
#include <vector>

#include "apps/scene/scene_file/scene_file.h"
#include "mtf/component.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {

using mtf::FieldInfo;
using mtf::Presence;
using radiometry::heat::WeatherQuantity;

inline constexpr std::array<std::string_view, 12> kTables{"schema", "place",      "time",     "weather",
                                                          "sky",    "atmosphere", "material", "mesh",
                                                          "region", "ground",     "measured", "camera"};

// [place]
inline constexpr std::array<std::string_view, 4> kPlaceKeys{"latitude", "longitude", "altitude", "north"};
inline constexpr FieldInfo kLatitude{
    .name = "latitude", .unit = "deg", .lo = -90.0, .hi = 90.0, .example = "\"37.70 deg\"", .doc = "north positive"};
inline constexpr FieldInfo kLongitude{.name = "longitude",
                                      .unit = "deg",
                                      .lo = -360.0,
                                      .hi = 360.0,
                                      .example = "\"-105.92 deg\"",
                                      .doc = "east positive"};
inline constexpr FieldInfo kNorth{.name = "north",
                                  .unit = "deg",
                                  .lo = -360.0,
                                  .hi = 360.0,
                                  .presence = Presence::optional,
                                  .example = "\"0 deg\"",
                                  .doc = "azimuth of +y"};
inline constexpr FieldInfo kAltitude{
    .name = "altitude", .unit = "m", .lo = -500.0, .hi = 9000.0, .example = "\"2317 m\"", .doc = "above the sea"};

// [time]
inline constexpr std::array<std::string_view, 3> kTimeKeys{"start", "end", "step"};
inline constexpr FieldInfo kStep{.name = "step",
                                 .unit = "s",
                                 .lo = 0.1,
                                 .hi = radiometry::heat::kDay_s,
                                 .presence = Presence::optional,
                                 .example = "\"10 min\"",
                                 .doc = "between outputs"};

// [weather]: these, and a file or constant values in the order of WeatherQuantity
inline constexpr std::array<std::string_view, 5> kWeatherKeys{"file", "stamp", "repeat", "bridge", "average"};
inline constexpr FieldInfo kBridge{.name = "bridge",
                                   .unit = "s",
                                   .lo = 0.0,
                                   .hi = radiometry::heat::kDay_s,
                                   .presence = Presence::optional,
                                   .example = "\"1 h\"",
                                   .doc = "longest gap that a straight line closes"};
inline constexpr FieldInfo kAverage{.name = "average",
                                    .unit = "s",
                                    .lo = 0.0,
                                    .hi = radiometry::heat::kDay_s,
                                    .presence = Presence::optional,
                                    .example = "\"5 min\"",
                                    .doc = "records become means over so long"};
/// Changes of a file's records (WeatherChange).
inline constexpr std::array kWeatherChanges{
    FieldInfo{.name = "air_temperature_offset",
              .unit = "K",
              .lo = -60.0,
              .hi = 60.0,
              .presence = Presence::optional,
              .example = "\"5 K\"",
              .doc = "added to the file's air temperature; vapour pressure and long wave stay"},
    FieldInfo{.name = "wind_speed_factor",
              .lo = 0.0,
              .hi = 20.0,
              .presence = Presence::optional,
              .example = "0.5",
              .doc = "times the file's wind speed"},
    FieldInfo{.name = "solar_factor",
              .lo = 0.0,
              .hi = 1.5,
              .presence = Presence::optional,
              .example = "0.3",
              .doc = "times the file's direct, diffuse and global irradiance"},
    FieldInfo{.name = "longwave_down_offset",
              .unit = "W/m2",
              .lo = -300.0,
              .hi = 300.0,
              .presence = Presence::optional,
              .example = "\"20 W/m2\"",
              .doc = "added to the file's long wave of the sky"}};
constexpr FieldInfo constant_field(WeatherQuantity quantity, std::string_view unit, double lo, double hi,
                                   std::string_view example) {
  return {.name = radiometry::heat::quantity_name(quantity),
          .unit = unit,
          .lo = lo,
          .hi = hi,
          .presence = Presence::optional,
          .example = example};
}

/// Constant values that [weather] may have, in the order of WeatherQuantity.
inline constexpr std::array kConstants{
    constant_field(WeatherQuantity::air_temperature, "K", 178.15, 338.15, "\"15 degC\""),
    constant_field(WeatherQuantity::wind_speed, "m/s", 0.0, 120.0, "\"3 m/s\""),
    constant_field(WeatherQuantity::vapour_pressure, "Pa", 0.0, 12000.0, "\"8 hPa\""),
    constant_field(WeatherQuantity::pressure, "Pa", 20e3, 115e3, "\"1013 hPa\""),
    constant_field(WeatherQuantity::direct_normal, "W/m2", 0.0, 1500.0, "\"800 W/m2\""),
    constant_field(WeatherQuantity::diffuse_horizontal, "W/m2", 0.0, 1500.0, "\"100 W/m2\""),
    constant_field(WeatherQuantity::global_horizontal, "W/m2", 0.0, 1500.0, "\"600 W/m2\""),
    constant_field(WeatherQuantity::longwave_down, "W/m2", 30.0, 700.0, "\"300 W/m2\""),
    constant_field(WeatherQuantity::cloud_cover, "", 0.0, 1.0, "0.3"),
};
static_assert(kConstants.back().name ==
              radiometry::heat::quantity_name(static_cast<WeatherQuantity>(kConstants.size() - 1)));
inline constexpr FieldInfo kHumidity{
    .name = "relative_humidity", .lo = 0.0, .hi = 1.1, .presence = Presence::optional, .example = "\"50 %\""};

// [sky]
inline constexpr std::array<std::string_view, 2> kSkyKeys{"longwave", "cloud"};
inline constexpr std::array<std::string_view, 3> kCloudWords{kCloudNames[0], kCloudNames[1],
                                                             kCloudNames[2]};  // or a share
inline constexpr FieldInfo kCloud{.name = "cloud", .lo = 0.0, .hi = 1.0, .example = "0.3", .doc = "share of the sky"};

// [[material]]
inline constexpr std::array<std::string_view, 11> kMaterialKeys{
    "name",  "solar_absorptance", "emissivity",       "convection",       "layers", "inside", "wet_fraction",
    "gloss", "schlick_exponent",  "refractive_index", "emissivity_angles"};
inline constexpr std::array<std::string_view, 5> kLayerKeys{"conductivity", "density", "heat_capacity", "thickness",
                                                            "source"};
inline constexpr std::array<std::string_view, 3> kConvectionWords{"none", "mcadams", "tarp"};
inline constexpr FieldInfo kFilmStill{
    .name = "h0", .unit = "W/m2/K", .lo = 0.0, .hi = 1e5, .example = "\"5 W/m2/K\"", .doc = "without wind"};
inline constexpr FieldInfo kFilmWind{
    .name = "h1", .unit = "J/m3/K", .lo = 0.0, .hi = 1e5, .example = "\"3.8 W/m2/K/(m/s)\"", .doc = "per wind speed"};
inline constexpr FieldInfo kConductivity{.name = "conductivity",
                                         .unit = "W/m/K",
                                         .lo = 0.0,
                                         .hi = 1e4,
                                         .lo_open = true,
                                         .example = "\"45 W/m/K\"",
                                         .doc = "thermal"};
inline constexpr FieldInfo kDensity{.name = "density",
                                    .unit = "kg/m3",
                                    .lo = 0.0,
                                    .hi = 3e4,
                                    .lo_open = true,
                                    .example = "\"7800 kg/m3\"",
                                    .doc = "mass per volume"};
inline constexpr FieldInfo kHeatCapacity{.name = "heat_capacity",
                                         .unit = "J/kg/K",
                                         .lo = 0.0,
                                         .hi = 2e4,
                                         .lo_open = true,
                                         .example = "\"480 J/kg/K\"",
                                         .doc = "per mass, at constant pressure"};
inline constexpr FieldInfo kThickness{.name = "thickness",
                                      .unit = "m",
                                      .lo = 0.0,
                                      .hi = 100.0,
                                      .lo_open = true,
                                      .example = "\"20 mm\"",
                                      .doc = "of the layer"};
inline constexpr FieldInfo kSource{.name = "source",
                                   .unit = "W/m3",
                                   .lo = -1e9,
                                   .hi = 1e9,
                                   .presence = Presence::optional,
                                   .example = "\"500 W/m3\"",
                                   .doc = "heat that the layer generates; a constant, or the name of a schedule.csv"};
inline constexpr FieldInfo kSolarAbsorptance{.name = "solar_absorptance",
                                             .lo = 0.0,
                                             .hi = 1.0,
                                             .example = "0.7",
                                             .doc = "share of the sunlight that is absorbed"};
inline constexpr FieldInfo kEmissivity{
    .name = "emissivity", .lo = 0.0, .hi = 1.0, .example = "0.9", .doc = "or the name of a table"};
inline constexpr FieldInfo kWetFraction{.name = "wet_fraction",
                                        .lo = 0.0,
                                        .hi = 1.0,
                                        .presence = Presence::optional,
                                        .example = "0.2",
                                        .doc = "of the surface that evaporates"};
inline constexpr FieldInfo kGloss{.name = "gloss",
                                  .lo = 0.0,
                                  .hi = 1.0,
                                  .presence = Presence::optional,
                                  .example = "0.8",
                                  .doc = "share of the reflected light that a mirror would show"};
inline constexpr FieldInfo kSchlick{.name = "schlick_exponent",
                                    .lo = 1.0,
                                    .hi = 100.0,
                                    .presence = Presence::optional,
                                    .example = "5",
                                    .doc = "emissivity by angle: 1 - (1 - cos)^exponent of that along the normal"};
inline constexpr FieldInfo kIndex{.name = "refractive_index",
                                  .lo = 1.0,
                                  .hi = 10.0,
                                  .lo_open = true,
                                  .presence = Presence::optional,
                                  .example = "1.5",
                                  .doc = "emissivity by angle: Fresnel's law for a dielectric"};
inline constexpr FieldInfo kFilm{.name = "h",
                                 .unit = "W/m2/K",
                                 .lo = 0.0,
                                 .hi = 1e5,
                                 .example = "\"10 W/m2/K\"",
                                 .doc = "heat transfer coefficient"};
inline constexpr FieldInfo kFlux{.name = "flux",
                                 .unit = "W/m2",
                                 .lo = -1e6,
                                 .hi = 1e6,
                                 .example = "\"200 W/m2\"",
                                 .doc = "into the inner surface; a constant, or the name of a schedule.csv"};
inline constexpr FieldInfo kPairThickness{.name = "thickness",
                                          .unit = "m",
                                          .lo = 0.0,
                                          .hi = 100.0,
                                          .lo_open = true,
                                          .presence = Presence::optional,
                                          .example = "\"50 mm\"",
                                          .doc = "longest distance to the opposite face"};

/// The keys of [material.inside] by kind, beside `kind`.
inline std::vector<std::string_view> inside_keys(InsideKind kind) {
  switch (kind) {
    case InsideKind::adiabatic:
      return {"kind"};
    case InsideKind::fixed:
      return {"kind", "temperature"};
    case InsideKind::film:
      return {"kind", "h", "temperature"};
    case InsideKind::flux:
      return {"kind", "flux"};
    case InsideKind::sheet:
      return {"kind", "solar_absorptance", "emissivity"};
    case InsideKind::pair:
      return {"kind", "thickness"};
  }
  return {};
}

// [[mesh]], [[region]], [ground], [measured], [camera]
inline constexpr std::array<std::string_view, 3> kMeshKeys{"name", "file", "unit"};
inline constexpr FieldInfo kMeshUnit{.name = "unit",
                                     .unit = "m",
                                     .lo = 1e-6,
                                     .hi = 1e4,
                                     .presence = Presence::optional,
                                     .example = "\"1 mm\"",
                                     .doc = "of the file's numbers"};
inline constexpr std::array<std::string_view, 6> kRegionKeys{"name",          "mesh",     "group",
                                                             "mesh_material", "material", "temperature"};
inline constexpr std::array<std::string_view, 2> kGroundKeys{"material", "temperature"};
inline constexpr std::array<std::string_view, 2> kMeasuredKeys{"temperature", "sd"};
inline constexpr FieldInfo kMeasuredSd{.name = "sd",
                                       .unit = "K",
                                       .lo = 0.0,
                                       .hi = 100.0,
                                       .lo_open = true,
                                       .presence = Presence::optional,
                                       .example = "\"0.3 K\"",
                                       .doc = "of a value"};
inline constexpr std::array<std::string_view, 4> kCameraKeys{"position", "look_at", "path", "up"};
inline constexpr double kHottest_k = 3000.0;
inline constexpr mtf::FieldInfo kTemperature{.name = "temperature",
                                             .unit = "K",
                                             .lo = 0.0,
                                             .hi = kHottest_k,
                                             .lo_open = true,
                                             .example = "\"80 degC\"",
                                             .doc = "a constant, or the name of a schedule.csv"};

}  // namespace apps::scene
