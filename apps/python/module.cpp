// SPDX-License-Identifier: Apache-2.0

// The extension module mtfkit._core.

#include "apps/python/topics.h"
#include "mtf/version.h"

PYBIND11_MODULE(_core, module) {
  using namespace apps::python;
  module.doc() = "The compiled part of mtfkit; use the package mtfkit, which wraps it.";
  module.attr("__version__") = mtf::version;
  add_errors(module);
  add_kinds(module);
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
