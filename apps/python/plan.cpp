// SPDX-License-Identifier: Apache-2.0

// Plans: a sensor's OTF compiled for scenes of one size, to filter many of them.

#include <pybind11/stl.h>

#include <functional>
#include <mutex>

#include "apps/python/arrays.h"
#include "apps/python/job.h"
#include "apps/python/sensor.h"
#include "apps/python/topics.h"
#include "apps/simulate/live_simulation.h"
#include "apps/simulate/simulate_parts.h"
#include "mtf/error.h"
#include "mtf/plan/sensor_plan.h"

namespace apps::python {

namespace {

/// The warnings, and those of a device that is not there or has failed.
std::vector<std::string> with_device(std::vector<std::string> warnings, const std::string& note,
                                     const mtf::DeviceChoice& device) {
  for (const std::string& more : {note, device_words(device)})
    if (!more.empty()) warnings.push_back(more);
  return warnings;
}

/// A linear plan, whose runs need no memory of their own result where the caller gives it.
class LinearPlan {
 public:
  LinearPlan(const SensorHandle& sensor, std::int64_t width, std::int64_t height, const SampleWords& sample,
             const std::optional<py::object>& scene, std::optional<double> tolerance, bool measure,
             const std::string& device, int threads)
      : sensor_(sensor.config) {
    std::optional<PlaneView> plane;
    if (scene) plane = plane_of(*scene, "scene");
    const mtf::SampleGrid grid = grid_of(*sensor_, width, height, sample);
    mtf::PlanOptions options{.tolerance = tolerance.value_or(1e-4),
                             .border = sensor_->scene.border,
                             .rigor = measure ? mtf::Rigor::measure : mtf::Rigor::estimate,
                             .aperture = mtf::io::scene_aperture(sensor_->scene, grid),
                             .threads = threads};
    run_job([&](JobControl& control) {
      options.device = mtf::choose_device(device, note_);
      options.progress = [&](std::int64_t) { control.check(); };
      if (plane) options.scene = mtf::summarise(plane->view, options.border, sensor_->scene.border_value);
      mtf::SensorPlan made = compile_reachable(tolerance.has_value(), SensorRun{}, options, warnings_,
                                               [&] { return mtf::compile_sensor(sensor_->system, grid, options); });
      made.options.progress = {};
      plan_ = std::make_shared<const mtf::SensorPlan>(std::move(made));
    });
  }

  LinearPlan with(const SensorHandle& other) const {
    LinearPlan changed = *this;
    changed.sensor_ = other.config;
    const py::gil_scoped_release free;
    changed.plan_ = std::make_shared<const mtf::SensorPlan>(plan_->with(other.config->system));
    return changed;
  }

  py::object run(const py::object& scene, const py::object& out, int threads) const {
    const PlaneView in = plane_of(scene, "scene");
    const mtf::SampleGrid& grid = plan_->out();
    if (out.is_none()) {
      mtf::Image image(grid.width, grid.height);
      filter(in.view, image.view(), threads);
      return to_numpy(std::move(image));
    }
    const mtf::ImageView<float> target = target_of(out, grid.width, grid.height, "out");
    require_apart(in.view, target);
    filter(in.view, target, threads);
    return out;
  }

  const mtf::SensorPlan& plan() const { return *plan_; }
  std::vector<std::string> warnings() const { return with_device(warnings_, note_, plan_->options.device); }
  std::string explain() const {
    std::string text = plan_->presample.explain();
    if (plan_->readout) text += "\nreadout\n" + plan_->readout->explain();
    if (plan_->post) text += "\nfilters after the sampling\n" + plan_->post->explain();
    return text;
  }

 private:
  /// The output may take the place of the input, from its start on; elsewhere it would be read after it was written.
  static void require_apart(const mtf::ImageView<const float>& in, const mtf::ImageView<float>& out) {
    const float* in_end = in.row(in.height - 1) + in.width;
    const float* out_end = out.row(out.height - 1) + out.width;
    const bool overlap = std::less<>()(in.data, out_end) && std::less<>()(static_cast<const float*>(out.data), in_end);
    if (overlap && in.data != out.data)
      throw mtf::UsageError("out: overlaps the scene; let it begin where the scene does, or lie apart from it");
  }

  void filter(const mtf::ImageView<const float>& in, const mtf::ImageView<float>& out, int threads) const {
    const py::gil_scoped_release free;
    const double border_value = sensor_->scene.border_value;
    plan_->presample.run(in, out, border_value, threads);
    for (const auto* after : {&plan_->readout, &plan_->post})
      if (*after) (*after)->run(out, out, border_value, threads);
  }

  std::shared_ptr<const mtf::io::SensorConfig> sensor_;
  std::shared_ptr<const mtf::SensorPlan> plan_;
  std::vector<std::string> warnings_;
  std::string note_;  ///< why there is no device
};

/// A sensor with [detector]: image after image through its whole chain. One image is made at a time.
class ChainPlan {
 public:
  /// `filter`: of light, before everything of the sensor; a function, or None.
  ChainPlan(const SimulateOptions& options, std::string note, const SampleWords& sample, mtf::io::Quantity quantity,
            const py::object& filter)
      : device_(options.device),
        note_(std::move(note)),
        sample_(sample),
        quantity_(quantity),
        filter_(filter),
        live_({.filter = light_filter(filter)}, options) {}

  py::object run(const SensorHandle& sensor, const py::object& scene, const py::object& out, std::int64_t frame) {
    const PlaneView in = plane_of(scene, "scene");
    require_unchanged(sensor);
    mtf::io::Scene made;
    made.quantity = quantity_;
    made.grid = grid_of(*sensor.config, in.view.width, in.view.height, sample_);
    made.names = {"Y"};
    mtf::Image image;
    {
      const py::gil_scoped_release free;
      const std::lock_guard lock(*mutex_);
      made.planes.push_back(image_of(in.view));
      image = std::move(live_.image(std::move(made), sensor.config, frame).planes.front());
    }
    if (out.is_none()) return to_numpy(std::move(image));
    const mtf::ImageView<float> target = target_of(out, image.width(), image.height(), "out");
    for (std::int64_t y = 0; y < image.height(); ++y)
      std::copy(image.view().row(y), image.view().row(y) + image.width(), target.row(y));
    return out;
  }

  const mtf::SensorPlan& plan() const { return live_.plan(); }
  std::vector<std::string> warnings() const { return with_device(live_.warnings(), note_, device_); }
  int compiled() const { return live_.plans_compiled(); }
  int updated() const { return live_.plans_updated(); }

 private:
  mtf::DeviceChoice device_;
  std::string note_;  ///< why it is none
  SampleWords sample_;
  mtf::io::Quantity quantity_;
  py::object filter_;  // which live_ calls
  LiveSimulation live_;
  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();
};

std::unique_ptr<ChainPlan> chain_plan(const SampleWords& sample, const std::string& quantity,
                                      std::optional<double> tolerance, const std::optional<std::string>& stage,
                                      const py::object& filter, const std::string& device, int threads) {
  SimulateOptions options{.tolerance = tolerance, .threads = threads};
  std::string told;
  {
    const py::gil_scoped_release free;
    options.device = mtf::choose_device(device, told);
  }
  if (stage) options.stage = output_stage(*stage);
  return std::make_unique<ChainPlan>(options, std::move(told), sample, quantity_of(quantity), filter);
}

/// Width, height and steps in um.
py::tuple as_tuple(const mtf::SampleGrid& grid) {
  return py::make_tuple(grid.width, grid.height, grid.step_x_um, grid.step_y_um);
}

}  // namespace

void add_plan(py::module_& module) {
  py::class_<LinearPlan>(module, "LinearPlan", "A compiled OTF.")
      .def(py::init<const SensorHandle&, std::int64_t, std::int64_t, const SampleWords&,
                    const std::optional<py::object>&, std::optional<double>, bool, const std::string&, int>(),
           "sensor"_a, "width"_a, "height"_a, "sample"_a, "scene"_a, "tolerance"_a, "measure"_a, "device"_a,
           "threads"_a)
      .def("replaced", &LinearPlan::with, "sensor"_a)
      .def("run", &LinearPlan::run, "scene"_a, "out"_a, "threads"_a)
      .def("explain", &LinearPlan::explain)
      .def_property_readonly("promised", [](const LinearPlan& p) { return p.plan().predicted_error; })
      .def_property_readonly("tolerance", [](const LinearPlan& p) { return p.plan().options.tolerance; })
      .def_property_readonly("method", [](const LinearPlan& p) { return p.plan().presample.report().method; })
      .def_property_readonly("updated", [](const LinearPlan& p) { return p.plan().updated; })
      .def_property_readonly("warnings", &LinearPlan::warnings)
      .def_property_readonly("scene_grid", [](const LinearPlan& p) { return as_tuple(p.plan().in()); })
      .def_property_readonly("grid", [](const LinearPlan& p) { return as_tuple(p.plan().out()); });
  py::class_<ChainPlan>(module, "ChainPlan", "A sensor's chain, image after image.")
      .def(py::init(&chain_plan), "sample"_a, "quantity"_a, "tolerance"_a, "stage"_a, "filter"_a, "device"_a,
           "threads"_a)
      .def("run", &ChainPlan::run, "sensor"_a, "scene"_a, "out"_a, "frame"_a)
      .def_property_readonly("promised", [](const ChainPlan& p) { return p.plan().predicted_error; })
      .def_property_readonly("compiled", &ChainPlan::compiled)
      .def_property_readonly("updated", &ChainPlan::updated)
      .def_property_readonly("warnings", &ChainPlan::warnings)
      .def_property_readonly("grid", [](const ChainPlan& p) { return as_tuple(p.plan().out()); });
}

}  // namespace apps::python
