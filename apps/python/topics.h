// SPDX-License-Identifier: Apache-2.0
#pragma once

// The parts of the extension module mtfkit._core, one a topic; module.cpp puts them together. What Python users see is
// the package mtfkit/*.py around it.

#include <pybind11/pybind11.h>

namespace apps::python {

void add_errors(pybind11::module_& module);
void add_kinds(pybind11::module_& module);
void add_sensor(pybind11::module_& module);
void add_curves(pybind11::module_& module);
void add_images(pybind11::module_& module);
void add_plan(pybind11::module_& module);
void add_simulate(pybind11::module_& module);
void add_edges(pybind11::module_& module);
void add_fit(pybind11::module_& module);
void add_study(pybind11::module_& module);
void add_noise(pybind11::module_& module);
void add_light(pybind11::module_& module);
void add_scenes(pybind11::module_& module);

}  // namespace apps::python
