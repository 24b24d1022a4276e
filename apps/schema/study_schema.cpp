// SPDX-License-Identifier: Apache-2.0

// `mtf config schema study`: keys from apps/study/study_shape.h.

#include <algorithm>
#include <functional>

#include "apps/schema/schema_values.h"
#include "apps/schema/schemas.h"
#include "apps/study/study_shape.h"
#include "apps/text/json.h"

namespace apps {
namespace {

/// A number, or a string that has a number with its unit.
Json number_or_text() { return {{"type", {"number", "string"}}}; }

Json whole(double least, double most) { return {{"type", "integer"}, {"minimum", least}, {"maximum", most}}; }

Json described(Json value, const mtf::FieldInfo& key) {
  value["description"] = std::string(key.doc) + ", such as " + std::string(key.example);
  return value;
}

/// A table of exactly the keys of its rows.
Json table_of(std::string_view name, const std::function<Json(std::string_view)>& value) {
  const auto& tables = study::kStudyTables;
  const study::StudyTable& of =
      *std::find_if(tables.begin(), tables.end(), [&](const study::StudyTable& each) { return each.name == name; });
  Json table = closed_table(of.doc);
  for (const mtf::FieldInfo& key : of.keys)
    table["properties"][std::string(key.name)] = described(value(key.name), key);
  return table;
}

Json axis() {
  Json table = table_of("axis", [](std::string_view key) -> Json {
    if (key == "values") return {{"type", "array"}, {"minItems", 1}};
    if (key == "count") return whole(1, 1e9);
    if (key == "scale") return words_schema(study::kScales);
    return key == "from" || key == "to" ? number_or_text() : text_schema();
  });
  const Json named{{"oneOf", {{{"required", {"parameter"}}}, {{"required", {"name"}}}}}};
  const Json ranged{{"oneOf", {{{"required", {"values"}}}, {{"required", {"from", "to"}}}}}};
  table["allOf"] = {named, ranged};
  return list_schema(std::move(table));
}

Json as_built() {
  Json table =
      table_of("as_built", [](std::string_view key) { return key == "parameter" ? text_schema() : number_or_text(); });
  table["required"] = {"parameter"};
  table["oneOf"] = {{{"required", {"sd"}}}, {{"required", {"plus_minus"}}}};
  return list_schema(std::move(table));
}

Json conditions() {
  Json table = closed_table("where and when the sensor is used");
  for (const mtf::FieldInfo& field : study::condition_fields())
    table["properties"][std::string(field.name)] = described(number_schema(field), field);
  return table;
}

Json value_of(std::string_view key) {
  if (key == "tolerance") return number_schema(study::kTolerance);
  if (key == "seed") return {{"type", "integer"}, {"minimum", 0}};
  if (key == "constraints" || key == "objectives") return list_schema(text_schema());
  if (key == "axis") return axis();
  if (key == "as_built") return as_built();
  if (key == "conditions") return conditions();
  if (key == "links") return {{"type", "object"}, {"additionalProperties", text_schema()}};
  if (key == "sampling")
    return table_of("sampling",
                    [](std::string_view k) { return k == "method" ? words_schema(study::kMethods) : whole(1, 1e9); });
  if (key == "yield")
    return table_of("yield", [](std::string_view) { return whole(study::kDraws.lo, study::kDraws.hi); });
  if (key == "metrics") return table_of("metrics", [](std::string_view) { return list_schema(text_schema()); });
  return text_schema();  // name, sensor
}

}  // namespace

std::string study_file_schema() {
  Json schema = schema_head("mtf study file", "a trade study: what varies, what follows, what is wanted");
  for (const mtf::FieldInfo& key : study::kHeadKeys)
    if (key.name != "schema") schema["properties"][std::string(key.name)] = described(value_of(key.name), key);
  for (const study::StudyTable& table : study::kStudyTables)
    schema["properties"][std::string(table.name)] = value_of(table.name);
  return json_document(schema, 1);
}

}  // namespace apps
