// SPDX-License-Identifier: Apache-2.0

// Noise by (seed, frame, pixel): the numbers of the chain, for images that Python makes.

#include "radiometry/stages/noise/noise.h"

#include <pybind11/stl.h>

#include <algorithm>

#include "apps/python/arrays.h"
#include "apps/python/topics.h"
#include "mtf/error.h"

namespace apps::python {
namespace {

namespace py = pybind11;

radiometry::NoiseKey key_of(std::uint64_t seed, std::int64_t frame) {
  if (frame < 0 || frame > 0x7fffffff)
    throw mtf::UsageError("frame " + std::to_string(frame) + ": noise is numbered from 0 to 2147483647");
  return {seed, static_cast<std::uint32_t>(frame)};
}

py::array gaussian(std::int64_t rows, std::int64_t columns, double sd, std::uint64_t seed, std::int64_t frame,
                   std::int64_t x, std::int64_t y, int threads) {
  if (rows < 1 || columns < 1 || rows > (std::int64_t{1} << 31) / std::max<std::int64_t>(columns, 1))
    throw mtf::UsageError("shape: (" + std::to_string(rows) + ", " + std::to_string(columns) +
                          ") is empty or above 2^31 pixels");
  mtf::Image image(columns, rows);
  {
    const py::gil_scoped_release free;
    std::fill(image.data(), image.data() + image.size(), 0.0F);
    radiometry::add_gaussian(image.view(), sd, key_of(seed, frame), radiometry::Stream::read, {x, y}, threads);
  }
  return to_numpy(std::move(image));
}

py::array shot(const py::object& mean, std::uint64_t seed, std::int64_t frame, std::int64_t x, std::int64_t y,
               int threads) {
  const PlaneView plane = plane_of(mean, "mean");
  mtf::Image image;
  {
    const py::gil_scoped_release free;
    image = image_of(plane.view);
    radiometry::shot_noise(image.view(), key_of(seed, frame), {x, y}, threads);
  }
  return to_numpy(std::move(image));
}

}  // namespace

void add_noise(py::module_& module) {
  module.def("gaussian_noise", &gaussian, py::arg("rows"), py::arg("columns"), py::arg("sd"), py::arg("seed"),
             py::arg("frame"), py::arg("x"), py::arg("y"), py::arg("threads"));
  module.def("shot_noise", &shot, py::arg("mean"), py::arg("seed"), py::arg("frame"), py::arg("x"), py::arg("y"),
             py::arg("threads"));
}

}  // namespace apps::python
