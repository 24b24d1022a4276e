// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/view_spread.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace radiometry::thermal {
namespace {

namespace geometry = radiometry::scene;

/// Every n-th facet of those that are asked for.
std::vector<std::uint32_t> picked(const HeatScene& scene, std::size_t count) {
  std::vector<std::uint32_t> all, some;
  for (std::uint32_t f = 0; f < scene.facets().size(); ++f)
    if (scene.is_seen(f)) all.push_back(f);
  const std::size_t step = std::max<std::size_t>(1, all.size() / count);
  for (std::size_t i = step / 2; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

double from_patches(const geometry::SparseRows& rows, std::size_t row, const std::vector<double>& radiosity) {
  double sum = 0.0;
  for (std::uint64_t i = rows.first[row]; i < rows.first[row + 1]; ++i)
    sum += rows.value[i] * radiosity[rows.column[i]];
  return sum;
}

}  // namespace

ViewSpread view_spread(const HeatScene& scene, const Units& units, const GroundLight& ground,
                       const HeatBatches& batches, const Window& window, const HeatOptions& options, double loss_w_m2_k,
                       std::size_t count) {
  constexpr std::size_t kEvery = 6;  // nodes: an hour, where they are 10 minutes apart
  const Surroundings& s = scene.surroundings;
  std::vector<std::uint32_t> facets;
  for (const std::uint32_t f : picked(scene, count))
    if (!units.unit[units.unit_of[f]].given) facets.push_back(f);
  if (facets.empty()) return {};
  std::vector<geometry::Side> sides;
  for (const std::uint32_t f : facets) sides.push_back({f, false});
  const geometry::Receivers receivers = geometry::single_sides(std::move(sides));
  std::vector<geometry::Views> own;
  for (const geometry::ViewOptions& set :
       geometry::other_sets({.rays = options.rays_of(scene.facets().size()), .threads = options.threads}))
    own.push_back(views(scene.rays, receivers, units.patch_of_side, units.exchange.patches(), set));
  std::vector<double> largest(facets.size(), 0.0), variance(facets.size(), 0.0);
  for (std::size_t node = window.first; node <= window.last; node += kEvery) {
    const std::vector<double> radiosity = batches.patch_radiosity(node);
    const double sky = s.sky_longwave_w_m2[node], below = ground.longwave_w_m2[node];
    for (std::size_t i = 0; i < facets.size(); ++i) {
      const Unit& unit = units.unit[units.unit_of[facets[i]]];
      geometry::OtherSets of_facet;
      for (const geometry::Views& seen : own)
        of_facet.add(seen.sky_share(i) * sky + seen.ground[i] * below + from_patches(seen.patches, i, radiosity));
      const double of_unit = unit.front.sky * sky + unit.front.ground * below +
                             from_patches(units.views.patches, unit.receiver, radiosity);
      const double kelvin = unit.front.emissivity / loss_w_m2_k;
      largest[i] = std::max(largest[i], kelvin * std::abs(of_facet.mean - of_unit));
      variance[i] = std::max(variance[i], kelvin * kelvin * of_facet.variance());
    }
  }
  ViewSpread spread;
  const double all = std::accumulate(variance.begin(), variance.end(), 0.0);
  spread.largest_k = std::hypot(*std::max_element(largest.begin(), largest.end()),
                                std::sqrt(all) / static_cast<double>(largest.size()));
  const std::size_t compared = largest.size();
  spread.error_k = geometry::error_of(std::move(largest), all, compared);
  return spread;
}

}  // namespace radiometry::thermal
