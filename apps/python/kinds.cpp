// SPDX-License-Identifier: Apache-2.0

// What a sensor file may hold, for the classes that the package makes of it.

#include <pybind11/stl.h>

#include "apps/kinds.h"
#include "apps/python/topics.h"
#include "apps/sensor/sensor_kinds.h"

namespace apps::python {
namespace {

py::dict as_dict(const Parameter& parameter) {
  return py::dict("name"_a = parameter.name, "type"_a = type_name(parameter.type), "unit"_a = parameter.unit,
                  "range"_a = range_of(parameter),
                  "words"_a = std::vector(parameter.words.begin(), parameter.words.end()),
                  "presence"_a = presence_of(parameter), "default"_a = parameter.default_value,
                  "example"_a = parameter.example, "doc"_a = parameter.doc);
}

py::list parameters_of(const std::vector<Parameter>& parameters) {
  py::list entries;
  for (const Parameter& parameter : parameters) entries.append(as_dict(parameter));
  return entries;
}

py::list stages_of(const mtf::Stages& stages) {
  py::list names;
  for (const mtf::Stage stage : mtf::kStages)
    if (stages.allows(stage)) names.append(std::string(mtf::stage_name(stage)));
  return names;
}

py::dict kinds() {
  const SensorKinds all = sensor_kinds();
  py::list components, tables;
  for (const ComponentKind& kind : all.components) {
    components.append(py::dict("kind"_a = kind.kind, "doc"_a = kind.doc, "notes"_a = kind.notes,
                               "stages"_a = stages_of(kind.stages), "parameters"_a = parameters_of(kind.parameters),
                               "example"_a = kind.example));
  }
  for (const TableKind& kind : all.tables) {
    tables.append(py::dict("name"_a = kind.name, "doc"_a = kind.doc, "condition"_a = kind.condition,
                           "parameters"_a = parameters_of(kind.parameters)));
  }
  return py::dict("components"_a = components, "tables"_a = tables);
}

}  // namespace

void add_kinds(py::module_& module) { module.def("kinds", &kinds); }

}  // namespace apps::python
