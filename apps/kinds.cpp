// SPDX-License-Identifier: Apache-2.0
#include "apps/kinds.h"

#include <algorithm>
#include <sstream>

#include "apps/terminal/text_table.h"
#include "mtf/component_docs.h"

namespace apps {
namespace {

using mtf::Component;
using mtf::FieldInfo;
using mtf::FieldRef;
using mtf::Presence;

std::string indented(std::string_view notes) {
  std::istringstream lines{std::string(notes)};
  std::string text;
  for (std::string line; std::getline(lines, line);) text += (line.empty() ? "" : "  " + line) + "\n";
  return text;
}

/// 1e6 for 1e+06.
std::string bound(double value) {
  std::string text = mtf::format_double(value);
  const std::size_t e = text.find('e');
  if (e == std::string::npos) return text;
  const std::size_t digits = text.find_first_of("123456789", e);
  return text.substr(0, e + 1) + (text[e + 1] == '-' ? "-" : "") + text.substr(digits);
}

std::string interval(const FieldInfo& info) {
  return (info.lo_open ? "(" : "[") + bound(info.lo) + ", " + bound(info.hi) + (info.hi_open ? ")" : "]");
}

std::string values_of(const mtf::SettingInfo& row) {
  const std::string unit(row.info.unit.empty() ? "" : " " + std::string(row.info.unit));
  std::string words;
  switch (row.type) {
    case mtf::SettingType::number:
      return interval(row.info) + unit;
    case mtf::SettingType::number_or_file:
      return interval(row.info) + unit + ", or a file";
    case mtf::SettingType::whole:
      return "whole, " + interval(row.info);
    case mtf::SettingType::flag:
      return "true | false";
    case mtf::SettingType::word:
      for (const std::string_view word : row.words) words += (words.empty() ? "" : " | ") + std::string(word);
      return words;
    case mtf::SettingType::text:
      return "a name";
    case mtf::SettingType::file:
      return "a file";
  }
  return "";
}

std::string describe_table(const mtf::TableInfo& info) {
  TextTable table({"  key", "example", "range", "", ""});
  for (const mtf::SettingInfo& row : info.settings)
    table.add({"  " + std::string(row.info.name), std::string(row.info.example), values_of(row),
               std::string(presence_of(row.info)), std::string(row.info.doc)});
  return "[" + std::string(info.name) + "]: " + (info.doc.empty() ? "" : std::string(info.doc) + "; ") +
         "keys of the sensor file for electrons and counts\n\n" + table.aligned();
}

std::string describe_one(std::string_view kind) {
  const Component<double> component = Component<double>::make(kind);
  std::string text = std::string(kind) + ": " + std::string(component.doc()) + "; in " +
                     join_stages(component.stages(), "[[", "]]") + "\n";
  text += indented(mtf::component_notes(kind)) + "\n";
  TextTable table({"  parameter", "example", "range", "", ""});
  for (const FieldRef<double>& field : component.fields()) {
    const std::string unit = unit_of(field);
    table.add({"  " + written_name(field), std::string(field.info->example),
               range_of(field) + (unit.empty() ? "" : " " + unit), std::string(presence_of(*field.info)),
               std::string(field.info->doc)});
  }
  return text + table.aligned();
}

}  // namespace

std::string join_stages(const mtf::Stages& stages, const std::string& before, const std::string& after) {
  std::string text;
  for (const mtf::Stage stage : mtf::kStages)
    if (stages.allows(stage)) text += (text.empty() ? "" : ", ") + before + std::string(stage_name(stage)) + after;
  return text;
}

std::string written_name(const FieldRef<double>& field) {
  const std::string name(field.info->name);
  const bool per_axis = std::holds_alternative<mtf::AxisPair<double>*>(field.value);
  return per_axis ? name + " (or " + name + "_x, " + name + "_y)" : name;
}

std::string unit_of(const FieldRef<double>& field) {
  if (std::holds_alternative<mtf::AxisPair<double>*>(field.value)) return "um, urad or px";
  if (std::holds_alternative<mtf::SpatialFrequency<double>*>(field.value))
    return field.info->dimension == mtf::Dimension::cutoff ? "cy/mm, cy/mrad, cy/px or Hz" : "cy/mm, cy/mrad or cy/px";
  return std::string(field.info->unit);
}

std::string range_of(const FieldRef<double>& field) {
  const FieldInfo& info = *field.info;
  if (const auto* choice = std::get_if<mtf::Choice*>(&field.value)) {
    std::string words;
    for (const std::string_view name : (*choice)->names) words += (words.empty() ? "" : " | ") + std::string(name);
    return words;
  }
  if (std::holds_alternative<std::shared_ptr<const mtf::Curve>*>(field.value)) return "a file";
  return interval(info);
}

std::string_view presence_of(const FieldInfo& info) {
  return info.presence == Presence::required   ? "required"
         : info.presence == Presence::optional ? "optional"
                                               : "or from [optics]";
}

std::string describe_kinds(const std::string& kind, const std::vector<mtf::TableInfo>& tables) {
  const auto table = std::find_if(tables.begin(), tables.end(), [&](const auto& info) { return info.name == kind; });
  if (table != tables.end()) return describe_table(*table);
  if (!kind.empty()) return describe_one(kind);
  std::string text;
  for (const std::string_view each : mtf::component_kinds()) text += (text.empty() ? "" : "\n") + describe_one(each);
  return text;
}

}  // namespace apps
