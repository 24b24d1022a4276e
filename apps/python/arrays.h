// SPDX-License-Identifier: Apache-2.0
#pragma once

// Between numpy arrays and the images of the toolkit. A plane is float32, row after row, and its rows may lie apart: an
// array or a slice of that kind is used where it lies, any other number is converted once.

#include <pybind11/numpy.h>

#include <functional>
#include <string>
#include <vector>

#include "mtf/io/scene.h"

namespace apps::python {

/// A view of an array's values, which keeps the array alive.
struct PlaneView {
  pybind11::object array;
  mtf::ImageView<const float> view;
};

/// A plane of numbers. `name` is what messages call it. Throws UsageError for what is no 2-D array of numbers: other
/// dimensions, no values, objects, text, complex numbers, a masked array.
PlaneView plane_of(const pybind11::object& array, const std::string& name);

/// The same to write into: float32 of that size, and nothing is converted.
mtf::ImageView<float> target_of(const pybind11::object& array, std::int64_t width, std::int64_t height,
                                const std::string& name);

/// A copy of the values as an image of its own.
mtf::Image image_of(const mtf::ImageView<const float>& view);

/// An array that owns the image; nothing is copied.
pybind11::array to_numpy(mtf::Image&& image);

/// An array that owns the numbers; nothing is copied.
pybind11::array to_numpy(std::vector<double>&& numbers);
pybind11::array to_numpy(const std::vector<double>& numbers);

/// A Python function that filters a scene before everything of the sensor, as components that are general functions
/// need it (mtfkit/canvas.py): it takes each plane of the scene and returns one of any size. `function` is kept by the
/// caller, None for no filter. What the function throws ends the work.
std::function<void(mtf::io::Scene&)> light_filter(const pybind11::object& function);

}  // namespace apps::python
