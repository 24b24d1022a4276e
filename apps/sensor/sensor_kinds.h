// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a sensor file may hold, as data: every kind of component and every table of the chain, with their parameters.
// `mtf config kinds` prints it; a program makes forms, checks or documents of it.
//
//   for (const apps::ComponentKind& kind : apps::sensor_kinds().components)
//     for (const apps::Parameter& parameter : kind.parameters) ...

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/component.h"

namespace apps {

/// One parameter of a component, or one key of a table.
struct Parameter : mtf::FieldInfo {
  /// Of components, as a sensor file has it: the value that counts where none is given. "" where there is none, or
  /// where it depends on other values and `doc` tells it.
  std::string default_value{};
};

/// A kind of component: what [[presample]], [[readout]] and [[postsample]] list.
struct ComponentKind {
  std::string_view kind;
  std::string_view doc;    ///< one sentence
  std::string_view notes;  ///< its physics, formulas in lines indented by two spaces; the source at the end
  std::string source;      ///< from the end of the notes, without its parentheses; "" = none
  mtf::Stages stages;      ///< the lists that it may stand in
  mtf::SensorPart part{};
  std::vector<Parameter> parameters{};
  std::string example{};                ///< its TOML with as few parameters as will do
  std::optional<mtf::Traits> traits{};  ///< of the example's OTF; unknown where it needs a file
};

/// A table of the chain from light to counts: [detector], [adc] and so on.
struct TableKind {
  std::string_view name;
  std::string_view doc;
  std::vector<Parameter> parameters;
  std::string condition{};  ///< what the file has to say for these keys to hold: "[detector] kind = \"thermal\""
};

/// "number", "size", ...: the name of the enumerator.
std::string_view type_name(mtf::FieldType type);
/// "required", "optional", "shared".
std::string_view presence_name(mtf::Presence presence);
/// True for a number whose range is known.
bool has_range(const mtf::FieldInfo& row);
/// True where a control should move on a logarithmic scale: the range spans more than a factor of 50.
bool wants_log_scale(const mtf::FieldInfo& row);

struct SensorKinds {
  std::vector<ComponentKind> components;  ///< in the order of mtf::component_kinds()
  std::vector<TableKind> tables;          ///< in the order of radiometry::sensor_tables()
  std::vector<TableKind> own_tables;      ///< [frame], [scene], [optics], [band]: keys that need no chain
};

SensorKinds sensor_kinds();

/// One of them. Throws UsageError, naming the nearest kind, for an unknown one.
ComponentKind component_kind(std::string_view kind);

}  // namespace apps
