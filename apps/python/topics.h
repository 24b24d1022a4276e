// SPDX-License-Identifier: Apache-2.0
#pragma once

// The parts of the extension module mtfkit._core, one a topic; module.cpp puts them together. What Python users see is
// the package mtfkit/*.py around it.

#include <pybind11/pybind11.h>

#include <string>

namespace apps::python {

namespace py = pybind11;
using namespace py::literals;

/// The name of a file: bytes in C++. In Python it is a text, in which os.fsdecode writes each byte that is not UTF-8 as
/// a lone surrogate (PEP 383). Ordinary text conversion refuses such texts; this type converts them.
struct FileName {
  std::string bytes;
  operator const std::string&() const { return bytes; }  // NOLINT: a name is a name
};

void add_sensor(py::module_& module);
void add_curves(py::module_& module);
void add_images(py::module_& module);
void add_plan(py::module_& module);
void add_simulate(py::module_& module);
void add_edges(py::module_& module);
void add_fit(py::module_& module);
void add_characterize(py::module_& module);
void add_study(py::module_& module);
void add_noise(py::module_& module);
void add_light(py::module_& module);
void add_scenes(py::module_& module);

}  // namespace apps::python

namespace pybind11::detail {

template <>
struct type_caster<apps::python::FileName> {
  PYBIND11_TYPE_CASTER(apps::python::FileName, const_name("str"));

  bool load(handle from, bool) {
    if (!PyUnicode_Check(from.ptr()) && !PyBytes_Check(from.ptr())) return false;
    const object encoded = PyBytes_Check(from.ptr()) ? reinterpret_borrow<object>(from)
                                                     : reinterpret_steal<object>(PyUnicode_EncodeFSDefault(from.ptr()));
    if (!encoded) PyErr_Clear();
    if (!encoded) return false;
    value.bytes.assign(PyBytes_AS_STRING(encoded.ptr()), static_cast<std::size_t>(PyBytes_GET_SIZE(encoded.ptr())));
    return true;
  }
  static handle cast(const apps::python::FileName& name, return_value_policy, handle) {
    return PyUnicode_DecodeFSDefaultAndSize(name.bytes.data(), static_cast<Py_ssize_t>(name.bytes.size()));
  }
};

}  // namespace pybind11::detail
