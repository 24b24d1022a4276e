// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/scene_source.h"

#include "mtf/error.h"
#include "mtf/io/exr/spectral_exr.h"

namespace apps {
namespace {

void require_planes(const mtf::io::Scene& scene, const std::string& name) {
  if (scene.planes.empty() || scene.planes.front().size() == 0)
    throw mtf::UsageError(name + ": has no planes; give at least one with values");
  const mtf::Image& first = scene.planes.front();
  for (const mtf::Image& plane : scene.planes)
    if (plane.width() != first.width() || plane.height() != first.height())
      throw mtf::UsageError(name + ": planes of " + std::to_string(first.width()) + "x" +
                            std::to_string(first.height()) + " and " + std::to_string(plane.width()) + "x" +
                            std::to_string(plane.height()) + " samples; give all of them one size");
  if (scene.names.size() != scene.planes.size())
    throw mtf::UsageError(name + ": " + std::to_string(scene.planes.size()) + " planes and " +
                          std::to_string(scene.names.size()) + " names; give each plane its own name, or none");
  if (scene.grid.width != first.width() || scene.grid.height != first.height())
    throw mtf::UsageError(name + ": planes of " + std::to_string(first.width()) + "x" + std::to_string(first.height()) +
                          " samples on a grid of " + std::to_string(scene.grid.width) + "x" +
                          std::to_string(scene.grid.height) + "; leave out the size of the grid");
}

/// What a caller may leave out.
void complete(const mtf::io::SensorConfig& sensor, mtf::io::Scene& scene, const std::string& name) {
  if (scene.names.empty() && scene.planes.size() == 1) scene.names = {"Y"};
  if (scene.names.empty())
    for (std::size_t i = 0; i < scene.planes.size(); ++i) scene.names.push_back("channel " + std::to_string(i));
  mtf::SampleGrid& grid = scene.grid;
  if (grid.width == 0 && grid.height == 0 && !scene.planes.empty()) {
    grid.width = scene.planes.front().width();
    grid.height = scene.planes.front().height();
  }
  if (grid.step_x_um > 0.0 && grid.step_y_um > 0.0) return;
  if (!sensor.scene.sample_x_um || !sensor.scene.sample_y_um)
    throw mtf::UsageError(name +
                          ": the sample spacing is not known; set grid.step_x_um and grid.step_y_um (at the focal "
                          "plane), or sample, ifov, or gsd and range, in [scene] of " +
                          sensor.file);
  grid.step_x_um = *sensor.scene.sample_x_um;
  grid.step_y_um = *sensor.scene.sample_y_um;
}

}  // namespace

mtf::io::ImageFile copy_of(const mtf::io::ImageFile& file) {
  mtf::io::ImageFile copy{.names = file.names,
                          .planes = {},
                          .integer = file.integer,
                          .missing_pixels = file.missing_pixels,
                          .info = file.info};
  for (const mtf::Image& plane : file.planes) copy.planes.push_back(plane.clone());
  return copy;
}

SceneSource clone(const SceneSource& source) {
  SceneSource copy{.file = source.file, .read = source.read, .stored = source.stored, .filter = source.filter};
  for (const auto& [name, plane] : source.beside) copy.beside.emplace(name, plane.clone());
  if (!source.image) return copy;
  copy.image = facts_of(*source.image);
  for (const mtf::Image& plane : source.image->planes) copy.image->planes.push_back(plane.clone());
  return copy;
}

void complete_name(SceneSource& source) {
  if (source.image && source.file.empty()) source.file = "scene in memory";
}

mtf::io::Scene take_scene(const mtf::io::SensorConfig& sensor, SceneSource& source) {
  if (source.stored) return mtf::io::physical_scene(sensor, source.file, copy_of(*source.stored));
  if (!source.image) return mtf::io::load_scene(sensor, source.file, source.read);
  mtf::io::Scene scene = std::move(*source.image);
  complete(sensor, scene, source.file);
  require_planes(scene, source.file);
  if (scene.encoding.source.empty()) scene.encoding.source = "in memory";
  return scene;
}

mtf::Image plane_beside(const SceneSource& source, const std::string& name) {
  if (!source.image) return mtf::io::read_plane(source.file, {name});
  const auto found = source.beside.find(name);
  if (found == source.beside.end())
    throw mtf::UsageError(source.file + ": there is no plane '" + name + "' beside it; give it in `beside`");
  return found->second.clone();
}

mtf::io::Scene facts_of(const mtf::io::Scene& scene) {
  mtf::io::Scene facts;
  facts.names = scene.names;
  facts.wavelength_um = scene.wavelength_um;
  facts.grid = scene.grid;
  facts.quantity = scene.quantity;
  facts.warnings = scene.warnings;
  facts.info = scene.info;
  facts.encoding = scene.encoding;
  facts.scaling = scene.scaling;
  facts.undecoded = scene.undecoded;
  return facts;
}

}  // namespace apps
