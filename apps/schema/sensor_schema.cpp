// SPDX-License-Identifier: Apache-2.0

// `mtf config schema sensor`.

#include <utility>

#include "apps/schema/schema_values.h"
#include "apps/schema/schemas.h"
#include "apps/text/json.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/settings.h"

namespace apps {
namespace {

Json component_schema(const ComponentKind& kind) {
  Json table = closed_table(kind.doc);
  table["properties"]["kind"] = {{"const", kind.kind}};
  table["properties"]["label"] = {
      {"type", "string"}, {"minLength", 1}, {"description", "its name in tables and files"}};
  table["required"].push_back("kind");
  add_parameters(kind.parameters, table);
  if (!kind.stages.presample) return table;
  table["properties"]["table"] = text_schema("CSV file with numbers over the field, columns called as their keys");
  for (const mtf::io::cfg::FileKey& key : mtf::io::cfg::kFileKeys)
    if (key.kind == kind.kind) table["properties"][std::string(key.key)] = text_schema(std::string(key.doc));
  // Which of the numbers come from there only the file says.
  Json numbers = Json::object();
  numbers["required"] = std::exchange(table["required"], {"kind"});
  if (const Json* sizes = table.find("allOf")) numbers["allOf"] = *sizes;
  std::erase_if(table.items(), [](const auto& member) { return member.first == "allOf"; });
  table["anyOf"] = Json::array();
  const auto with_file = [&](std::string_view key) {
    Json given = Json::object();
    given["required"] = {std::string(key)};
    table["anyOf"].push_back(std::move(given));
  };
  with_file(mtf::io::cfg::kTableKey);
  for (const mtf::io::cfg::FileKey& key : mtf::io::cfg::kFileKeys)
    if (key.kind == kind.kind) with_file(key.key);
  table["anyOf"].push_back(std::move(numbers));
  return table;
}

/// [[presample]]: any of the kinds that may stand there. The kind is named first, so that a validator says which table
/// it has judged by.
Json stage_schema(const std::vector<ComponentKind>& kinds, mtf::Stage stage) {
  Json items{{"oneOf", Json::array()}};
  for (const ComponentKind& kind : kinds)
    if (kind.stages.allows(stage))
      items["oneOf"].push_back({{"$ref", "#/definitions/component_" + std::string(kind.kind)}});
  return {{"type", "array"}, {"items", std::move(items)}};
}

/// A table may have several sets of rows, of which a word elsewhere in the file chooses one: any of them will do.
Json table_schema(std::string_view name, const SensorKinds& kinds) {
  std::vector<Parameter> shared;
  std::string_view doc;
  for (const TableKind& own : kinds.own_tables)
    if (own.name == name) {
      shared = own.parameters;
      doc = own.doc;
    }
  Json variants = Json::array();
  for (const TableKind& table : kinds.tables) {
    if (table.name != name) continue;
    Json variant = closed_table(table.doc.empty() ? doc : table.doc);
    std::vector<Parameter> all = shared;
    for (const Parameter& parameter : table.parameters) {
      // A row that both name, such as the transmission of [optics], is that of the chain.
      std::erase_if(all, [&](const Parameter& other) { return other.name == parameter.name; });
      all.push_back(parameter);
    }
    add_parameters(all, variant);
    variants.push_back(std::move(variant));
  }
  if (variants.empty()) {
    Json table = closed_table(doc);
    add_parameters(shared, table);
    return table;
  }
  return variants.size() == 1 ? variants[0] : Json{{"anyOf", std::move(variants)}};
}

}  // namespace

std::string sensor_file_schema() {
  const SensorKinds kinds = sensor_kinds();
  Json schema = schema_head("mtf sensor file", "a sensor: its focal plane, the factors of its OTF, its chain to counts",
                            mtf::kSensorVersion);
  Json& properties = schema["properties"];
  properties["name"] = {{"type", "string"}};
  for (const auto* tables : {&kinds.own_tables, &kinds.tables})
    for (const TableKind& table : *tables)
      if (!properties.contains(std::string(table.name)))
        properties[std::string(table.name)] = table_schema(table.name, kinds);
  for (const mtf::Stage stage : mtf::kStages)
    properties[std::string(stage_name(stage))] = stage_schema(kinds.components, stage);
  schema["required"].push_back("frame");
  add_number_definitions(schema["definitions"]);
  for (const ComponentKind& kind : kinds.components)
    schema["definitions"]["component_" + std::string(kind.kind)] = component_schema(kind);
  return json_document(schema, 1);
}

}  // namespace apps
