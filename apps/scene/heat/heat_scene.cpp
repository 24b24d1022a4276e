// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/heat_scene.h"

#include <algorithm>
#include <cmath>

#include "apps/scene/heat/limits.h"
#include "apps/scene/heat/opposite_walls.h"
#include "apps/scene/heat/seen/seen_facets.h"
#include "apps/text/words.h"
#include "mtf/error.h"
#include "mtf/work/stopwatch.h"
#include "radiometry/scene/views.h"

namespace apps::scene {
namespace {

namespace geometry = radiometry::scene;

/// The backs of open surfaces that are no sheets are not solved: they stand in the light and at the temperature of
/// their fronts. That is no matter where nothing sees them, as under terrain; else it is said.
void warn_of_seen_backs(HeatScene& scene, int threads) {
  constexpr std::size_t kFacets = 2000;
  constexpr int kRays = 8;
  constexpr double kSeen = 0.01;
  const geometry::Facets& facets = scene.facets();
  std::vector<std::uint32_t> patch_of;  // of each side: its region for such a back, else a patch of what is solved
  const auto solved = static_cast<std::uint32_t>(scene.file.regions.size());
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    const bool unsolved =
        !facets.shells[facets.facet[f].shell].closed && !scene.is_sheet(f) && !scene.region_of(f).temperature;
    patch_of.insert(patch_of.end(), {solved, unsolved ? scene.region[f] : solved});
  }
  std::vector<geometry::Side> sides;
  const std::size_t step = std::max<std::size_t>(1, facets.size() / kFacets);
  for (std::size_t f = step / 2; f < facets.size(); f += step) sides.push_back({static_cast<std::uint32_t>(f), false});
  const geometry::Views seen = views(scene.rays, geometry::single_sides(std::move(sides)), patch_of, solved + 1,
                                     {.rays = kRays, .threads = threads});
  std::vector<double> share(solved + 1, 0.0);
  for (std::size_t e = 0; e < seen.patches.value.size(); ++e)
    share[seen.patches.column[e]] += seen.patches.value[e] / static_cast<double>(seen.size());
  for (std::uint32_t r = 0; r < solved; ++r)
    if (share[r] > kSeen)
      scene.warnings.push_back("region '" + one_line(scene.file.regions[r].name) +
                               "': " + significant(100.0 * share[r], 2) +
                               " % of what surfaces see are backs of its open surfaces, which are taken to be lit and "
                               "warm as their fronts are; with inside.kind = \"sheet\" they are solved");
}

/// Every facet of a region with a table has to stand in it.
void read_tables(HeatScene& scene) {
  for (const RegionSection& region : scene.file.regions)
    scene.tables.push_back(region.temperature && !region.temperature->table.empty()
                               ? std::optional(read_facet_table(region.temperature->table, scene.facets().size()))
                               : std::nullopt);
  for (std::uint32_t f = 0; f < scene.facets().size(); ++f)
    if (const auto& table = scene.tables[scene.region[f]]; table && std::isnan(table->mean(f)))
      throw mtf::UsageError(one_line(table->source) + ": facet " + std::to_string(f) + " of region '" +
                            one_line(scene.region_of(f).name) + "' has no temperature");
}

void find_seen(HeatScene& scene, int threads) {
  const mtf::Stopwatch watch;
  const std::string where = one_line(scene.file.file) + ": what the camera sees is asked for, ";
  if (!scene.file.camera) throw mtf::UsageError(where + "and there is no [camera]");
  scene.seen = seen_facets(scene, scene.file.camera->position_m, threads);
  if (std::ranges::find(scene.seen, true) == scene.seen.end())
    throw mtf::UsageError(where + "and [camera] sees no facet from its position");
  scene.timing_ms.emplace_back("seen", watch.ms());
}

}  // namespace

bool HeatScene::is_sheet(std::uint32_t facet) const {
  const RegionSection& of = region_of(facet);
  return of.material && !of.temperature && material[*of.material].construction.is_sheet() &&
         material[*of.material].pair_m == 0.0;
}

double HeatScene::given_k(std::uint32_t facet, double time_s) const {
  const double utc_s = file.time.start_s + time_s;
  if (const auto& table = tables[region[facet]]) return table->at(facet, utc_s);
  return value_at(region_of(facet).temperature->schedule, utc_s);
}

std::uint32_t HeatScene::opposite_of(std::uint32_t facet) const {
  return opposite.empty() ? geometry::kNone : opposite[facet];
}

std::size_t HeatScene::material_of(std::uint32_t facet) const {
  const std::size_t of = *region_of(facet).material;
  return material[of].pair_m > 0.0 && opposite_of(facet) == geometry::kNone ? adiabatic_twin(*this, of) : of;
}

HeatScene prepare_heat(const SceneFile& file, const HeatOptions& options) {
  require_files(file);
  const mtf::Stopwatch weather;
  Surroundings surroundings = surroundings_of(file, options.directions, options.tolerance_k);
  const double weather_ms = weather.ms();
  const mtf::Stopwatch read;
  Surfaces surfaces = read_surfaces(file);
  const double read_ms = read.ms();
  const mtf::Stopwatch tree;
  radiometry::scene::Rays rays(std::move(surfaces.facets));
  std::vector<std::string> warnings = surroundings.warnings;
  for (std::string& text : weather_limits(file, surfaces.material, surroundings)) warnings.push_back(std::move(text));
  warnings.insert(warnings.end(), surfaces.warnings.begin(), surfaces.warnings.end());
  HeatScene scene{file,
                  std::move(surroundings),
                  std::move(surfaces.region),
                  std::move(surfaces.material),
                  std::move(rays),
                  {{"weather", weather_ms}, {"meshes", read_ms}, {"tree", tree.ms()}},
                  std::move(warnings)};
  read_tables(scene);
  pair_walls(scene, options.threads);
  warn_of_seen_backs(scene, options.threads);
  if (options.seen) find_seen(scene, options.threads);
  return scene;
}

}  // namespace apps::scene
