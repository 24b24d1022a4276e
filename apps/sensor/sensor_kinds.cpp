// SPDX-License-Identifier: Apache-2.0
#include "apps/sensor/sensor_kinds.h"

#include <algorithm>
#include <array>

#include "mtf/components/component_docs.h"
#include "mtf/io/config/config_reader.h"
#include "radiometry/chain/sensor_settings.h"

namespace apps {
namespace {

using mtf::Component;
using mtf::FieldInfo;
using mtf::FieldRef;
using mtf::FieldType;
using mtf::Presence;

/// What a component with default values would be written with.
std::string default_of(const FieldRef<double>& field) {
  if (field.info->presence != Presence::optional) return "";
  const std::string line = mtf::io::cfg::write_fields({&field, 1});
  const std::size_t equals = line.find(" = ");
  return equals == std::string::npos ? "" : line.substr(equals + 3, line.find('\n') - equals - 3);
}

/// `field`: of a component with default values.
Parameter parameter_of(const FieldRef<double>& field) {
  Parameter parameter{*field.info, default_of(field)};
  if (parameter.type == FieldType::frequency)
    parameter.unit =
        field.info->dimension == mtf::Dimension::cutoff ? "cy/mm, cy/mrad, cy/px or Hz" : "cy/mm, cy/mrad or cy/px";
  if (parameter.type == FieldType::size) parameter.unit = "um, urad or px";
  if (const auto* choice = std::get_if<mtf::Choice*>(&field.value)) parameter.words = (*choice)->names;
  return parameter;
}

TableKind kind_of(const mtf::TableInfo& table) {
  TableKind kind{.name = table.name, .doc = table.doc, .parameters = {}};
  if (table.where)
    kind.condition = "[" + std::string(table.where->table) + "] " + std::string(table.where->key) + " = \"" +
                     std::string(table.where->word) + "\"";
  for (const FieldInfo& row : table.settings) kind.parameters.push_back({row, {}});
  return kind;
}

/// The required fields; without any, or when they do not do, the first of the others that will, or the first two
/// neighbours among them.
void add_example(const Component<double>& blank, ComponentKind& kind) {
  const auto fields = blank.fields();
  std::string list;
  for (const mtf::Stage stage : mtf::kStages)
    if (list.empty() && blank.stages().allows(stage)) list = stage_name(stage);
  const auto with = [&](const FieldRef<double>* extra, const FieldRef<double>* more = nullptr) {
    std::string text = "[[" + list + "]]\nkind = \"" + std::string(kind.kind) + "\"\n";
    for (const FieldRef<double>& field : fields)
      if (field.info->presence == Presence::required || &field == extra || &field == more)
        text += std::string(field.info->name) + " = " + std::string(field.info->example) + "\n";
    return text;
  };
  const std::string sensor =
      "schema = 2\n[frame]\nfocal_length = \"100 mm\"\npitch = \"15 um\"\nintegration_time = \"10 ms\"\n"
      "[optics]\nf_number = 2.0\n[band]\nwavelength = [\"3.4 um\", \"4.8 um\"]\n";
  std::vector<const FieldRef<double>*> extras;
  const auto add_all = [&](Presence presence) {
    for (const FieldRef<double>& field : fields)
      if (field.info->presence == presence) extras.push_back(&field);
  };
  const bool some_required = std::ranges::any_of(
      fields, [](const FieldRef<double>& field) { return field.info->presence == Presence::required; });
  if (some_required) extras.push_back(nullptr);
  add_all(Presence::optional);
  if (!some_required) extras.push_back(nullptr);
  add_all(Presence::shared);
  kind.example = with(nullptr);
  std::vector<std::string> examples;
  for (const FieldRef<double>* extra : extras) examples.push_back(with(extra));
  for (std::size_t i = 1; i < extras.size(); ++i) examples.push_back(with(extras[i - 1], extras[i]));
  for (const std::string& example : examples) {
    const mtf::io::ConfigResult result = mtf::io::parse_config(sensor + example, "");
    if (!result.ok()) continue;
    const mtf::System<double>& system = result.config.system;
    for (const auto& entries : system.stages)
      for (const auto& entry : entries) {
        kind.example = example;
        kind.traits = entry.component.traits(system.context());
        return;
      }
  }
}

}  // namespace

std::string_view type_name(mtf::FieldType type) {
  constexpr std::array<std::string_view, 13> names{"number",         "size",    "frequency", "whole", "flag",
                                                   "word",           "numbers", "rows",      "text",  "file",
                                                   "number_or_file", "pair",    "date"};
  return names.at(static_cast<std::size_t>(type));
}

std::string_view presence_name(Presence presence) {
  return presence == Presence::required ? "required" : presence == Presence::optional ? "optional" : "shared";
}

bool has_range(const FieldInfo& row) { return row.lo != row.hi; }

bool wants_log_scale(const FieldInfo& row) {
  constexpr double kSpan = 50.0;
  return has_range(row) && row.lo >= 0.0 && row.hi > kSpan * row.lo && (row.lo > 0.0 || row.hi > kSpan);
}

ComponentKind component_kind(std::string_view kind) {
  const Component<double> blank = Component<double>::make(kind);
  ComponentKind result{.kind = blank.kind(),
                       .doc = blank.doc(),
                       .notes = mtf::component_notes(kind),
                       .source = mtf::component_source(kind),
                       .stages = blank.stages(),
                       .part = blank.part()};
  for (const FieldRef<double>& field : blank.fields()) result.parameters.push_back(parameter_of(field));
  add_example(blank, result);
  return result;
}

SensorKinds sensor_kinds() {
  SensorKinds kinds;
  for (const std::string_view kind : mtf::component_kinds()) kinds.components.push_back(component_kind(kind));
  for (const mtf::TableInfo& table : radiometry::sensor_tables()) kinds.tables.push_back(kind_of(table));
  for (const mtf::TableInfo& table : mtf::io::cfg::own_tables()) kinds.own_tables.push_back(kind_of(table));
  return kinds;
}

}  // namespace apps
