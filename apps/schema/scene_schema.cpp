// SPDX-License-Identifier: Apache-2.0

// `mtf config schema scene`: keys and ranges from apps/scene/scene_file/scene_fields.h.

#include <cmath>
#include <span>

#include "apps/scene/scene_file/scene_fields.h"
#include "apps/schema/schema_values.h"
#include "apps/schema/schemas.h"
#include "apps/text/json.h"
#include "mtf/units.h"

namespace apps {
namespace {

using mtf::FieldInfo;

Json text(std::string_view doc) {
  Json schema{{"type", "string"}, {"minLength", 1}};
  if (!doc.empty()) schema["description"] = std::string(doc);
  return schema;
}

template <std::size_t N>
Json words(const std::array<std::string_view, N>& names) {
  Json list = Json::array();
  for (const std::string_view name : names) list.push_back(std::string(name));
  return {{"enum", std::move(list)}};
}

std::string doc_of(const FieldInfo& field) {
  std::string doc(field.doc);
  if (!field.unit.empty() && std::isfinite(field.lo) && std::isfinite(field.hi))
    doc += std::string(doc.empty() ? "" : "; ") + (field.lo_open ? "above " : "from ") + mtf::format_double(field.lo) +
           " to " + mtf::format_double(field.hi) + " " + std::string(field.unit);
  return doc + (doc.empty() ? "" : ", ") + "such as " + std::string(field.example);
}

/// One number: with a unit a text that ends in one, which may be any product of powers; else in its range, or a
/// percentage.
Json plain(const FieldInfo& field) {
  constexpr const char* kNumber = "^[ \\t]*[+-]?([0-9]+\\.?[0-9]*|\\.[0-9]+)([eE][+-]?[0-9]+)?[ \\t]*";
  if (!field.unit.empty())
    return {{"type", "string"},
            {"pattern", std::string(kNumber) + "[A-Za-zµμ(%][^ \\t].*$|" + kNumber + "[A-Za-zµμ%]+[ \\t]*$"}};
  Json number{{"type", "number"}};
  number[field.lo_open ? "exclusiveMinimum" : "minimum"] = field.lo;
  number[field.hi_open ? "exclusiveMaximum" : "maximum"] = field.hi;
  return {{"anyOf", {number, {{"type", "string"}, {"pattern", std::string(kNumber) + "%[ \\t]*$"}}}}};
}

/// The same, or a table { value, fit, min, max, prior, stderr }.
Json number(const FieldInfo& field) {
  const Json value = plain(field);
  Json table = closed_table("a number that mtf heat --fit may change");
  for (const char* key : {"value", "min", "max", "stderr"}) table["properties"][key] = value;
  table["properties"]["fit"] = {{"type", "boolean"}};
  Json prior = closed_table("what is known beforehand");
  prior["properties"] = {{"mean", value}, {"sd", value}};
  prior["required"] = {"mean", "sd"};
  table["properties"]["prior"] = std::move(prior);
  table["required"] = {"value"};
  return {{"anyOf", {value, std::move(table)}}, {"description", doc_of(field)}};
}

/// A number, or the name of a table.
Json number_or_file(const FieldInfo& field, std::string_view pattern = "\\.(csv|CSV)$") {
  Json either = number(field);
  either["anyOf"].push_back({{"type", "string"}, {"pattern", std::string(pattern)}});
  return either;
}

void add(Json& table, const FieldInfo& field) {
  table["properties"][std::string(field.name)] = number(field);
  if (field.presence == mtf::Presence::required) table["required"].push_back(std::string(field.name));
}

Json list_of(Json table) { return {{"type", "array"}, {"minItems", 1}, {"items", std::move(table)}}; }

Json point(std::string_view doc) {
  const FieldInfo length{.name = {}, .unit = "m", .example = "\"14 m\""};
  return {{"type", "array"},
          {"items", plain(length)},
          {"minItems", 3},
          {"maxItems", 3},
          {"description", std::string(doc) + ": x east, y north, z up"}};
}

/// An instant: a TOML date, for which JSON has no type, or a text.
Json instant(std::string_view doc) {
  return {{"not", {{"type", {"number", "boolean", "array", "object", "null"}}}}, {"description", std::string(doc)}};
}

Json temperature() { return number_or_file(scene::kTemperature, "\\.(csv|CSV|npy)$"); }

Json emissivity() { return number_or_file(scene::kEmissivity, "\\.[A-Za-z]+$"); }

Json place() {
  Json table = closed_table("where the scene is");
  for (const FieldInfo& field : {scene::kLatitude, scene::kLongitude, scene::kAltitude, scene::kNorth})
    add(table, field);
  return table;
}

Json time() {
  Json table = closed_table("the run");
  table["properties"]["start"] = instant("with its time zone, such as 2016-01-01T00:00:00Z");
  table["properties"]["end"] = instant("after the start");
  add(table, scene::kStep);
  table["required"] = {"start", "end"};
  return table;
}

Json weather() {
  Json table = closed_table("a file, or constant values");
  Json& keys = table["properties"];
  keys["file"] = text("CSV, EPW, TMY3 or SURFRAD");
  keys["stamp"] = words(radiometry::heat::kStampNames);
  keys["repeat"] = words(radiometry::heat::kRepeatNames);
  for (const FieldInfo& field : {scene::kBridge, scene::kAverage, scene::kHumidity}) add(table, field);
  for (const FieldInfo& field : scene::kWeatherChanges) add(table, field);
  for (const FieldInfo& field : scene::kConstants) add(table, field);
  return table;
}

Json sky() {
  Json table = closed_table("the long wave of the sky, and its clouds");
  table["properties"]["longwave"] = words(scene::kLongwaveNames);
  Json cloud = number(scene::kCloud);
  cloud["anyOf"].push_back(words(scene::kCloudWords));
  table["properties"]["cloud"] = std::move(cloud);
  return table;
}

Json atmosphere(const SensorKinds& kinds) {
  for (const TableKind& kind : kinds.tables) {
    if (kind.name != "atmosphere") continue;
    Json table = closed_table(kind.doc);
    add_parameters(kind.parameters, table);
    return table;
  }
  return closed_table("the air");
}

Json layer() {
  Json table = closed_table("from the outside inwards");
  for (const FieldInfo& field : {scene::kConductivity, scene::kDensity, scene::kHeatCapacity, scene::kThickness})
    add(table, field);
  table["properties"]["source"] = number_or_file(scene::kSource);
  return table;
}

Json convection() {
  Json linear = closed_table("h0 + h1 x wind speed");
  for (const FieldInfo& field : {scene::kFilmStill, scene::kFilmWind}) add(linear, field);
  return {{"anyOf", {words(scene::kConvectionWords), std::move(linear)}}};
}

Json inside_value(std::string_view key) {
  if (key == "temperature") return number_or_file(scene::kTemperature);
  if (key == "h") return number(scene::kFilm);
  if (key == "flux") return number_or_file(scene::kFlux);
  if (key == "thickness") return number(scene::kPairThickness);
  if (key == "solar_absorptance") return number(scene::kSolarAbsorptance);
  return emissivity();
}

Json inside() {
  Json variants = Json::array();
  for (std::size_t k = 0; k < scene::kInsideNames.size(); ++k) {
    const auto kind = static_cast<scene::InsideKind>(k);
    Json table = closed_table("what is behind the last layer");
    for (const std::string_view key : scene::inside_keys(kind)) {
      const bool optional = kind == scene::InsideKind::sheet || kind == scene::InsideKind::pair;
      table["properties"][std::string(key)] =
          key == "kind" ? Json{{"const", std::string(scene::kInsideNames[k])}} : inside_value(key);
      if (key == "kind" || !optional) table["required"].push_back(std::string(key));
    }
    variants.push_back(std::move(table));
  }
  return {{"oneOf", std::move(variants)}};
}

Json material() {
  Json table = closed_table("what a surface is made of");
  Json& keys = table["properties"];
  keys["name"] = text("which regions refer to");
  keys["emissivity"] = emissivity();
  keys["convection"] = convection();
  keys["layers"] = list_of(layer());
  keys["inside"] = inside();
  keys["emissivity_angles"] = text("table of angle_deg,relative");
  for (const FieldInfo& field :
       {scene::kSolarAbsorptance, scene::kWetFraction, scene::kGloss, scene::kSchlick, scene::kIndex})
    add(table, field);
  for (const char* key : {"name", "emissivity", "layers"}) table["required"].push_back(key);
  return list_of(std::move(table));
}

Json mesh() {
  Json table = closed_table("a file of faces");
  table["properties"] = {{"name", text("which regions refer to")}, {"file", text("OBJ, PLY, STL or glTF 2")}};
  table["required"] = {"name", "file"};
  add(table, scene::kMeshUnit);
  return list_of(std::move(table));
}

/// Of a region or the ground: a material, a temperature, or both.
Json surface(std::string_view doc, std::span<const std::string_view> keys) {
  Json table = closed_table(doc);
  for (const std::string_view key : keys)
    table["properties"][std::string(key)] = key == "temperature" ? temperature() : text("");
  table["anyOf"] = {{{"required", {"material"}}}, {{"required", {"temperature"}}}};
  return table;
}

Json measured() {
  Json table = closed_table("what the ground was, for a fit");
  table["properties"]["temperature"] = text("a table of times");
  add(table, scene::kMeasuredSd);
  return table;
}

Json camera() {
  Json table = closed_table("where pictures are taken from");
  table["properties"] = {{"position", point("of the camera")},
                         {"look_at", point("what it looks at")},
                         {"up", point("what is up in the image")},
                         {"path", text("CSV of both over time, in place of them")}};
  table["oneOf"] = {{{"required", {"position", "look_at"}}}, {{"required", {"path"}}}};
  return table;
}

Json table_of(std::string_view name, const SensorKinds& kinds) {
  if (name == "place") return place();
  if (name == "time") return time();
  if (name == "weather") return weather();
  if (name == "sky") return sky();
  if (name == "atmosphere") return atmosphere(kinds);
  if (name == "material") return material();
  if (name == "mesh") return mesh();
  if (name == "region") {
    Json region = surface("faces of one material", scene::kRegionKeys);
    region["required"] = {"mesh"};
    return list_of(std::move(region));
  }
  if (name == "ground") return surface("what is beyond the facets", scene::kGroundKeys);
  if (name == "measured") return measured();
  return camera();
}

}  // namespace

std::string scene_file_schema() {
  const SensorKinds kinds = sensor_kinds();
  Json schema = schema_head("mtf scene file", "a 3-D scene: place, time, weather, surfaces, camera");
  for (const std::string_view name : scene::kTables)
    if (name != "schema") schema["properties"][std::string(name)] = table_of(name, kinds);
  for (const char* name : {"place", "time", "weather"}) schema["required"].push_back(name);
  add_number_definitions(schema["definitions"]);
  return json_document(schema, 1);
}

}  // namespace apps
