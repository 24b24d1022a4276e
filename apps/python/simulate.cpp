// SPDX-License-Identifier: Apache-2.0

// A scene through a sensor: the call of `mtf simulate`.

#include "apps/simulate/simulate.h"

#include <pybind11/stl.h>

#include <array>
#include <tuple>

#include "apps/image/simulate_summary.h"
#include "apps/options.h"
#include "apps/python/arrays.h"
#include "apps/python/images.h"
#include "apps/python/job.h"
#include "apps/python/sensor.h"
#include "apps/python/topics.h"
#include "apps/simulate/sensor_run.h"
#include "mtf/error.h"
#include "mtf/work/stop.h"
#include "radiometry/stages/optics/distortion.h"

namespace apps::python {
namespace {

using Region = std::array<std::int64_t, 4>;

/// Where the scene comes from: one of a file, an image that was read, and arrays.
struct SceneWords {
  std::string path;
  std::optional<ImageHandle> image;
  std::vector<std::pair<std::string, py::object>> planes;
  std::vector<std::pair<std::string, py::object>> beside;
  SampleWords sample;
  std::string quantity;
  double blur_samples = 0.0;  ///< sigma of a Gaussian that is in the samples of arrays and is divided out
};

struct RunHandle {
  std::shared_ptr<const mtf::io::SensorConfig> sensor;
  SimulateOptions options;
  SimulateResult result;  ///< its images without their planes, which Python has
  py::list images;        ///< of each frame a dictionary of planes by name
};

NanPolicy nan_policy(const std::string& word) {
  if (word == "refuse") return NanPolicy::refuse;
  if (word == "fill") return NanPolicy::fill;
  if (word == "propagate") return NanPolicy::propagate;
  throw mtf::UsageError("nan: '" + word + "' is not known (one of refuse, fill, propagate)");
}

SceneSource source_of(const mtf::io::SensorConfig& sensor, const SceneWords& words) {
  SceneSource source;
  for (const auto& [name, array] : words.beside)
    source.beside.emplace(name, image_of(plane_of(array, "plane '" + name + "'").view));
  if (words.image) {
    source.file = words.image->path;
    const py::gil_scoped_release free;
    source.image = scene_of(sensor, *words.image);
    return source;
  }
  if (words.planes.empty()) {
    source.file = words.path;
    return source;
  }
  mtf::io::Scene& scene = source.image.emplace();
  scene.quantity = quantity_of(words.quantity);
  for (const auto& [name, array] : words.planes) {
    const PlaneView plane = plane_of(array, words.planes.size() == 1 ? "scene" : "scene: plane '" + name + "'");
    scene.planes.push_back(image_of(plane.view));
    scene.names.push_back(name);
  }
  scene.grid = grid_of(sensor, scene.planes.front().width(), scene.planes.front().height(), words.sample);
  return source;
}

/// The sensor that knows of the blur in the samples.
std::shared_ptr<const mtf::io::SensorConfig> without_blur(mtf::io::SensorConfig sensor, const mtf::SampleGrid& grid,
                                                          double samples) {
  sensor.scene.aperture = mtf::io::Aperture::gaussian;
  const mtf::Unit* um = mtf::find_unit("um");
  sensor.scene.aperture_size = {{samples * grid.step_x_um, um}, {samples * grid.step_y_um, um}};
  return std::make_shared<const mtf::io::SensorConfig>(std::move(sensor));
}

py::list take_images(SimulateResult& result) {
  py::list images;
  for (SimulatedImage& image : result.images) {
    py::dict planes;
    for (std::size_t c = 0; c < image.planes.size(); ++c)
      planes[py::str(result.names[c])] = to_numpy(std::move(image.planes[c]));
    image.planes.clear();
    images.append(py::make_tuple(image.frame, planes));
  }
  return images;
}

std::unique_ptr<RunHandle> simulate_scene(const SensorHandle& sensor, const SceneWords& scene,
                                          std::optional<double> tolerance, const std::string& nan, bool measure,
                                          const std::optional<std::string>& stage, const std::optional<Region>& region,
                                          std::optional<std::int64_t> memory,
                                          const std::optional<std::array<std::int64_t, 3>>& frames,
                                          const FileName& schedule, const FileName& out,
                                          const std::optional<std::array<double, 2>>& range, const py::object& filter,
                                          const std::string& device, int threads, const py::object& progress) {
  auto run = std::make_unique<RunHandle>();
  require_unchanged(sensor);
  run->sensor = sensor.config;
  SimulateOptions& options = run->options;
  options.tolerance = tolerance;
  options.nan = nan_policy(nan);
  options.measure = measure;
  if (stage) options.stage = output_stage(*stage);
  options.region = region;
  options.memory = memory;
  if (frames) options.frames = FrameRange{(*frames)[0], (*frames)[1], (*frames)[2]};
  options.schedule = schedule.bytes;
  options.out = out.bytes;
  options.range = range;
  options.threads = threads;
  std::string told;
  {
    const py::gil_scoped_release free;  // opening one takes seconds
    options.device = mtf::choose_device(device, told);
  }
  SceneSource source = source_of(*sensor.config, scene);
  if (scene.blur_samples > 0.0 && source.image)
    run->sensor = without_blur(*sensor.config, source.image->grid, scene.blur_samples);
  source.filter = light_filter(filter);
  run_job([&](JobControl& control) {
    const ProgressCall report(progress, control);
    options.watch = [&](const SimulateEvent& event) {
      if (event.kind == SimulateEvent::Kind::share) report(event.value);
      return !control.stopped();
    };
    run->result = simulate(*run->sensor, std::move(source), options);
    options.watch = {};
  });
  if (!told.empty()) run->result.report.warnings.push_back(told);
  run->images = take_images(run->result);
  return run;
}

/// A grid as Python has it: width, height, and the steps along x and y in um.
using GridNumbers = std::tuple<std::int64_t, std::int64_t, double, double>;
/// What is stored with an image, as Python keeps it: texts, pairs, lists, history.
using MetadataParts = std::tuple<std::map<std::string, std::string>, std::map<std::string, std::array<double, 2>>,
                                 std::map<std::string, std::vector<float>>, std::vector<std::string>>;

GridNumbers numbers_of(const mtf::SampleGrid& grid) {
  return {grid.width, grid.height, grid.step_x_um, grid.step_y_um};
}

std::vector<MetadataParts> metadata_of(const RunHandle& run) {
  std::vector<MetadataParts> all;
  for (const SimulatedImage& image : run.result.images)
    all.emplace_back(image.metadata.text, image.metadata.pairs, image.metadata.lists, image.metadata.history);
  return all;
}

/// Scene samples to pixels: x is the column, y the row, the centre of the first sample and pixel is at 0. `image` is
/// the whole one, of which a region may have been made.
py::array_t<double> map_points(const SensorHandle& sensor, const GridNumbers& scene, const GridNumbers& image,
                               const std::optional<Region>& region,
                               const py::array_t<double, py::array::c_style | py::array::forcecast>& points) {
  if (points.ndim() != 2 || points.shape(1) != 2)
    throw mtf::UsageError("points: give an array of the shape (count, 2), a column and a row each");
  const auto [scene_width, scene_height, in_x_um, in_y_um] = scene;
  const auto [width, height, out_x_um, out_y_um] = image;
  const radiometry::SensorSettings settings =
      has_chain(*sensor.config) ? load_chain(*sensor.config).sensor.settings : radiometry::SensorSettings{};
  const double width_um = static_cast<double>(width) * out_x_um, height_um = static_cast<double>(height) * out_y_um;
  const double axis_x_um =
      0.5 * width_um + (settings.axis ? settings.axis->x_px * sensor.config->system.frame.pitch_x_um : 0.0);
  const double axis_y_um =
      0.5 * height_um + (settings.axis ? settings.axis->y_px * sensor.config->system.frame.pitch_y_um : 0.0);
  const double half_um = 0.5 * std::hypot(width_um, height_um);
  py::array_t<double> result({points.shape(0), py::ssize_t{2}});
  for (py::ssize_t i = 0; i < points.shape(0); ++i) {
    double x_um = (points.at(i, 0) + 0.5) * in_x_um, y_um = (points.at(i, 1) + 0.5) * in_y_um;
    if (settings.distortion) {
      const double dx = x_um - axis_x_um, dy = y_um - axis_y_um;
      const double part = radiometry::distorted_part(*settings.distortion, std::hypot(dx, dy) / half_um);
      x_um = axis_x_um + part * dx;
      y_um = axis_y_um + part * dy;
    }
    result.mutable_at(i, 0) = x_um / out_x_um - 0.5 - (region ? static_cast<double>((*region)[0]) : 0.0);
    result.mutable_at(i, 1) = y_um / out_y_um - 0.5 - (region ? static_cast<double>((*region)[1]) : 0.0);
  }
  return result;
}

/// Writes an image as `mtf simulate -o` does.
void save_image(const SensorHandle& sensor, const std::optional<std::string>& stage, const py::dict& planes,
                const MetadataParts& parts, const FileName& path, const std::optional<std::array<double, 2>>& range) {
  std::vector<std::string> names;
  std::vector<mtf::Image> images;
  for (const auto& [name, array] : planes) {
    names.push_back(name.cast<std::string>());
    images.push_back(
        image_of(plane_of(py::reinterpret_borrow<py::object>(array), "plane '" + names.back() + "'").view));
  }
  const auto& [text, pairs, lists, history] = parts;
  const mtf::io::Metadata metadata{.text = text, .pairs = pairs, .lists = lists, .history = history};
  const py::gil_scoped_release free;
  const SensorRun run(sensor.config, stage ? std::optional(output_stage(*stage)) : std::nullopt);
  write_sensor_image(path, names, images, metadata, run.integer_range(range));
}

/// The sensor for the canvas that a filter of light makes: a scene that repeats, of which the image is that of the
/// first `width` x `height` samples. Throws UsageError where [frame] format reaches beyond them.
SensorHandle canvas_sensor(const SensorHandle& sensor, std::int64_t width, std::int64_t height,
                           const SampleWords& sample) {
  mtf::io::SensorConfig config = *sensor.config;
  mtf::Frame<double>& frame = config.system.frame;
  const int columns = frame.columns, rows = frame.rows;
  frame.columns = frame.rows = 0;
  const mtf::SampleGrid held = mtf::detector_grid(config.system, grid_of(*sensor.config, width, height, sample));
  if (columns > held.width || rows > held.height)
    throw mtf::UsageError(
        "frame.format: [" + std::to_string(columns) + ", " + std::to_string(rows) + "] reaches beyond the scene of " +
        std::to_string(held.width) + " x " + std::to_string(held.height) +
        " pixels, which does not go with a component made of a general function; give a larger scene");
  frame.columns = columns > 0 ? columns : static_cast<int>(held.width);
  frame.rows = rows > 0 ? rows : static_cast<int>(held.height);
  config.scene.border = mtf::Border::periodic;
  return {std::make_shared<const mtf::io::SensorConfig>(std::move(config)), nullptr};
}

}  // namespace

void add_simulate(py::module_& module) {
  py::class_<SceneWords>(module, "SceneWords", "Where a scene comes from.")
      .def(py::init([](const FileName& path, const std::optional<ImageHandle>& image,
                       const std::vector<std::pair<std::string, py::object>>& planes,
                       const std::vector<std::pair<std::string, py::object>>& beside, const SampleWords& sample,
                       const std::string& quantity, double blur_samples) {
             return SceneWords{path.bytes, image, planes, beside, sample, quantity, blur_samples};
           }),
           "path"_a, "image"_a, "planes"_a, "beside"_a, "sample"_a, "quantity"_a, "blur_samples"_a);
  py::class_<RunHandle>(module, "SimulateRun", "A finished simulation.")
      .def_readonly("images", &RunHandle::images)
      .def_property_readonly("names", [](const RunHandle& r) { return r.result.names; })
      .def_property_readonly("report", [](const RunHandle& r) { return to_json(r.result.report); })
      .def_property_readonly("promised",
                             [](const RunHandle& r) {
                               const RunReport& report = r.result.report;
                               return report.sequence ? report.sequence->predicted_error : report.plan->predicted_error;
                             })
      .def_property_readonly("tolerance", [](const RunHandle& r) { return r.result.report.tolerance; })
      .def_property_readonly("quantity", [](const RunHandle& r) { return r.result.report.quantity(); })
      .def_property_readonly("unit", [](const RunHandle& r) { return r.result.report.unit(); })
      .def_property_readonly("warnings", [](const RunHandle& r) { return r.result.report.warnings; })
      .def_property_readonly("notes", [](const RunHandle& r) { return r.result.report.notes; })
      .def_property_readonly("timing_ms", [](const RunHandle& r) { return r.result.report.timing_ms; })
      .def_property_readonly("image_grid", [](const RunHandle& r) { return numbers_of(r.result.report.whole_image()); })
      .def_property_readonly("scene_grid", [](const RunHandle& r) { return numbers_of(r.result.report.scene.grid); })
      .def_property_readonly("region", [](const RunHandle& r) { return r.result.report.region; })
      .def_property_readonly("metadata", &metadata_of)
      .def("explain", [](const RunHandle& r) { return explain_text(r.result.report); });
  module.def("map_points", &map_points, "sensor"_a, "scene_grid"_a, "image_grid"_a, "region"_a, "points"_a);
  module.def("save_image", &save_image, "sensor"_a, "stage"_a, "planes"_a, "metadata"_a, "path"_a, "range"_a);
  module.def(
      "sample_um",
      [](const SensorHandle& sensor, const SampleWords& sample) {
        const mtf::SampleGrid grid = grid_of(*sensor.config, 1, 1, sample);
        return py::make_tuple(grid.step_x_um, grid.step_y_um);
      },
      "sensor"_a, "sample"_a);
  module.def("require_going_on", &mtf::require_going_on);
  module.def("canvas_sensor", &canvas_sensor, "sensor"_a, "width"_a, "height"_a, "sample"_a);
  module.def("simulate", &simulate_scene, "sensor"_a, "scene"_a, "tolerance"_a, "nan"_a, "measure"_a, "stage"_a,
             "region"_a, "memory"_a, "frames"_a, "schedule"_a, "out"_a, "range"_a, "filter"_a, "device"_a, "threads"_a,
             "progress"_a);
  module.def("devices", &devices_report, py::call_guard<py::gil_scoped_release>());
}

}  // namespace apps::python
