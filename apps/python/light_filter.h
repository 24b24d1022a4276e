// SPDX-License-Identifier: Apache-2.0
#pragma once

// A Python function that filters a scene before everything of the sensor: what general functions as components need
// (mtfkit/canvas.py).

#include <pybind11/pybind11.h>

#include "apps/python/sensor.h"
#include "apps/simulate/scene_source.h"

namespace apps::python {

/// Gives each plane of the scene to the function and takes the one that it returns, of any size. `function` is an
/// object that the caller keeps, or null for no filter. What the function throws ends the work.
std::function<void(mtf::io::Scene&)> light_filter(const void* function);

/// The sensor for the canvas that such a filter makes: a scene that repeats, of which the image is that of the first
/// `width` x `height` samples. Throws UsageError where [frame] format reaches beyond them.
SensorHandle canvas_sensor(const SensorHandle& sensor, const mtf::SampleGrid& scene);

}  // namespace apps::python
