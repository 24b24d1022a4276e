// SPDX-License-Identifier: Apache-2.0

// What a sensor file may hold, for the classes that the package makes of it.

#include <pybind11/stl.h>

#include "apps/kinds.h"
#include "apps/python/topics.h"
#include "apps/sensor/sensor_kinds.h"

namespace apps::python {
namespace {

namespace py = pybind11;

py::dict as_dict(const Parameter& parameter) {
  py::dict entry;
  entry["name"] = parameter.name;
  entry["type"] = type_name(parameter.type);
  entry["unit"] = parameter.unit;
  entry["range"] = range_of(parameter);
  entry["words"] = std::vector(parameter.words.begin(), parameter.words.end());
  entry["presence"] = presence_of(parameter);
  entry["default"] = parameter.default_value;
  entry["example"] = parameter.example;
  entry["doc"] = parameter.doc;
  return entry;
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
    py::dict entry;
    entry["kind"] = kind.kind;
    entry["doc"] = kind.doc;
    entry["notes"] = kind.notes;
    entry["stages"] = stages_of(kind.stages);
    entry["parameters"] = parameters_of(kind.parameters);
    entry["example"] = kind.example;
    components.append(entry);
  }
  for (const TableKind& kind : all.tables) {
    py::dict entry;
    entry["name"] = kind.name;
    entry["doc"] = kind.doc;
    entry["condition"] = kind.condition;
    entry["parameters"] = parameters_of(kind.parameters);
    tables.append(entry);
  }
  py::dict result;
  result["components"] = components;
  result["tables"] = tables;
  return result;
}

}  // namespace

void add_kinds(py::module_& module) { module.def("kinds", &kinds); }

}  // namespace apps::python
