// SPDX-License-Identifier: Apache-2.0
#include "apps/python/light_filter.h"

#include "apps/python/arrays.h"
#include "mtf/error.h"
#include "mtf/plan/plan.h"

namespace apps::python {

namespace py = pybind11;

std::function<void(mtf::io::Scene&)> light_filter(const void* function) {
  if (function == nullptr) return {};
  return [function](mtf::io::Scene& scene) {
    const py::gil_scoped_acquire held;
    auto* object = static_cast<PyObject*>(const_cast<void*>(function));  // NOLINT: Python objects count references
    const auto filter = py::reinterpret_borrow<py::function>(object);
    for (mtf::Image& plane : scene.planes)
      plane = image_of(plane_of(filter(to_numpy(std::move(plane))), "the filtered scene").view);
    scene.grid.width = scene.planes.front().width();
    scene.grid.height = scene.planes.front().height();
  };
}

SensorHandle canvas_sensor(const SensorHandle& sensor, const mtf::SampleGrid& scene) {
  mtf::io::SensorConfig config = *sensor.config;
  mtf::Frame<double>& frame = config.system.frame;
  const int columns = frame.columns, rows = frame.rows;
  frame.columns = frame.rows = 0;
  const mtf::SampleGrid held = mtf::detector_grid(config.system, scene);
  if (columns > held.width || rows > held.height)
    throw mtf::UsageError(
        "frame.format: [" + std::to_string(columns) + ", " + std::to_string(rows) + "] reaches beyond the scene of " +
        std::to_string(held.width) + " x " + std::to_string(held.height) +
        " pixels, which does not go with a component made of a general function; give a larger scene");
  frame.columns = columns > 0 ? columns : static_cast<int>(held.width);
  frame.rows = rows > 0 ? rows : static_cast<int>(held.height);
  config.scene.border = mtf::Border::periodic;
  return {std::make_shared<const mtf::io::SensorConfig>(std::move(config)), nullptr};
}

}  // namespace apps::python
