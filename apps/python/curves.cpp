// SPDX-License-Identifier: Apache-2.0

// The OTF of a sensor: at any frequencies, and along a direction as `mtf curve` has it.

#include "apps/sensor/otf_curves.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cmath>
#include <limits>

#include "apps/python/arrays.h"
#include "apps/python/job.h"
#include "apps/python/sensor.h"
#include "apps/python/topics.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/sensor/sensor_place.h"
#include "mtf/error.h"

namespace apps::python {
namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// A text that Python gave. Throws UsageError that names the argument.
std::string text_of(const py::object& given, const std::string& argument) {
  if (!py::isinstance<py::str>(given))
    throw mtf::UsageError(argument + ": " + py::str(py::repr(given)[py::slice(0, 80, 1)]).cast<std::string>() +
                          " is no text (one of cy/mm, cy/mrad, cy/px)");
  return given.cast<std::string>();
}

/// The unit of frequencies along a direction. Units that are known elsewhere are told what they are here.
std::string unit_of(const py::object& given) {
  const std::string unit = text_of(given, "unit");
  const std::string message = "unit: '" + unit + "' is not known (one of cy/mm, cy/mrad, cy/px); ";
  if (unit == "lp/mm") throw mtf::UsageError(message + "a line pair is a cycle: lp/mm is cy/mm");
  if (unit == "cy/rad" || unit == "lp/rad") throw mtf::UsageError(message + "1000 cy/rad are 1 cy/mrad");
  if (unit == "lp/mrad") throw mtf::UsageError(message + "a line pair is a cycle: lp/mrad is cy/mrad");
  return unit;
}

using Place = std::optional<std::array<double, 2>>;

mtf::FieldPoint<double> point_of(const Place& place) {
  return place ? mtf::FieldPoint<double>{(*place)[0], (*place)[1]} : mtf::FieldPoint<double>{};
}

/// fx and fy of one length, in the unit. They may be infinite; the OTF at a NaN is NaN.
py::array_t<std::complex<double>> otf(SensorHandle& sensor, const Doubles& fx, const Doubles& fy,
                                      const py::object& given_unit, const Place& field) {
  const std::string unit = unit_of(given_unit);
  if (fx.size() != fy.size()) throw mtf::UsageError("otf: fx and fy have different numbers of values");
  const std::shared_ptr<const mtf::io::SensorConfig> config = weighted(sensor);
  const mtf::System<double> system = system_at(config->system, point_of(field));
  const auto along_x = make_direction(system.frame, unit, 0.0).step.x;
  const auto along_y = make_direction(system.frame, unit, 90.0).step.y;
  py::array_t<std::complex<double>> result(fx.size());
  const double *x = fx.data(), *y = fy.data();
  std::complex<double>* to = result.mutable_data();
  const py::ssize_t count = fx.size();
  run_job([&](JobControl& control) {
    // Pieces, so that slow pupils can be interrupted.
    constexpr py::ssize_t kPiece = 4096;
    std::vector<mtf::Freq<double>> f;
    for (py::ssize_t begin = 0; begin < count; begin += kPiece) {
      control.check();
      const py::ssize_t end = std::min(count, begin + kPiece);
      f.clear();
      for (py::ssize_t i = begin; i < end; ++i) f.push_back({x[i] * along_x, y[i] * along_y});
      std::vector<mtf::Complex<double>> product(f.size(), {1.0, 0.0});
      for (const mtf::Stage stage : mtf::kStages) {
        const auto values = system.otf(system.list(stage), f);
        for (std::size_t i = 0; i < f.size(); ++i) product[i] = product[i] * values[i];
      }
      constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
      for (std::size_t i = 0; i < f.size(); ++i)
        to[begin + static_cast<py::ssize_t>(i)] = std::isnan(f[i].x) || std::isnan(f[i].y)
                                                      ? std::complex<double>(kUnknown, kUnknown)
                                                      : std::complex<double>(product[i].re, product[i].im);
    }
  });
  return result;
}

py::dict column_of(const OtfColumn& column) {
  py::array_t<std::complex<double>> values(static_cast<py::ssize_t>(column.otf.size()));
  for (std::size_t i = 0; i < column.otf.size(); ++i)
    values.mutable_data()[i] = {column.otf[i].re + 0.0, column.otf[i].im + 0.0};
  return py::dict("label"_a = column.label, "kind"_a = column.kind, "stage"_a = column.stage, "doc"_a = column.doc,
                  "real"_a = column.real, "otf"_a = values, "error"_a = to_numpy(column.error));
}

py::dict curves(SensorHandle& sensor, std::vector<double> frequency, double angle_deg, const py::object& given_unit,
                const Place& field) {
  const std::string unit = unit_of(given_unit);
  const std::shared_ptr<const mtf::io::SensorConfig> config = weighted(sensor);
  OtfCurves made;
  run_job([&](JobControl&) {
    made = otf_curves(system_at(config->system, point_of(field)), std::move(frequency),
                      make_direction(config->system.frame, unit, angle_deg));
  });
  py::list columns;
  for (const OtfColumn* column : made.columns()) columns.append(column_of(*column));
  return py::dict("name"_a = made.name, "unit"_a = made.direction.unit, "angle_deg"_a = made.direction.angle_deg,
                  "nyquist"_a = made.figures.nyquist, "cutoff"_a = made.figures.cutoff, "q"_a = made.figures.q,
                  "frequency"_a = to_numpy(made.frequency), "columns"_a = columns);
}

}  // namespace

std::shared_ptr<const mtf::io::SensorConfig> weighted(SensorHandle& sensor) {
  if (sensor.weighted) return sensor.weighted;
  if (!has_chain(*sensor.config) || !sensor.config->system.band) return sensor.weighted = sensor.config;
  require_unchanged(sensor);
  mtf::io::SensorConfig config = *sensor.config;
  {
    const py::gil_scoped_release free;
    config.system = at_its_place(config, [&] { return with_electron_rate(config.system, load_chain(config)); });
  }
  return sensor.weighted = std::make_shared<const mtf::io::SensorConfig>(std::move(config));
}

void add_curves(py::module_& module) {
  module.def("otf", &otf, "sensor"_a, "fx"_a, "fy"_a, "unit"_a, "field"_a = py::none());
  module.def("curves", &curves, "sensor"_a, "frequency"_a, "angle_deg"_a, "unit"_a, "field"_a = py::none());
}

}  // namespace apps::python
