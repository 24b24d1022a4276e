// SPDX-License-Identifier: Apache-2.0

// Sensor files: read, changed, written, explained, checked; and what they may hold, for the classes that the package
// makes of it.

#include "apps/python/sensor.h"

#include <pybind11/stl.h>

#include "apps/budget_table.h"
#include "apps/config_command.h"
#include "apps/kinds.h"
#include "apps/python/topics.h"
#include "apps/sensor/sensor_air.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/sensor/sensor_kinds.h"
#include "apps/sensor/sensor_place.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/config/config_edit.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/config/replace_value.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/sha256.h"

namespace apps::python {
namespace {

using mtf::io::SensorConfig;

py::dict as_dict(const mtf::io::Diagnostic& diagnostic) {
  return py::dict("severity"_a = diagnostic.error    ? "error"
                                 : diagnostic.remark ? "note"
                                                     : "warning",
                  "line"_a = diagnostic.position.line, "column"_a = diagnostic.position.column,
                  "path"_a = diagnostic.path, "text"_a = diagnostic.text);
}

bool temperature(const mtf::Unit& unit) {
  return unit.dimension == mtf::Dimension::temperature || unit.dimension == mtf::Dimension::temperature_difference;
}

std::string contents_of(const std::string& file) {
  try {
    return mtf::io::sha256_file(file);
  } catch (const mtf::RuntimeError&) {
    return "";  // what needs the file says so
  }
}

SensorHandle handle_of(SensorConfig config) {
  std::vector<std::string> contents;
  for (const std::string& file : config.files) contents.push_back(contents_of(file));
  return {std::make_shared<const SensorConfig>(std::move(config)), nullptr, std::move(contents)};
}

SensorHandle replaced(const SensorHandle& sensor, const std::vector<std::pair<std::string, std::string>>& values) {
  SensorConfig config = *sensor.config;
  for (const auto& [parameter, value] : values) config = mtf::io::replaced(config, parameter, value);
  return handle_of(std::move(config));
}

std::vector<std::string> parameters(const SensorHandle& sensor) {
  std::vector<std::string> names;
  for (const auto& [name, target] : mtf::io::cfg::targets_of(*sensor.config)) names.push_back(name);
  return names;
}

/// "" for a parameter that the file leaves at its default; throws UsageError for other names that it does not have.
std::string stated(const SensorHandle& sensor, const std::string& name) {
  std::string value = mtf::io::stated_value(*sensor.config, name);
  if (!value.empty()) return value;
  const mtf::io::cfg::Targets targets = mtf::io::cfg::targets_of(*sensor.config);
  if (!mtf::io::cfg::find_target(targets, name))
    throw mtf::UsageError(sensor.config->file + ": " + mtf::io::cfg::unknown_parameter(targets, name));
  return value;
}

py::list check(const SensorHandle& sensor) {
  const Verdict verdict = sensor_verdict(sensor.config->text, sensor.config->file);
  py::list found;
  for (const mtf::io::Diagnostic& diagnostic : verdict.diagnostics) found.append(as_dict(diagnostic));
  return found;
}

py::dict budget(const SensorHandle& sensor, double temperature_k) {
  BudgetTable table;
  {
    const py::gil_scoped_release free;
    require_unchanged(sensor);
    table = budget_table(*sensor.config, load_chain(*sensor.config), temperature_k);
  }
  py::list rows;
  for (const radiometry::BudgetRow& row : table.rows)
    rows.append(py::make_tuple(row.name, row.value, row.unit, row.doc, row.refused));
  return py::dict("rows"_a = rows, "notes"_a = table.notes, "saturated"_a = table.numbers.saturation.saturated(),
                  "saturation"_a = words(table.numbers.saturation));
}

std::string explain(const SensorHandle& sensor) {
  const py::gil_scoped_release free;
  return mtf::io::explain_config(*sensor.config) + explain_chain(*sensor.config);
}

double converted(double value, const std::string& unit, const std::string& to) {
  if (unit == to) return value;
  const mtf::Unit *from = mtf::find_unit(unit), *target = mtf::find_unit(to);
  for (const auto& [found, name] : {std::pair(from, &unit), std::pair(target, &to)})
    if (found == nullptr) throw mtf::UsageError("unit: '" + *name + "' is not known");
  if (from->dimension != target->dimension && !(temperature(*from) && temperature(*target)))
    throw mtf::UsageError("unit: " + unit + " and " + to + " are units of different things");
  return value * from->factor / target->factor;
}

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

void require_unchanged(const SensorHandle& sensor) {
  for (std::size_t i = 0; i < sensor.contents.size(); ++i)
    if (const std::string& file = sensor.config->files[i]; contents_of(file) != sensor.contents[i])
      throw mtf::RuntimeError(one_line(file) + ": is not what it was when the sensor was read; read the sensor again");
}

SensorHandle read_sensor_text(const std::string& text, const std::string& file) {
  mtf::io::ConfigResult result = mtf::io::parse_config(text, file, sensor_schema());
  mtf::io::cfg::require_no_errors(result.diagnostics, file);
  return handle_of(std::move(result.config));
}

mtf::SampleGrid grid_of(const mtf::io::SensorConfig& sensor, std::int64_t width, std::int64_t height,
                        const SampleWords& sample) {
  mtf::SampleGrid grid{width, height, 0.0, 0.0};
  if (sample) {
    const auto um = [&](const std::string& text, mtf::Axis axis) {
      const mtf::Quantity given = mtf::parse_quantity(text, mtf::Dimension::extent);
      const double step = mtf::Extent<double>(given.value, given.unit).um(sensor.system.frame, axis);
      if (!(step > 0.0)) throw mtf::UsageError("sample: " + text + " is not above zero");
      return step;
    };
    grid.step_x_um = um(sample->first, mtf::Axis::x);
    grid.step_y_um = um(sample->second, mtf::Axis::y);
    return grid;
  }
  if (!sensor.scene.sample_x_um || !sensor.scene.sample_y_um)
    throw mtf::UsageError(
        "sample: the spacing of the scene's samples is not known; give sample=\"3.75 um\" (at the focal plane, as an "
        "angle or in pixels), or state it in [scene] of the sensor");
  grid.step_x_um = *sensor.scene.sample_x_um;
  grid.step_y_um = *sensor.scene.sample_y_um;
  return grid;
}

mtf::io::Quantity quantity_of(const std::string& name) {
  using mtf::io::Quantity;
  for (const Quantity quantity :
       {Quantity::radiance, Quantity::photon_radiance, Quantity::temperature, Quantity::counts})
    if (mtf::io::quantity_name(quantity) == name) return quantity;
  throw mtf::UsageError("quantity: '" + name +
                        "' is not known for values in memory (one of radiance, photon_radiance, temperature, counts)");
}

radiometry::OutputStage output_stage(const std::string& name) {
  std::string all;
  for (std::size_t i = 0; i < radiometry::kOutputStageNames.size(); ++i) {
    if (radiometry::kOutputStageNames[i] == name) return static_cast<radiometry::OutputStage>(i);
    all += (all.empty() ? "" : ", ") + std::string(radiometry::kOutputStageNames[i]);
  }
  throw mtf::UsageError("stage: '" + name + "' is not known (one of " + all + ")");
}

void add_sensor(py::module_& module) {
  py::class_<SensorHandle>(module, "SensorFile", "A sensor file in memory.")
      .def(py::init([](const std::string& text, const FileName& file) { return read_sensor_text(text, file); }),
           "text"_a, "file"_a)
      .def_property_readonly("text", [](const SensorHandle& s) { return s.config->text; })
      .def_property_readonly("file", [](const SensorHandle& s) { return FileName{s.config->file}; })
      .def_property_readonly("name", [](const SensorHandle& s) { return s.config->system.name; })
      .def_property_readonly("sha256", [](const SensorHandle& s) { return s.config->sha256; })
      .def_property_readonly("over_field",
                             [](const SensorHandle& s) { return mtf::names_over_field(s.config->system); })
      .def_property_readonly("has_chain", [](const SensorHandle& s) { return has_chain(*s.config); })
      .def_property_readonly("quantity",
                             [](const SensorHandle& s) {
                               const auto& quantity = s.config->scene.quantity;
                               return quantity ? std::string(mtf::io::quantity_name(*quantity)) : std::string();
                             })
      .def_property_readonly("files",
                             [](const SensorHandle& s) {
                               std::vector<FileName> names;
                               for (std::string& file : files_of(*s.config)) names.push_back({std::move(file)});
                               return names;
                             })
      .def_property_readonly("contents", [](const SensorHandle& s) { return s.contents; })
      .def("replaced", &replaced, "values"_a)
      .def(
          "canonical",
          [](const SensorHandle& s, const FileName& destination) {
            return mtf::io::write_config(*s.config, destination);
          },
          "destination"_a)
      .def("stated", &stated, "parameter"_a)
      .def("parameters", &parameters)
      .def("explain", &explain)
      .def("check", &check)
      .def("budget", &budget, "temperature_k"_a);
  module.def("kinds", &kinds);
  module.def("starter_config", &mtf::io::starter_config);
  module.def(
      "read_text", [](const FileName& file) { return mtf::io::read_text_file(file, std::size_t{1} << 20); }, "file"_a);
  module.def(
      "write_text", [](const FileName& file, const std::string& text) { mtf::io::write_text_file(file, text); },
      "file"_a, "text"_a);
  const auto reads = [](mtf::Dimension dimension, const char* unit) {
    return
        [dimension, unit](const std::string& text) { return mtf::convert(mtf::parse_quantity(text, dimension), unit); };
  };
  module.def("to_kelvin", reads(mtf::Dimension::temperature, "K"), "text"_a);
  module.def("angle_deg", reads(mtf::Dimension::angle, "deg"), "text"_a);
  module.def("length_um", reads(mtf::Dimension::length, "um"), "text"_a);
  module.def("convert", &converted, "value"_a, "unit"_a, "to"_a);
}

}  // namespace apps::python
