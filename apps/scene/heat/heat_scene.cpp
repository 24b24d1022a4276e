// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/heat_scene.h"

#include "apps/scene/heat/stopwatch.h"

namespace apps::scene {

bool HeatScene::is_sheet(std::uint32_t facet) const {
  const RegionSection& of = region_of(facet);
  return of.material && !of.temperature && material[*of.material].construction.is_sheet();
}

HeatScene prepare_heat(const SceneFile& file, const HeatOptions& options) {
  const Stopwatch weather;
  Surroundings surroundings = surroundings_of(file, options.directions);
  const double weather_ms = weather.ms();
  const Stopwatch read;
  Surfaces surfaces = read_surfaces(file);
  const double read_ms = read.ms();
  const Stopwatch tree;
  radiometry::scene::Rays rays(std::move(surfaces.facets));
  std::vector<std::string> warnings = surroundings.warnings;
  warnings.insert(warnings.end(), surfaces.warnings.begin(), surfaces.warnings.end());
  return {file,
          std::move(surroundings),
          std::move(surfaces.region),
          std::move(surfaces.material),
          std::move(rays),
          {{"weather", weather_ms}, {"meshes", read_ms}, {"tree", tree.ms()}},
          std::move(warnings)};
}

}  // namespace apps::scene
