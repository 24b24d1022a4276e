// SPDX-License-Identifier: Apache-2.0

// A sensor's parameters from images of edges and point sources and from curves: the call of `mtf fit`.

#include "calib/fit/fit.h"

#include <pybind11/stl.h>

#include "apps/edges/fit_command.h"
#include "apps/python/edge_images.h"
#include "apps/python/job.h"
#include "apps/python/sensor.h"
#include "apps/python/topics.h"
#include "mtf/error.h"

namespace apps::python {
namespace {

using mtf::io::SensorConfig;

/// An image and the sensor that it was taken with; none: the one that is fitted.
using GivenImage = std::pair<py::object, std::optional<SensorHandle>>;

/// name, frequency, mtf, sd (one, or one each), unit, angle in degrees
using GivenCurve =
    std::tuple<std::string, std::vector<double>, std::vector<double>, std::vector<double>, std::string, double>;

struct FitHandle {
  std::shared_ptr<const SensorConfig> sensor;
  std::vector<std::string> files;
  calib::FitResult result;
};

/// The images with the index of their sensor among the conditions, the first of which is the sensor itself.
std::vector<std::pair<EdgeImage, std::size_t>> images_of(const std::vector<GivenImage>& given, const char* what,
                                                         std::vector<mtf::System<double>>& conditions) {
  std::vector<std::pair<EdgeImage, std::size_t>> images;
  for (const auto& [object, sensor] : given) {
    const std::string name = std::string(what) + "[" + std::to_string(images.size()) + "]";
    std::size_t condition = 0;
    if (sensor) {
      SensorHandle own = *sensor;
      condition = conditions.size();
      conditions.push_back(weighted(own)->system);
    }
    images.emplace_back(edge_image(object, name), condition);
  }
  return images;
}

calib::CurveData curve_of(const GivenCurve& given) {
  const auto& [name, frequency, mtf, sd, unit, angle_deg] = given;
  calib::CurveData data{.name = name, .angle_deg = angle_deg, .frequency = frequency, .mtf = mtf, .sd = sd};
  data.unit = mtf::find_unit(unit == "lp/mm" ? "cy/mm" : unit);  // a pair of lines is a cycle, as in tables of curves
  if (data.unit == nullptr || data.unit->dimension != mtf::Dimension::frequency)
    throw mtf::UsageError("curve '" + name + "': the unit '" + unit +
                          "' is not known (one of cy/mm, lp/mm, cy/mrad, cy/px)" +
                          (unit == "cy/rad" ? "; 1000 cy/rad are 1 cy/mrad" : ""));
  if (frequency.size() != mtf.size() || frequency.empty() || (sd.size() != 1 && sd.size() != mtf.size()))
    throw mtf::UsageError("curve '" + name + "': frequency, mtf and sd have different lengths, or none");
  return data;
}

std::unique_ptr<FitHandle> fit_sensor(SensorHandle& sensor, const std::vector<GivenImage>& edges,
                                      const std::vector<GivenImage>& spots, const std::vector<GivenCurve>& curves,
                                      const py::dict& words, bool robust, int starts, bool profile, bool residual_otf,
                                      int threads, const py::object& progress) {
  auto fit = std::make_unique<FitHandle>();
  fit->sensor = sensor.config;
  if (edges.empty() && curves.empty() && spots.empty())
    throw mtf::UsageError("fit: no data; give images of edges, curves, or images of point sources");
  const std::vector<calib::FitParameter> parameters = fit_parameters(*sensor.config);
  LoadedData loaded;
  std::vector<mtf::System<double>> conditions{weighted(sensor)->system};
  auto edge_images = images_of(edges, "edges", conditions);
  auto spot_images = images_of(spots, "spots", conditions);
  const EdgeInput input = edge_input_of(words);
  for (const GivenCurve& curve : curves) loaded.data.curves.push_back(curve_of(curve));
  run_job([&](JobControl& control) {
    const ProgressCall report(progress, control);
    for (auto& [image, condition] : edge_images) {
      if (image.on_disk) loaded.files.push_back(image.name);
      for (EdgePlane& plane : planes_of(std::move(image), input)) {
        control.check();
        apps::add_edges(loaded, std::move(plane), condition, threads);
      }
    }
    for (auto& [image, condition] : spot_images) {
      if (image.on_disk) loaded.files.push_back(image.name);
      for (EdgePlane& plane : planes_of(std::move(image), input, Regions::none))
        apps::add_spot(loaded, std::move(plane), condition);
    }
    loaded.data.conditions = conditions;
    std::exception_ptr failure;  // of the Python function; it does not pass through the solver
    const calib::FitOptions how{.robust = robust,
                                .starts = starts,
                                .profile = profile,
                                .residual_otf = residual_otf,
                                .richer_models = true,
                                .threads = threads,
                                .progress = [&](double share) {
                                  try {
                                    if (!failure && !control.stopped()) report(share);
                                  } catch (...) {
                                    failure = std::current_exception();
                                  }
                                  return !failure && !control.stopped();
                                }};
    fit->result = calib::fit(loaded.data, parameters, how);
    if (failure) std::rethrow_exception(failure);
  });
  fit->result.warnings.insert(fit->result.warnings.begin(), loaded.warnings.begin(), loaded.warnings.end());
  fit->files = loaded.files;
  return fit;
}

SensorHandle fitted_sensor(const FitHandle& fit) {
  return read_sensor_text(fitted_config(fit.result, *fit.sensor, fit.files, fit.sensor->file), fit.sensor->file);
}

/// Residuals of an edge or a point source, in standard deviations of a pixel; none for a curve.
py::list residuals_of(const FitHandle& fit) {
  py::list list;
  for (const calib::FitResiduals& data : fit.result.data)
    if (data.residual.size() > 0) list.append(py::make_tuple(data.name, to_numpy(data.residual.clone())));
  return list;
}

}  // namespace

void add_fit(py::module_& module) {
  py::class_<FitHandle>(module, "FitRun", "A finished fit.")
      .def_property_readonly(
          "report", [](const FitHandle& f) { return json_document(fit_report(f.result, *f.sensor, f.files), -1); })
      .def_property_readonly("table", [](const FitHandle& f) { return fit_table(f.result); })
      .def_property_readonly("sensor", &fitted_sensor)
      .def_property_readonly("residuals", &residuals_of);
  module.def("fit", &fit_sensor, "sensor"_a, "edges"_a, "spots"_a, "curves"_a, "words"_a, "robust"_a, "starts"_a,
             "profile"_a, "residual_otf"_a, "threads"_a, "progress"_a);
}

}  // namespace apps::python
