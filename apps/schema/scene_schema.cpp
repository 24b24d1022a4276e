// SPDX-License-Identifier: Apache-2.0

// `mtf config schema scene`, by the rows of apps/scene/scene_file/scene_sections.h.

#include <cmath>

#include "apps/scene/scene_file/scene_file.h"
#include "apps/schema/schema_values.h"
#include "apps/schema/schemas.h"
#include "apps/text/json.h"
#include "mtf/units.h"

namespace apps {
namespace {

using mtf::FieldInfo;
using mtf::FieldType;

std::string doc_of(const FieldInfo& field) {
  std::string doc(field.doc);
  if (!field.unit.empty() && std::isfinite(field.lo) && std::isfinite(field.hi))
    doc += std::string(doc.empty() ? "" : "; ") + (field.lo_open ? "above " : "from ") + mtf::format_double(field.lo) +
           " to " + mtf::format_double(field.hi) + " " + std::string(field.unit);
  return doc + (doc.empty() ? "" : ", ") + "such as " + std::string(field.example);
}

/// One number: with a unit a text that ends in one, any product of powers; else in its range, or a percentage.
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
  return {{"anyOf", {value, fit_schema("a number that mtf heat --fit may change", value)}},
          {"description", doc_of(field)}};
}

/// A number, or the name of a file.
Json number_or_file(const FieldInfo& field, std::string_view pattern) {
  Json either = number(field);
  either["anyOf"].push_back({{"type", "string"}, {"pattern", std::string(pattern)}});
  return either;
}

Json list_of(Json table) { return {{"type", "array"}, {"minItems", 1}, {"items", std::move(table)}}; }

template <class T>
Json table_of(std::string_view doc, std::string_view kind = {});

// What stands after `key =`, by the type of its member.
Json value_of(const FieldInfo& row, double) {
  if (row.type != FieldType::date) return number(row);
  // A TOML date, for which JSON has no type, or a text.
  return {{"not", {{"type", {"number", "boolean", "array", "object", "null"}}}}, {"description", std::string(row.doc)}};
}
Json value_of(const FieldInfo& row, const std::optional<double>&) { return number(row); }
Json value_of(const FieldInfo& row, const std::string&) { return text_schema(row.doc); }
Json value_of(const FieldInfo& row, std::size_t) { return text_schema(row.doc); }
Json value_of(const FieldInfo& row, const std::optional<std::size_t>&) { return text_schema(row.doc); }
Json value_of(const FieldInfo& row, const std::optional<scene::CameraPath>&) { return text_schema(row.doc); }
Json value_of(const FieldInfo& row, const std::array<double, 3>&) {
  return {{"type", "array"},
          {"items", plain(scene::number_row("", "m", 0.0, 0.0, "", ""))},
          {"minItems", 3},
          {"maxItems", 3},
          {"description", std::string(row.doc) + ": x east, y north, z up"}};
}
Json value_of(const FieldInfo& row, const radiometry::heat::Schedule&) {
  return row.type == FieldType::file ? text_schema(row.doc) : number_or_file(row, "\\.(csv|CSV)$");
}
Json value_of(const FieldInfo& row, const std::optional<scene::GivenTemperature>&) {
  return number_or_file(row, "\\.(csv|CSV|npy)$");
}
Json value_of(const FieldInfo& row, const std::optional<scene::Emissivity>&) {
  return number_or_file(row, "\\.[A-Za-z]+$");
}
Json value_of(const FieldInfo& row, const scene::Emissivity&) { return number_or_file(row, "\\.[A-Za-z]+$"); }
Json value_of(const FieldInfo& row, scene::CloudSource) {
  Json share = number(row);
  share["anyOf"].push_back(words_schema(row.words));
  return share;
}
Json value_of(const FieldInfo&, const scene::Convection&) {
  return {{"anyOf", {words_schema(scene::kConvectionWords), table_of<scene::Convection>("h0 + h1 x wind speed")}}};
}
Json value_of(const FieldInfo&, const std::vector<scene::LayerSection>&) {
  return list_of(table_of<scene::LayerSection>("from the outside inwards"));
}
Json value_of(const FieldInfo&, const scene::Inside&) {
  Json variants = Json::array();
  for (const std::string_view kind : scene::kInsideNames) {
    variants.push_back(table_of<scene::Inside>("what is behind the last layer", kind));
    variants[variants.size() - 1]["properties"]["kind"] = {{"const", std::string(kind)}};
  }
  return {{"oneOf", std::move(variants)}};
}
template <class Word>
requires std::is_enum_v<Word> Json value_of(const FieldInfo& row, Word) { return words_schema(row.words); }
template <class Word>
requires std::is_enum_v<Word> Json value_of(const FieldInfo& row, const std::optional<Word>&) {
  return words_schema(row.words);
}

void add(Json& table, const FieldInfo& row, Json value) {
  table["properties"][std::string(row.name)] = std::move(value);
  if (row.presence == mtf::Presence::required) table["required"].push_back(std::string(row.name));
}

/// The rows of a type; of those of kinds the ones that count with `kind`.
template <class T>
void add_rows(Json& table, std::string_view kind = {}) {
  const T prototype{};
  radiometry::for_each_field(prototype, [&](const FieldInfo& row, const auto& value) {
    if (scene::counts_with(row, kind)) add(table, row, value_of(row, value));
  });
}

template <class T>
Json table_of(std::string_view doc, std::string_view kind) {
  Json table = closed_table(doc);
  add_rows<T>(table, kind);
  return table;
}

Json weather() {
  Json table = table_of<scene::WeatherSection>("a file, or constant values");
  add(table, scene::kHumidity, number(scene::kHumidity));
  add_rows<scene::WeatherChange>(table);
  for (const FieldInfo& row : scene::kConstants) add(table, row, number(row));
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

/// Of a region or the ground: a material, a temperature, or both.
template <class T>
Json surface(std::string_view doc) {
  Json table = table_of<T>(doc);
  table["anyOf"] = {{{"required", {"material"}}}, {{"required", {"temperature"}}}};
  return table;
}

Json camera() {
  Json table = table_of<scene::CameraSection>("where pictures are taken from");
  table["oneOf"] = {{{"required", {"position", "look_at"}}}, {{"required", {"path"}}}};
  return table;
}

Json table_named(std::string_view name, const SensorKinds& kinds) {
  if (name == "place") return table_of<scene::PlaceSection>("where the scene is");
  if (name == "time") return table_of<scene::TimeSection>("the run");
  if (name == "weather") return weather();
  if (name == "sky") return table_of<scene::SkySection>("the long wave of the sky, and its clouds");
  if (name == "atmosphere") return atmosphere(kinds);
  if (name == "material") return list_of(table_of<scene::MaterialSection>("what a surface is made of"));
  if (name == "mesh") return list_of(table_of<scene::MeshSection>("a file of faces"));
  if (name == "region") return list_of(surface<scene::RegionSection>("faces of one material"));
  if (name == "ground") return surface<scene::GroundSection>("what is beyond the facets");
  if (name == "measured") return table_of<scene::MeasuredSection>("what the ground was, for a fit");
  return camera();
}

}  // namespace

std::string scene_file_schema() {
  const SensorKinds kinds = sensor_kinds();
  Json schema = schema_head("mtf scene file", "a 3-D scene: place, time, weather, surfaces, camera");
  for (const std::string_view name : scene::kTables)
    if (name != "schema") schema["properties"][std::string(name)] = table_named(name, kinds);
  for (const char* name : {"place", "time", "weather"}) schema["required"].push_back(name);
  add_number_definitions(schema["definitions"]);
  return json_document(schema, 1);
}

}  // namespace apps
