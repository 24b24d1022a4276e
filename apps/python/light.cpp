// SPDX-License-Identifier: Apache-2.0

// Blackbodies, at a wavelength, in a band, and through curves.

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>

#include "apps/python/arrays.h"
#include "apps/python/topics.h"
#include "mtf/error.h"
#include "radiometry/light/band_response.h"
#include "radiometry/light/blackbody.h"
#include "radiometry/stages/noise/noise.h"

namespace apps::python {
namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using radiometry::BandResponse;
using radiometry::Flux;

Flux flux_of(const std::string& name) {
  if (name == "watts") return Flux::watts;
  if (name == "photons") return Flux::photons;
  throw mtf::UsageError("flux: '" + name + "' is not known (one of watts, photons)");
}

/// The function at each pair of values; all arrays have one length.
template <class F>
Doubles at_each(const Doubles& a, const Doubles& b, const F& function) {
  if (a.size() != b.size()) throw mtf::UsageError("arrays of different lengths");
  Doubles result(a.size());
  const double *x = a.data(), *y = b.data();
  double* to = result.mutable_data();
  const py::ssize_t count = a.size();
  const py::gil_scoped_release free;
  for (py::ssize_t i = 0; i < count; ++i) to[i] = function(x[i], y[i]);
  return result;
}

/// At wavelengths in um and temperatures in K, or radiances.
Doubles at_wavelength(const std::string& what, const std::string& flux_name, const Doubles& wavelength_um,
                      const Doubles& other) {
  const Flux flux = flux_of(flux_name);
  if (what == "planck")
    return at_each(wavelength_um, other, [&](double l, double t) { return radiometry::planck(flux, l, t); });
  if (what == "log_planck")
    return at_each(wavelength_um, other, [&](double l, double t) { return radiometry::log_planck(flux, l, t); });
  if (what == "planck_derivative")
    return at_each(wavelength_um, other, [&](double l, double t) { return radiometry::planck_derivative(flux, l, t); });
  return at_each(wavelength_um, other,
                 [&](double l, double r) { return radiometry::brightness_temperature(flux, l, r); });
}

Doubles in_band(const std::string& what, const std::string& flux_name, double lo_um, double hi_um,
                const Doubles& other) {
  const Flux flux = flux_of(flux_name);
  const auto at = [&](const auto& function) {
    return at_each(other, other, [&](double value, double) { return function(value); });
  };
  if (what == "radiance") return at([&](double t) { return radiometry::band_radiance(flux, lo_um, hi_um, t); });
  if (what == "derivative") return at([&](double t) { return radiometry::band_derivative(flux, lo_um, hi_um, t); });
  return at([&](double r) { return radiometry::band_temperature(flux, lo_um, hi_um, r); });
}

BandResponse response(double lo_um, double hi_um,
                      const std::vector<std::pair<std::vector<double>, std::vector<double>>>& curves) {
  std::vector<radiometry::Spectrum> factors;
  for (const auto& [wavelength_um, value] : curves)
    factors.push_back(radiometry::make_spectrum("curve " + std::to_string(factors.size() + 1), wavelength_um, value));
  return {{lo_um, hi_um}, factors};
}

Doubles response_radiance(const BandResponse& band, const std::string& flux_name, const Doubles& temperature_k,
                          bool derivative) {
  const Flux flux = flux_of(flux_name);
  return at_each(temperature_k, temperature_k,
                 [&](double t, double) { return derivative ? band.derivative(flux, t) : band.radiance(flux, t); });
}

// Noise by (seed, frame, pixel): the numbers of the chain, for images that Python makes.

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

void add_light(py::module_& module) {
  module.def("blackbody", &at_wavelength, "what"_a, "flux"_a, "wavelength_um"_a, "other"_a);
  module.def("blackbody_band", &in_band, "what"_a, "flux"_a, "lo_um"_a, "hi_um"_a, "other"_a);
  py::class_<BandResponse>(module, "BandResponse", "A product of curves over a band.")
      .def(py::init(&response), "lo_um"_a, "hi_um"_a, "curves"_a)
      .def_property_readonly("range_um",
                             [](const BandResponse& b) { return py::make_tuple(b.range().lo_um, b.range().hi_um); })
      .def_property_readonly("integral_um", &BandResponse::integral)
      .def("radiance", &response_radiance, "flux"_a, "temperature_k"_a, "derivative"_a);
}

void add_noise(py::module_& module) {
  module.def("gaussian_noise", &gaussian, "rows"_a, "columns"_a, "sd"_a, "seed"_a, "frame"_a, "x"_a, "y"_a,
             "threads"_a);
  module.def("shot_noise", &shot, "mean"_a, "seed"_a, "frame"_a, "x"_a, "y"_a, "threads"_a);
}

}  // namespace apps::python
