// SPDX-License-Identifier: Apache-2.0

// Edges in images: what `mtf measure` makes of them.

#include <pybind11/stl.h>

#include "apps/edges/edge_measure.h"
#include "apps/python/edge_images.h"
#include "apps/python/job.h"
#include "apps/python/topics.h"
#include "apps/simulate/scene_source.h"
#include "mtf/error.h"

namespace apps::python {
namespace {

MeasureMethod method_of(const std::string& name) {
  if (name == "regression") return MeasureMethod::regression;
  if (name == "iso12233") return MeasureMethod::iso12233;
  if (name == "both") return MeasureMethod::both;
  throw mtf::UsageError("method: '" + name + "' is not known (one of regression, iso12233, both)");
}

FrequencyUnit unit_of(const std::string& symbol) {
  for (const FrequencyUnit unit :
       {FrequencyUnit::cy_px, FrequencyUnit::cy_mm, FrequencyUnit::lp_mm, FrequencyUnit::cy_mrad, FrequencyUnit::lw_ph})
    if (unit_symbol(unit) == symbol) return unit;
  throw mtf::UsageError("unit: '" + symbol + "' is not known (one of cy/px, cy/mm, lp/mm, cy/mrad, lw/ph)");
}

py::tuple measure(const py::object& image, const py::dict& words, const std::string& method_name,
                  std::optional<int> order, bool circle, const std::string& unit, std::optional<double> pitch_um,
                  std::optional<double> focal_length_mm, const std::vector<double>& contrasts, int threads) {
  const EdgeInput input = edge_input_of(words);
  const EdgeMethod method{.order = order, .circle = circle, .method = method_of(method_name)};
  if (method.method != MeasureMethod::regression && circle)
    throw mtf::UsageError("circle: ISO 12233 knows polynomials only; leave out one of the two");
  MeasureReport report{.method = method_name,
                       .unit = unit_of(unit),
                       .contrasts = without_repetitions(contrasts),
                       .further = further_contrasts(contrasts)};
  std::erase(report.contrasts, 0.5);
  static_cast<void>(frequency_scale(report.unit, pitch_um, focal_length_mm, 1));
  EdgeImage given = edge_image(image, "image");
  std::vector<std::string> remarks;
  run_job([&](JobControl& control) {
    for (const EdgePlane& plane : planes_of(std::move(given), input)) {
      control.check();
      if (!plane.warning.empty()) remarks.push_back(plane.warning);
      remarks.insert(remarks.end(), plane.notes.begin(), plane.notes.end());
      if (plane.left_out + plane.not_tried > 0)
        report.left_out.push_back({plane.image, plane.channel, plane.left_out, plane.not_tried});
      std::vector<MeasuredEdge> edges = measure_plane(plane, method, threads);
      for (MeasuredEdge& edge : edges) {
        edge.scale = frequency_scale(report.unit, pitch_um, focal_length_mm, plane.plane.height());
        add_contrasts(edge, report.further);
      }
      std::move(edges.begin(), edges.end(), std::back_inserter(report.edges));
    }
    add_lateral_shifts(report.edges);
  });
  return py::make_tuple(measure_json(report), measure_table(report), remarks);
}

}  // namespace

EdgeInput edge_input_of(const py::dict& words) {
  EdgeInput input;
  const auto take = [&words](const char* name, auto& to) {
    if (words.contains(name) && !words[name].is_none()) to = words[name].cast<std::remove_reference_t<decltype(to)>>();
  };
  const auto take_file = [&take](const char* name, std::string& to) {
    FileName file{to};
    take(name, file);
    to = file.bytes;
  };
  take("channel", input.read.channel);
  take("encoding", input.encoding);
  take("bayer", input.bayer);
  take("pattern", input.pattern);
  take_file("mask", input.mask);
  take("regions", input.regions);
  take_file("region_file", input.region_file);
  take("most", input.most);
  take("min_length_px", input.min_length_px);
  take("min_cnr", input.min_cnr);
  take("noise_sd", input.noise_sd);
  take("saturation", input.saturation);
  return input;
}

EdgeImage edge_image(const py::object& image, const std::string& name) {
  if (py::isinstance<ImageHandle>(image)) {
    const auto handle = image.cast<ImageHandle>();
    return {handle.path, copy_of(*handle.file), true};
  }
  if (py::isinstance<py::str>(image)) return {image.cast<FileName>().bytes, std::nullopt, true};
  const PlaneView plane = plane_of(image, name);
  EdgeImage made{name, mtf::io::ImageFile{}, false};
  made.file->names = {"Y"};
  made.file->planes.push_back(image_of(plane.view));
  const auto array = py::array::ensure(image);
  // Whole numbers of 8 or 16 bits end where a file of them would, and lie one apart.
  const bool bytes = py::isinstance<py::array_t<std::uint8_t>>(array);
  const bool shorts = py::isinstance<py::array_t<std::uint16_t>>(array);
  const char* type = bytes ? "uint8" : shorts ? "uint16" : "float";
  made.file->integer = bytes || shorts;
  made.file->info.channels.push_back({.name = "Y", .type = type, .layer = "", .part_name = ""});
  made.file->info.storage = bytes ? "8-bit" : shorts ? "16-bit" : "array";
  made.file->info.format = made.file->integer ? mtf::io::Format::png : mtf::io::Format::exr;
  made.file->info.width = plane.view.width;
  made.file->info.height = plane.view.height;
  return made;
}

std::vector<EdgePlane> planes_of(EdgeImage&& image, const EdgeInput& input, Regions regions) {
  if (!image.file) return load_edge_planes(image.name, input, regions);
  return edge_planes_of(std::move(*image.file), image.name, input, regions);
}

void add_edges(py::module_& module) {
  module.def("measure", &measure, "image"_a, "words"_a, "method"_a, "order"_a, "circle"_a, "unit"_a, "pitch_um"_a,
             "focal_length_mm"_a, "contrasts"_a, "threads"_a);
}

}  // namespace apps::python
