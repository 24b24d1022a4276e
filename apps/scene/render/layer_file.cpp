// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/render/layer_file.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/image_io.h"
#include "mtf/io/scene.h"
#include "mtf/words.h"

namespace apps::scene {
namespace {

/// Names that renderers give: the whole name, or its end after a layer ("ViewLayer.Depth.Z"). Z alone is no end, as
/// that of a normal.
std::vector<std::string> usual_names(std::string_view role) {
  if (role == "depth") return {"Depth.Z", "Depth.V", "Z"};
  if (role == "material") return {"material", "IndexMA.X", "Material Index.X", "Material Index.V"};
  if (role == "normal.X" || role == "normal.Y" || role == "normal.Z")
    return {std::string(role), "N" + std::string(role.substr(1)), "Normal" + std::string(role.substr(6))};
  return {std::string(role), std::string(role) + ".X", std::string(role) + ".V"};  // passes of one's own (AOV)
}

std::optional<std::string> channel_of(const LayerFile& from, const mtf::io::FileInfo& info, std::string_view role) {
  const auto given = from.channels.find(std::string(role));
  const std::vector<std::string> names = given != from.channels.end() ? std::vector{given->second} : usual_names(role);
  for (const std::string& name : names)
    for (const mtf::io::ChannelInfo& channel : info.channels)
      if (channel.name == name || (name != "Z" && channel.name.ends_with("." + name))) return channel.name;
  if (given == from.channels.end()) return std::nullopt;
  throw mtf::UsageError("--channel " + std::string(role) + "=" + one_line(given->second) + ": " + one_line(from.file) +
                        " has no such channel");
}

mtf::Image read_channel(const LayerFile& from, const std::string& name) {
  return std::move(mtf::io::read_image(from.file, {name, std::nullopt, std::nullopt}).planes.front());
}

mtf::Image require_channel(const LayerFile& from, const mtf::io::FileInfo& info, std::string_view role) {
  const auto name = channel_of(from, info, role);
  if (name) return read_channel(from, *name);
  const std::string all = joined(info.channels, [](const auto& channel) { return one_line(channel.name); });
  throw mtf::UsageError(one_line(from.file) + ": has no channel for the " + std::string(role) + "; it has " + all +
                        ": write --channel " + std::string(role) + "=NAME");
}

struct MaterialEntry {
  float finish = 0.0F;
  float kelvin = std::numeric_limits<float>::quiet_NaN();
};

/// index,material[,temperature_K]
std::map<int, MaterialEntry> read_materials_table(const std::string& path, const SceneFile& scene) {
  const std::string remedy = "; the columns are index,material,temperature_K";
  const std::string text = mtf::io::read_table_text(path);
  std::string_view rest = mtf::io::without_mark(text);
  std::map<int, MaterialEntry> table;
  bool header = true;
  for (int line = 1; !rest.empty(); ++line) {
    const std::string_view row = mtf::io::take_text_line(rest);
    if (mtf::io::trimmed_cell(row).empty() || mtf::io::is_comment(row)) continue;
    const auto fail = [&](const std::string& what) {
      throw mtf::UsageError(one_line(path) + ":" + std::to_string(line) + ": error: " + what);
    };
    const auto cells = mtf::io::split_cells(row, mtf::io::separator_of(row));
    if (std::exchange(header, false)) {
      if (cells.size() < 2 || cells.size() > 3 || cells[0] != "index" || cells[1] != "material" ||
          (cells.size() == 3 && cells[2] != "temperature_K"))
        fail("another header than expected" + remedy);
      continue;
    }
    const auto index = mtf::io::cell_number<int>(cells[0]);
    if (!index || cells.size() < 2) fail("a whole number and the name of a material belong here" + remedy);
    const auto found = std::find_if(scene.materials.begin(), scene.materials.end(),
                                    [&](const MaterialSection& material) { return material.name == cells[1]; });
    if (found == scene.materials.end())
      fail(one_line(scene.file) + " has no [[material]] " + mtf::printable(std::string(cells[1]), 40));
    MaterialEntry entry{static_cast<float>(found - scene.materials.begin())};
    if (cells.size() > 2 && !cells[2].empty()) {
      const auto kelvin = mtf::io::cell_number(cells[2]);
      if (!kelvin || !(*kelvin > 0.0 && *kelvin <= 3000.0))
        fail("a temperature in K, above 0 and at most 3000, belongs here");
      entry.kelvin = static_cast<float>(*kelvin);
    }
    if (!table.emplace(*index, entry).second) fail("the index " + std::to_string(*index) + " stands twice");
  }
  return table;
}

}  // namespace

radiometry::render::SurfaceLayers read_layers(const LayerFile& from, const SceneFile& scene,
                                              const radiometry::render::Camera& camera) {
  const mtf::io::FileInfo info = mtf::io::read_info(from.file);
  if (!mtf::io::fits_aspect(info, camera.step_x, camera.step_y))
    throw mtf::UsageError(one_line(from.file) + ": " + mtf::io::aspect_note(info) + ", those of the sensor " +
                          significant(camera.step_x / camera.step_y, 5) +
                          " times; render it with pixels of that shape");
  radiometry::render::SurfaceLayers layers;
  layers.range_m = require_channel(from, info, "depth");
  layers.finish = require_channel(from, info, "material");
  const std::map<int, MaterialEntry> table =
      from.materials.empty() ? std::map<int, MaterialEntry>() : read_materials_table(from.materials, scene);
  const bool of_table = std::ranges::any_of(table, [](const auto& row) { return !std::isnan(row.second.kelvin); });
  layers.temperature_k = !of_table || channel_of(from, info, "temperature")
                             ? require_channel(from, info, "temperature")
                             : mtf::Image(layers.finish.width(), layers.finish.height());
  for (const std::string_view axis : {"normal.X", "normal.Y", "normal.Z"})
    if (const auto name = channel_of(from, info, axis)) layers.normal.push_back(read_channel(from, *name));
  if (!layers.normal.empty() && layers.normal.size() != 3)
    throw mtf::UsageError(one_line(from.file) + ": a normal has three channels, normal.X, normal.Y and normal.Z");
  if (const auto name = channel_of(from, info, "sunlit")) layers.sunlit = read_channel(from, *name);
  if (!table.empty())
    for (std::int64_t y = 0; y < layers.finish.height(); ++y)
      for (std::int64_t x = 0; x < layers.finish.width(); ++x) {
        float& finish = layers.finish.at(x, y);
        const auto found = table.find(static_cast<int>(std::lround(finish)));
        // What the table does not name is no surface, as an index of 0 in Blender.
        if (found == table.end() || static_cast<float>(std::lround(finish)) != finish) {
          if (finish != 0.0F && finish != -1.0F)
            throw mtf::UsageError(
                one_line(from.file) + ": column " + std::to_string(x) + ", row " + std::to_string(y) +
                ": the material " + significant(static_cast<double>(finish), 6) + " is not in " +
                one_line(from.materials) +
                "; numbers between whole ones come from a renderer that mixes the materials of a pixel");
          finish = -1.0F;
          continue;
        }
        finish = found->second.finish;
        if (of_table && !std::isnan(found->second.kelvin) && layers.temperature_k.at(x, y) == 0.0F)
          layers.temperature_k.at(x, y) = found->second.kelvin;
      }
  const bool planar = from.planar.value_or(!info.attributes.contains("mtf:sceneSha256"));
  if (planar && layers.range_m.width() == camera.width && layers.range_m.height() == camera.height)
    ranges_of_depths(camera, layers.range_m);
  return layers;
}

}  // namespace apps::scene
