// SPDX-License-Identifier: Apache-2.0

// Exceptions of the toolkit as those of mtfkit.errors. The message stays as it is, with file, line and remedy.

#include "apps/python/topics.h"
#include "apps/simulate/simulate.h"
#include "mtf/error.h"
#include "mtf/plan/plan.h"

namespace apps::python {
namespace {

namespace py = pybind11;

/// Sets the Python error of that class.
void raise(const char* name, const char* what) {
  const py::object type = py::module_::import("mtfkit.errors").attr(name);
  PyErr_SetObject(type.ptr(), py::str(what, std::char_traits<char>::length(what)).ptr());
}

void raise_unreachable(const mtf::UnreachableTolerance& error) {
  const py::object type = py::module_::import("mtfkit.errors").attr("ToleranceError");
  PyErr_SetObject(type.ptr(), type(py::str(error.what()), error.reachable()).ptr());
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const mtf::UnreachableTolerance& error) {
    raise_unreachable(error);
  } catch (const mtf::UsageError& error) {
    raise("UsageError", error.what());
  } catch (const mtf::Error& error) {
    raise("DataError", error.what());
  }
}

}  // namespace

void add_errors(py::module_&) { py::register_exception_translator(translate); }

}  // namespace apps::python
