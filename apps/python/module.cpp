// SPDX-License-Identifier: Apache-2.0

// The extension module mtfkit._core. Exceptions of the toolkit become those of mtfkit.errors. The message stays as it
// is, with file, line and remedy; options of the command, "--nan fill", become the arguments of the same names, "nan
// fill".

#include <regex>
#include <string>

#include "apps/python/topics.h"
#include "mtf/error.h"
#include "mtf/io/stage.h"
#include "mtf/plan/plan.h"
#include "mtf/version.h"

namespace apps::python {
namespace {

std::string with_arguments(const std::string& what) {
  static const std::regex option("(^|[\\s(\"',;:])--([a-z]+)(?:-([a-z]+))?");
  std::string text;
  auto from = what.cbegin();
  for (std::sregex_iterator it(what.cbegin(), what.cend(), option), end; it != end; ++it) {
    text.append(from, (*it)[0].first).append((*it)[1].str()).append((*it)[2].str());
    if ((*it)[3].matched) text.append("_").append((*it)[3].str());
    from = (*it)[0].second;
  }
  return text.append(from, what.cend());
}

/// A message, in which names of files may be no UTF-8.
py::str text_of(const std::string& what) {
  const std::string text = with_arguments(what);
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "replace"));
}

/// Sets the Python error of that class.
void raise(const char* name, const char* what) {
  const py::object type = py::module_::import("mtfkit.errors").attr(name);
  PyErr_SetObject(type.ptr(), text_of(mtf::io::without_stages(what)).ptr());
}

void raise_unreachable(const mtf::UnreachableTolerance& error) {
  const py::object type = py::module_::import("mtfkit.errors").attr("ToleranceError");
  PyErr_SetObject(type.ptr(), type(text_of(error.what()), error.reachable()).ptr());
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
}  // namespace apps::python

PYBIND11_MODULE(_core, module) {
  using namespace apps::python;
  module.doc() = "The compiled part of mtfkit; use the package mtfkit, which wraps it.";
  module.attr("__version__") = mtf::version;
  py::register_exception_translator(translate);
  add_sensor(module);
  add_curves(module);
  add_images(module);
  add_plan(module);
  add_simulate(module);
  add_edges(module);
  add_fit(module);
  add_characterize(module);
  add_study(module);
  add_noise(module);
  add_light(module);
  add_scenes(module);
}
