// SPDX-License-Identifier: Apache-2.0

// A camera from stacks of flat frames: the call of `mtf characterize`.

#include <pybind11/stl.h>

#include "apps/characterize/blackbodies.h"
#include "apps/characterize/camera_edges.h"
#include "apps/characterize/emva_descriptor.h"
#include "apps/characterize/find_camera.h"
#include "apps/edges/fit_command.h"
#include "apps/python/arrays.h"
#include "apps/python/edge_images.h"
#include "apps/python/job.h"
#include "apps/python/sensor.h"
#include "apps/python/topics.h"
#include "apps/sensor/sensor_air.h"
#include "calib/characterize/emva1288.h"
#include "mtf/error.h"

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
                                 const std::optional<SensorHandle>& nominal, const std::vector<py::object>& edges,
                                 bool by_emva, int threads, const py::object& progress) {
  std::vector<PlaneView> planes;  // which keep the arrays alive
  FramesInMemory memory;
  for (const auto& [name, arrays] : frames)
    for (const py::object& array : arrays) {
      planes.push_back(plane_of(array, name + ".frames[" + std::to_string(memory[name].size()) + "]"));
      memory[name].push_back(planes.back().view);
    }
  std::vector<EdgeImage> images;
  for (const py::object& edge : edges)
    images.push_back(edge_image(edge, "edges[" + std::to_string(images.size()) + "]"));
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
    if (!images.empty() && !own) throw mtf::UsageError("edges: there is nothing to fit without a nominal");
    if (!images.empty() && file.has_blackbodies() && !is_thermal(*own))
      throw mtf::UsageError("edges: they are fitted to a sensor file, and blackbodies make none of a photon detector");
    if (!images.empty()) static_cast<void>(fit_parameters(*own));
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
    FoundCamera camera = find_camera(file, std::move(own), std::move(read), "sensor.toml", false);
    found.table = characterize_table(camera.camera, camera.sensor);
    if (!camera.sensor.text.empty()) found.sensor_text = camera.sensor.text;
    if (!images.empty()) {
      std::vector<EdgePicture> pictures;
      for (EdgeImage& image : images)
        pictures.push_back(image.file ? EdgePicture{image.name, std::move(*image.file), image.on_disk}
                                      : EdgePicture{image.name, mtf::io::read_image(image.name)});
      CameraEdges fitted = fit_camera_edges(camera, file, std::move(pictures), "sensor.toml", threads,
                                            [&](double) { return !control.stopped(); });
      control.check();
      camera.report["edges"] = std::move(fitted.report);
      found.table += "\n" + fitted.table;
      if (!fitted.sensor_text.empty()) found.sensor_text = fitted.sensor_text;
    }
    found.report = json_document(camera.report);
  });
  return found;
}

}  // namespace

void add_characterize(py::module_& module) {
  py::class_<CharacterizeHandle>(module, "CharacterizeRun", "What stacks of frames tell of a camera.")
      .def_readonly("report", &CharacterizeHandle::report)
      .def_readonly("table", &CharacterizeHandle::table)
      .def_readonly("sensor_text", &CharacterizeHandle::sensor_text);
  module.def("characterize", &characterized, "path"_a, "text"_a, "frames"_a, "nominal"_a, "edges"_a, "by_emva"_a,
             "threads"_a, "progress"_a);
}

}  // namespace apps::python
