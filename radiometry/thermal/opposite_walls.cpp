// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/opposite_walls.h"

#include <algorithm>

#include "mtf/words.h"
#include "radiometry/scene/opposite.h"

namespace radiometry::thermal {
namespace {

namespace geometry = radiometry::scene;

double thickness_m(const Material& surface) {
  double sum = 0.0;
  for (const heat::Layer& layer : surface.construction.layers) sum += layer.thickness_m;
  return sum;
}

std::vector<std::uint32_t> solved_facets(const HeatScene& scene, std::size_t material) {
  std::vector<std::uint32_t> facets;
  for (std::uint32_t f = 0; f < scene.facets().size(); ++f) {
    const Region& region = scene.region_of(f);
    if (region.material == material && region.is_solved()) facets.push_back(f);
  }
  return facets;
}

/// Pairs of one material; how many have none is said, and walls that are not as thick as the layers.
void pair_material(HeatScene& scene, std::size_t material, int threads) {
  constexpr double kUnlike = 1.5;
  const Material& surface = scene.material[material];
  const std::vector<std::uint32_t> facets = solved_facets(scene, material);
  const geometry::OppositeFacets found = opposite_facets(scene.rays, facets, surface.pair_m, threads);
  std::size_t without = 0;
  std::vector<double> distance;
  for (std::size_t i = 0; i < facets.size(); ++i) {
    const std::uint32_t opposite = found.opposite[i];
    const bool like = opposite != geometry::kNone && scene.region_of(opposite).material == material &&
                      scene.region_of(opposite).is_solved();
    if (!like) {
      ++without;
      continue;
    }
    scene.opposite[facets[i]] = opposite;
    distance.push_back(found.distance_m[i]);
  }
  const std::string where = "material '" + mtf::one_line(surface.name) + "': ";
  if (without > 0)
    scene.warnings.push_back(where + std::to_string(without) + " of " +
                             mtf::plural(static_cast<std::int64_t>(facets.size()), "facet") +
                             " have no opposite face of that material within " + mtf::significant(surface.pair_m, 3) +
                             " m; they are solved as adiabatic inside");
  if (distance.empty()) return;
  std::nth_element(distance.begin(), distance.begin() + static_cast<std::ptrdiff_t>(distance.size() / 2),
                   distance.end());
  const double median = distance[distance.size() / 2], layers = thickness_m(surface);
  if (median > kUnlike * layers || layers > kUnlike * median)
    scene.warnings.push_back(where + "its layers are " + mtf::significant(layers, 3) +
                             " m thick, the walls of the mesh " + mtf::significant(median, 3) +
                             " m (median); the layers count");
}

}  // namespace

void pair_walls(HeatScene& scene, int threads) {
  const std::size_t materials = scene.input.materials.size();
  for (std::size_t m = 0; m < materials; ++m) {
    if (scene.material[m].pair_m == 0.0) continue;
    if (scene.opposite.empty()) scene.opposite.assign(scene.facets().size(), geometry::kNone);
    Material twin = scene.material[m];
    twin.name += " (no opposite face)";
    twin.construction.inside = heat::Adiabatic{};
    twin.pair_m = 0.0;
    twin.source_w_m2 += twin.back_source_w_m2;  // what no longer comes out of the back
    pair_material(scene, m, threads);
    scene.material.push_back(std::move(twin));
  }
}

std::size_t adiabatic_twin(const HeatScene& scene, std::size_t material) {
  std::size_t twin = scene.input.materials.size();
  for (std::size_t m = 0; m < material; ++m) twin += scene.material[m].pair_m > 0.0;
  return twin;
}

}  // namespace radiometry::thermal
