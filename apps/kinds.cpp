// SPDX-License-Identifier: Apache-2.0
#include "apps/kinds.h"

#include "apps/text_table.h"
#include "mtf/component.h"

namespace apps {
namespace {

using mtf::Component;
using mtf::FieldInfo;
using mtf::FieldRef;
using mtf::Presence;

std::string range_of(const FieldRef<double>& field) {
  const FieldInfo& info = *field.info;
  if (const auto* choice = std::get_if<mtf::Choice*>(&field.value)) {
    std::string words;
    for (const std::string_view name : (*choice)->names) words += (words.empty() ? "" : " | ") + std::string(name);
    return words;
  }
  if (std::holds_alternative<std::shared_ptr<const mtf::Curve>*>(field.value)) return "a file";
  return std::string(info.lo_open ? "(" : "[") + mtf::format_double(info.lo) + ", " + mtf::format_double(info.hi) +
         (info.hi_open ? ")" : "]") + (info.unit.empty() ? "" : " " + std::string(info.unit));
}

std::string_view presence_of(const FieldInfo& info) {
  return info.presence == Presence::required   ? "required"
         : info.presence == Presence::optional ? "optional"
                                               : "or from [optics]";
}

std::string describe_one(std::string_view kind) {
  const Component<double> component = Component<double>::make(kind);
  std::string lists;
  for (const mtf::Stage stage : mtf::kStages)
    if (component.stages().allows(stage))
      lists += (lists.empty() ? "[[" : ", [[") + std::string(stage_name(stage)) + "]]";
  std::string text = std::string(kind) + ": " + std::string(component.doc()) + "; in " + lists + "\n";
  TextTable table({"  parameter", "example", "range", "", ""});
  for (const FieldRef<double>& field : component.fields()) {
    const bool per_axis = std::holds_alternative<mtf::AxisPair<double>*>(field.value);
    const std::string name(field.info->name);
    table.add({"  " + name + (per_axis ? " (or " + name + "_x, " + name + "_y)" : ""), std::string(field.info->example),
               range_of(field), std::string(presence_of(*field.info)), std::string(field.info->doc)});
  }
  return text + table.aligned();
}

}  // namespace

std::string describe_kinds(const std::string& kind) {
  if (!kind.empty()) return describe_one(kind);
  std::string text;
  for (const std::string_view each : mtf::component_kinds()) text += (text.empty() ? "" : "\n") + describe_one(each);
  return text;
}

}  // namespace apps
