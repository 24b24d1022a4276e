// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/sensor_image.h"

#include <algorithm>
#include <cmath>

#include "mtf/io/csv/csv_cells.h"
#include "mtf/version.h"
#include "mtf/words.h"

namespace apps {

using namespace mtf::io;  // NOLINT: this file is about image files only

namespace {

using Attributes = std::map<std::string, std::string>;

std::vector<std::string> cells_of(const Attributes& attributes, const std::string& key, std::string_view between) {
  std::vector<std::string> cells;
  if (const auto found = attributes.find(key); found != attributes.end())
    for (const std::string_view cell : split_words(found->second, between)) cells.emplace_back(trimmed_cell(cell));
  return cells;
}

/// The place on the ground: the image shares the outer corner of the scene, its steps are `ratio` times as large, and
/// of it the pixels from `first` on are kept. ENVI counts from 1 at the outer corner of the first pixel. False where
/// the scene has a place that cannot be read.
bool keep_ground(const Attributes& of_scene, std::array<double, 2> ratio, std::array<double, 2> first,
                 Attributes& text) {
  std::vector<std::string> map = cells_of(of_scene, "map info", ",\n"), grid = cells_of(of_scene, "geotransform", " ");
  bool is_read = map.size() >= 7 || (map.empty() && (grid.empty() || grid.size() == 6));
  const auto number = [&](const std::string& cell) {
    const auto value = cell_number(cell);
    is_read = is_read && value && std::isfinite(*value);
    return value.value_or(0.0);
  };
  if (map.size() >= 7) {
    for (const std::size_t axis : {0U, 1U}) {
      map[1 + axis] = mtf::format_double(1.0 + (number(map[1 + axis]) - 1.0) / ratio[axis] - first[axis]);
      map[5 + axis] = mtf::format_double(number(map[5 + axis]) * ratio[axis]);
    }
    if (!is_read) return false;
    text["map info"] = mtf::joined(map);
  } else if (grid.size() == 6) {
    std::array<double, 6> t{};
    for (std::size_t i = 0; i < 6; ++i) t[i] = number(grid[i]) * (i % 3 == 0 ? 1.0 : ratio[i % 3 - 1]);
    if (!is_read) return false;
    for (const std::size_t i : {0U, 3U}) t[i] += t[i + 1] * first[0] + t[i + 2] * first[1];
    text["geotransform"] = mtf::joined(t, mtf::format_double, " ");
    if (t[2] == 0.0 && t[4] == 0.0 && t[1] > 0.0 && t[5] < 0.0)
      text["map info"] = "Arbitrary, 1, 1, " + mtf::joined(std::array{t[0], t[3], t[1], -t[5]}, mtf::format_double);
  }
  for (const char* key : {"coordinate system", "coordinate system string"})  // of GDAL, of ENVI
    if (is_read && of_scene.contains(key)) text["coordinate system string"] = of_scene.at(key);
  return is_read;
}

}  // namespace

Metadata provenance(const SensorConfig& config, const Scene& scene, const mtf::SensorPlan& plan, double tolerance,
                    const std::optional<std::array<std::int64_t, 4>>& region) {
  const mtf::Frame<double>& frame = config.system.frame;
  Metadata m;
  m.text["mtf:quantity"] = quantity_name(scene.quantity);
  m.text["mtf:units"] = quantity_unit(scene.quantity);
  // Filtered light is still weighted by what it was weighted by, has its air, and was seen there and then.
  for (const char* name :
       {"mtf:quantity", "mtf:response", "mtf:path", "mtf:time", "mtf:cameraPosition", "mtf:cameraAhead"})
    if (const auto found = scene.info.attributes.find(name);
        found != scene.info.attributes.end() &&
        (name != std::string_view("mtf:quantity") || found->second.starts_with("weighted_")))
      m.text[name] = found->second;
  m.text["mtf:configSha256"] = config.sha256;
  m.text["mtf:sensor"] = config.system.name;
  m.text["mtf:version"] = std::string(mtf::version) + " " + mtf::git_commit;
  m.text["mtf:tolerance"] = mtf::format_double(tolerance);
  m.text["mtf:predictedError"] = mtf::format_double(plan.predicted_error);
  // With [microscan] an image has several samples a pitch.
  const double step_x_um = frame.pitch_x_um / plan.samples_a_pitch, step_y_um = frame.pitch_y_um / plan.samples_a_pitch;
  m.pairs["mtf:pixelPitch"] = {step_x_um / 1e6, step_y_um / 1e6};
  m.pairs["mtf:ifov"] = {step_x_um * 1e-3 / frame.focal_length_mm, step_y_um * 1e-3 / frame.focal_length_mm};
  if (config.system.band)
    m.lists["mtf:bandEdges"] = {static_cast<float>(config.system.band->lo_um),
                                static_cast<float>(config.system.band->hi_um)};
  m.lists["mtf:wavelength"].assign(scene.wavelength_um.begin(), scene.wavelength_um.end());
  if (scene.wavelength_um.empty()) m.lists.erase("mtf:wavelength");
  const auto [x, y, width, height] = region.value_or(std::array<std::int64_t, 4>{});
  if (region)
    m.text["mtf:region"] = mtf::joined(
                               std::array{x, y, width, height}, [](auto n) { return std::to_string(n); }, " ") +
                           " pixels of the whole image";
  const bool has_ground =
      keep_ground(scene.info.attributes, {step_x_um / scene.grid.step_x_um, step_y_um / scene.grid.step_y_um},
                  {static_cast<double>(x), static_cast<double>(y)}, m.text);
  if (const auto before = scene.info.attributes.find("mtf:history"); before != scene.info.attributes.end())
    m.history.push_back(before->second);
  if (!has_ground) m.history.emplace_back("mtf simulate: map info of the scene cannot be read and is left out");
  m.history.push_back("mtf simulate: presample OTF, sampling at the pitch" +
                      std::string(plan.post ? ", readout and postsample filters" : ""));
  return m;
}

std::vector<std::string> output_names(const std::vector<std::string>& names) {
  if (names.size() == 1) return {"Y"};
  const auto last = [](const std::string& name) { return name.substr(name.rfind('.') + 1); };
  if (names.size() == 3) {
    std::vector<std::string> colours;
    for (const std::string& name : names) colours.push_back(last(name));
    std::vector<std::string> sorted = colours;
    std::sort(sorted.begin(), sorted.end());
    if (sorted == std::vector<std::string>{"B", "G", "R"}) return colours;
  }
  return names;
}

Written write_sensor_image(const std::string& path, const std::vector<std::string>& names,
                           const std::vector<mtf::Image>& planes, const Metadata& metadata, const IntegerRange& range) {
  std::vector<NamedPlane> named;
  for (std::size_t i = 0; i < planes.size(); ++i) named.push_back({names[i], planes[i].view()});
  if (holds_floats(format_from_extension(path))) {
    write_floats(path, named, metadata);
    return {};
  }
  Written written;
  written.scaling = full_range_scaling(named);
  if (range.ends) {
    const auto& [low, high] = *range.ends;
    written.scaling = IntegerScaling{.offset = low, .bits = range.bits};
    written.scaling->gain = (high - low) / written.scaling->largest();
  }
  written.clamped = write_integer(path, named, *written.scaling, metadata);
  return written;
}

}  // namespace apps
