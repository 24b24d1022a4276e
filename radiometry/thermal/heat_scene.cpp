// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/heat_scene.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/words.h"
#include "mtf/work/stopwatch.h"
#include "radiometry/scene/views.h"
#include "radiometry/thermal/limits.h"
#include "radiometry/thermal/opposite_walls.h"
#include "radiometry/thermal/seen/seen_facets.h"

namespace radiometry::thermal {
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
  const auto solved = static_cast<std::uint32_t>(scene.input.regions.size());
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    const bool unsolved =
        !facets.shells[facets.facet[f].shell].closed && !scene.is_sheet(f) && scene.region_of(f).is_solved();
    patch_of.insert(patch_of.end(), {solved, unsolved ? scene.input.region_of[f] : solved});
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
      scene.warnings.push_back("region '" + mtf::one_line(scene.input.regions[r].name) +
                               "': " + mtf::significant(100.0 * share[r], 2) +
                               " % of what surfaces see are backs of its open surfaces, which are taken to be lit and "
                               "warm as their fronts are; with inside.kind = \"sheet\" they are solved");
}

void find_seen(HeatScene& scene, int threads) {
  const mtf::Stopwatch watch;
  const std::string where = mtf::one_line(scene.input.name) + ": what the camera sees is asked for, ";
  if (!scene.input.camera_m) throw mtf::UsageError(where + "and there is no [camera]");
  scene.seen = seen_facets(scene, *scene.input.camera_m, threads);
  if (std::ranges::find(scene.seen, true) == scene.seen.end())
    throw mtf::UsageError(where + "and [camera] sees no facet from its position");
  scene.timing_ms.emplace_back("seen", watch.ms());
}

}  // namespace

bool HeatScene::is_sheet(std::uint32_t facet) const {
  const Region& of = region_of(facet);
  return of.is_solved() && material[*of.material].is_sheet();
}

std::uint32_t HeatScene::opposite_of(std::uint32_t facet) const {
  return opposite.empty() ? geometry::kNone : opposite[facet];
}

std::size_t HeatScene::material_of(std::uint32_t facet) const {
  const std::size_t of = *region_of(facet).material;
  return material[of].pair_m > 0.0 && opposite_of(facet) == geometry::kNone ? adiabatic_twin(*this, of) : of;
}

HeatScene prepare_heat(ThermalScene input, const HeatOptions& options) {
  require_valid(input);
  const mtf::Stopwatch weather;
  Surroundings surroundings = surroundings_of(input, options.directions, options.tolerance_k);
  const double weather_ms = weather.ms();
  const mtf::Stopwatch tree;
  scene::Rays rays(std::exchange(input.facets, {}));
  std::vector<std::string> warnings = surroundings.warnings;
  for (std::string& text : wind_limits(input, surroundings)) warnings.push_back(std::move(text));
  warnings.insert(warnings.end(), rays.facets().warnings.begin(), rays.facets().warnings.end());
  std::vector<Material> materials = input.materials;
  HeatScene scene{std::move(input),
                  std::move(surroundings),
                  std::move(materials),
                  std::move(rays),
                  {{"weather", weather_ms}, {"tree", tree.ms()}},
                  std::move(warnings)};
  pair_walls(scene, options.threads);
  warn_of_seen_backs(scene, options.threads);
  if (options.seen) find_seen(scene, options.threads);
  return scene;
}

}  // namespace radiometry::thermal
