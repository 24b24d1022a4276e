// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/heat_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/scene/heat/stopwatch.h"
#include "apps/text/words.h"

namespace apps::scene {
namespace {

namespace geometry = radiometry::scene;

/// A direction of the hemisphere of `normal` with the density of the cosine law; u and v in [0, 1).
geometry::Vector cosine_direction(const geometry::Vector& normal, double u, double v) {
  using geometry::operator+, geometry::operator*;
  const geometry::Vector helper =
      std::abs(normal[2]) < 0.9 ? geometry::Vector{0.0, 0.0, 1.0} : geometry::Vector{1.0, 0.0, 0.0};
  geometry::Vector across = geometry::cross(helper, normal);
  across = (1.0 / geometry::length(across)) * across;
  const double radius = std::sqrt(u), angle = 2.0 * std::numbers::pi * v;
  return radius * std::cos(angle) * across + radius * std::sin(angle) * geometry::cross(normal, across) +
         std::sqrt(1.0 - u) * normal;
}

/// The backs of open surfaces that are no sheets are not solved: they stand in the light and at the temperature of
/// their fronts. That is no matter where nothing sees them, as under terrain; else it is said.
void warn_of_seen_backs(HeatScene& scene) {
  constexpr std::size_t kFacets = 2000, kRays = 8;
  constexpr double kGolden = 0.6180339887498949, kSeen = 0.01;
  const geometry::Facets& facets = scene.facets();
  std::vector<std::size_t> seen(scene.file.regions.size(), 0);
  std::size_t rays = 0;
  const std::size_t step = std::max<std::size_t>(1, facets.size() / kFacets);
  for (std::size_t f = step / 2; f < facets.size(); f += step)
    for (std::size_t j = 0; j < kRays; ++j, ++rays) {
      using geometry::operator+, geometry::operator*;
      const geometry::Facet& from = facets.facet[f];
      const double u = (static_cast<double>(j) + 0.5) / kRays, v = std::fmod(static_cast<double>(rays) * kGolden, 1.0);
      const geometry::Hit hit = scene.rays.first_hit(
          {from.centre + 1e-6 * std::sqrt(from.area_m2) * from.normal, cosine_direction(from.normal, u, v)});
      if (geometry::hits(hit) && hit.back && !facets.shells[facets.facet[hit.facet].shell].closed &&
          !scene.is_sheet(hit.facet) && !scene.region_of(hit.facet).temperature)
        ++seen[scene.region[hit.facet]];
    }
  for (std::size_t r = 0; r < seen.size(); ++r)
    if (const double share = static_cast<double>(seen[r]) / static_cast<double>(rays); share > kSeen)
      scene.warnings.push_back("region '" + one_line(scene.file.regions[r].name) +
                               "': " + significant(100.0 * share, 2) +
                               " % of what surfaces see are backs of its open surfaces, which are taken to be lit and "
                               "warm as their fronts are; with inside.kind = \"sheet\" they are solved");
}

}  // namespace

bool HeatScene::is_sheet(std::uint32_t facet) const {
  const RegionSection& of = region_of(facet);
  return of.material && !of.temperature && material[*of.material].construction.is_sheet();
}

HeatScene prepare_heat(const SceneFile& file, const HeatOptions& options) {
  const Stopwatch weather;
  Surroundings surroundings = surroundings_of(file, options.directions, options.tolerance_k);
  const double weather_ms = weather.ms();
  const Stopwatch read;
  Surfaces surfaces = read_surfaces(file);
  const double read_ms = read.ms();
  const Stopwatch tree;
  radiometry::scene::Rays rays(std::move(surfaces.facets));
  std::vector<std::string> warnings = surroundings.warnings;
  warnings.insert(warnings.end(), surfaces.warnings.begin(), surfaces.warnings.end());
  HeatScene scene{file,
                  std::move(surroundings),
                  std::move(surfaces.region),
                  std::move(surfaces.material),
                  std::move(rays),
                  {{"weather", weather_ms}, {"meshes", read_ms}, {"tree", tree.ms()}},
                  std::move(warnings)};
  warn_of_seen_backs(scene);
  return scene;
}

}  // namespace apps::scene
