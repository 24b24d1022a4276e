// SPDX-License-Identifier: Apache-2.0

// A camera from stacks of flat frames: the call of `mtf characterize`.

#include <pybind11/stl.h>

#include "apps/characterize/emva_descriptor.h"
#include "apps/characterize/find_camera.h"
#include "apps/python/arrays.h"
#include "apps/python/job.h"
#include "apps/python/sensor.h"
#include "apps/python/topics.h"
#include "apps/sensor/sensor_air.h"
#include "calib/characterize/emva1288.h"

namespace apps::python {
namespace {

/// What was found: as JSON and as the table of the command, and the sensor where frames make one.
struct CharacterizeHandle {
  std::string report, table;
  std::optional<std::string> sensor_text{};
};

/// A name in the file of stacks, and its frames.
using GivenFrames = std::pair<std::string, std::vector<py::object>>;

CharacterizeHandle characterized(const FileName& path, const std::string& text, const std::vector<GivenFrames>& frames,
                                 const std::optional<SensorHandle>& nominal, bool by_emva, int threads,
                                 const py::object& progress) {
  std::vector<PlaneView> planes;  // which keep the arrays alive
  FramesInMemory memory;
  for (const auto& [name, arrays] : frames)
    for (const py::object& array : arrays) {
      planes.push_back(plane_of(array, name + ".frames[" + std::to_string(memory[name].size()) + "]"));
      memory[name].push_back(planes.back().view);
    }
  CharacterizeHandle found;
  run_job([&](JobControl& control) {
    const ProgressCall report(progress, control);
    StacksFile file = text.empty() ? load_stacks(path) : parse_stacks(text, path, memory);
    std::optional<mtf::io::SensorConfig> own;
    if (nominal)
      own = *nominal->config;
    else if (!file.nominal.empty())
      own = read_sensor_file(file.nominal);
    if (own) file.nominal = own->file, file.nominal_sha256 = own->sha256;
    ReadStacks read = read_stacks(file, own, threads, [&](double share) { report(share); });
    control.check();
    if (by_emva) {
      const bool photons = file.tells_photons();
      calib::Emva1288 standard = calib::emva1288(std::move(read.stacks), read.how, photons);
      standard.warnings.insert(standard.warnings.begin(), read.warnings.begin(), read.warnings.end());
      found.report = json_document(emva1288_json(standard, file));
      found.table = emva1288_table(standard);
      return;
    }
    const FoundCamera camera = find_camera(file, std::move(own), std::move(read), "sensor.toml", false);
    found.report = json_document(camera.report);
    found.table = characterize_table(camera.camera, camera.sensor);
    if (!camera.sensor.text.empty()) found.sensor_text = camera.sensor.text;
  });
  return found;
}

}  // namespace

void add_characterize(py::module_& module) {
  py::class_<CharacterizeHandle>(module, "CharacterizeRun", "What stacks of frames tell of a camera.")
      .def_readonly("report", &CharacterizeHandle::report)
      .def_readonly("table", &CharacterizeHandle::table)
      .def_readonly("sensor_text", &CharacterizeHandle::sensor_text);
  module.def("characterize", &characterized, "path"_a, "text"_a, "frames"_a, "nominal"_a, "by_emva"_a, "threads"_a,
             "progress"_a);
}

}  // namespace apps::python
