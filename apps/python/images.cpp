// SPDX-License-Identifier: Apache-2.0

// Image files in and out.

#include "apps/python/images.h"

#include <pybind11/stl.h>

#include "apps/python/arrays.h"
#include "apps/python/job.h"
#include "apps/python/topics.h"
#include "apps/simulate/scene_source.h"
#include "apps/simulate/sensor_image.h"
#include "apps/simulate/stated_camera.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/words.h"

namespace apps::python {
namespace {

ImageHandle read(const FileName& path, const std::optional<std::string>& channel,
                 const std::optional<std::string>& layer, std::optional<int> part) {
  std::shared_ptr<const mtf::io::ImageFile> file;
  run_job([&](JobControl&) {
    file = std::make_shared<const mtf::io::ImageFile>(
        mtf::io::read_image(path, {.channel = channel, .layer = layer, .part = part}));
  });
  return {path.bytes, file};
}

/// The values as an array that cannot be written and that keeps the file in memory.
py::array plane(const ImageHandle& image, const std::string& name) {
  const mtf::io::ImageFile& file = *image.file;
  for (std::size_t i = 0; i < file.names.size(); ++i) {
    if (file.names[i] != name) continue;
    auto* owner = new std::shared_ptr<const mtf::io::ImageFile>(image.file);
    const py::capsule free(owner, [](void* p) { delete static_cast<std::shared_ptr<const mtf::io::ImageFile>*>(p); });
    const mtf::Image& values = file.planes[i];
    constexpr auto kSize = static_cast<std::int64_t>(sizeof(float));
    py::array array =
        py::array_t<float>({values.height(), values.width()}, {values.width() * kSize, kSize}, values.data(), free);
    array.attr("setflags")("write"_a = false);
    return array;
  }
  throw mtf::UsageError(image.path + ": has no plane '" + mtf::printable(name, 60) + "'; it has " + joined(file.names));
}

/// Everything of a file in memory as Python's values, for pickle.
py::tuple state_of(const ImageHandle& image) {
  const mtf::io::ImageFile& file = *image.file;
  const mtf::io::FileInfo& info = file.info;
  py::list planes, channels;
  for (const mtf::Image& values : file.planes) planes.append(to_numpy(values.clone()));
  for (const mtf::io::ChannelInfo& c : info.channels)
    channels.append(
        py::make_tuple(c.name, c.type, c.layer, c.part, c.part_name, c.x_sampling, c.y_sampling, c.wavelength_um));
  return py::make_tuple(FileName{image.path}, file.names, planes, file.integer, file.missing_pixels,
                        static_cast<int>(info.format), info.storage, info.width, info.height, info.data_window,
                        info.display_window, channels, info.attributes, info.encoding.word, info.encoding.source,
                        info.dct_steps, info.largest, info.no_data, info.pixel_aspect, info.notes);
}

ImageHandle of_state(const py::tuple& state) {
  auto file = std::make_shared<mtf::io::ImageFile>();
  std::size_t next = 0;
  const auto take = [&](auto& to) { to = state[next++].cast<std::remove_reference_t<decltype(to)>>(); };
  FileName path;
  py::list planes, channels;
  int format = 0;
  mtf::io::FileInfo& info = file->info;
  take(path);
  take(file->names);
  take(planes);
  take(file->integer);
  take(file->missing_pixels);
  take(format);
  take(info.storage);
  take(info.width);
  take(info.height);
  take(info.data_window);
  take(info.display_window);
  take(channels);
  take(info.attributes);
  take(info.encoding.word);
  take(info.encoding.source);
  take(info.dct_steps);
  take(info.largest);
  take(info.no_data);
  take(info.pixel_aspect);
  take(info.notes);
  info.format = static_cast<mtf::io::Format>(format);
  for (const py::handle plane : planes)
    file->planes.push_back(image_of(plane_of(py::reinterpret_borrow<py::object>(plane), "plane").view));
  for (const py::handle channel : channels) {
    const auto [name, type, layer, part, part_name, x, y, um] =
        channel.cast<std::tuple<std::string, std::string, std::string, int, std::string, int, int, double>>();
    info.channels.push_back({name, type, layer, part, part_name, x, y, um});
  }
  return {path.bytes, file};
}

void write(const FileName& path, const std::vector<std::pair<std::string, py::object>>& planes,
           const std::map<std::string, std::string>& text, const std::map<std::string, std::array<double, 2>>& pairs,
           const std::map<std::string, std::vector<float>>& lists, const std::vector<std::string>& history,
           const std::optional<std::array<double, 2>>& range, int bits) {
  std::vector<PlaneView> views;
  std::vector<mtf::Image> images;
  std::vector<std::string> names;
  for (const auto& [name, array] : planes) {
    views.push_back(plane_of(array, "write: plane '" + name + "'"));
    names.push_back(name);
  }
  run_job([&](JobControl&) {
    for (const PlaneView& view : views) images.push_back(image_of(view.view));
    const mtf::io::Metadata metadata{.text = text, .pairs = pairs, .lists = lists, .history = history};
    write_sensor_image(path, names, images, metadata, {.ends = range, .bits = bits});
  });
}

/// Names of the numbers with a standard deviation; rows of temperatures, 1 where the first order holds, sd, both ends
/// of 95 % and the share of each of these numbers, columns of counts.
py::tuple count_temperatures(const std::map<std::string, std::string>& attributes,
                             const std::vector<std::string>& assumed,
                             const py::array_t<double, py::array::c_style | py::array::forcecast>& counts) {
  auto stated = stated_camera(attributes);
  if (!stated)
    throw mtf::UsageError(
        "the file does not say what its counts are worth (camera_counts.R1, B, F, O, R2); read the counts of a "
        "radiometric JPEG by channel=\"counts\"");
  assume(*stated, assumed);
  require_camera("the file", stated->camera);
  std::vector<std::string> names;
  std::vector<std::size_t> uncertain;
  std::size_t number = 0;
  for_each_field(stated->told, [&](const radiometry::FieldInfo& info, double) {
    if (stated->sd[number++] == 0.0) return;
    names.emplace_back(info.name);
    uncertain.push_back(number - 1);
  });
  const auto rows = static_cast<py::ssize_t>(5 + uncertain.size());
  py::array_t<double> made({rows, counts.size()});
  const double* from = counts.data();
  auto to = made.mutable_unchecked<2>();
  run_job([&](JobControl&) {
    const radiometry::CountErrors errors(stated->camera, stated->told, stated->air, stated->sd);
    mtf::parallel_for_each(counts.size(), 16, 0, [&](std::int64_t i) {
      const radiometry::CountUncertainty found = errors.of(from[i]);
      to(0, i) = found.temperature_k, to(1, i) = found.first_order ? 1.0 : 0.0, to(2, i) = found.sd_k;
      to(3, i) = found.low_k, to(4, i) = found.high_k;
      for (std::size_t k = 0; k < uncertain.size(); ++k)
        to(static_cast<py::ssize_t>(5 + k), i) = found.share(uncertain[k]);
    });
  });
  return py::make_tuple(names, made);
}

}  // namespace

mtf::io::Scene scene_of(const mtf::io::SensorConfig& sensor, const ImageHandle& image) {
  return mtf::io::physical_scene(sensor, image.path, copy_of(*image.file));
}

void add_images(py::module_& module) {
  py::class_<ImageHandle>(module, "ImageFile", "An image file in memory.")
      .def_property_readonly("path", [](const ImageHandle& i) { return FileName{i.path}; })
      .def_property_readonly("names", [](const ImageHandle& i) { return i.file->names; })
      .def_property_readonly("integer", [](const ImageHandle& i) { return i.file->integer; })
      .def_property_readonly("storage", [](const ImageHandle& i) { return i.file->info.storage; })
      .def_property_readonly("attributes", [](const ImageHandle& i) { return i.file->info.attributes; })
      .def_property_readonly("encoding", [](const ImageHandle& i) { return i.file->info.encoding.word; })
      .def_property_readonly("notes", [](const ImageHandle& i) { return i.file->info.notes; })
      .def_property_readonly("pitch_um", [](const ImageHandle& i) { return mtf::io::stated_pitch_um(i.file->info); })
      .def_property_readonly("missing_pixels", [](const ImageHandle& i) { return i.file->missing_pixels; })
      .def("plane", &plane, "name"_a)
      .def(
          "called",
          [](const ImageHandle& i, const FileName& name) {
            return ImageHandle{name.bytes, i.file};
          },
          "name"_a)
      .def(py::pickle(&state_of, &of_state));
  module.def(
      "plane", [](const py::object& array, const std::string& name) { return plane_of(array, name).array; }, "array"_a,
      "name"_a);
  module.def("count_temperatures", &count_temperatures, "attributes"_a, "assumed"_a, "counts"_a);
  module.def("read", &read, "path"_a, "channel"_a, "layer"_a, "part"_a);
  module.def("write", &write, "path"_a, "planes"_a, "text"_a, "pairs"_a, "lists"_a, "history"_a, "range"_a, "bits"_a);
}

}  // namespace apps::python
