// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/opposite.h"

#include <algorithm>
#include <string>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "radiometry/scene/tracing/embree_scene.h"

namespace radiometry::scene {
namespace {

/// A concave facet may not hold its centre of area, but the middle of its first triangle.
Point on_facet(const Facets& facets, std::uint32_t facet) {
  const auto& [a, b, c] = facets.triangles[facets.first[facet]];
  const Point& corner = facets.vertices[a];
  return corner + (1.0 / 3.0) * ((facets.vertices[b] - corner) + (facets.vertices[c] - corner));
}

}  // namespace

OppositeFacets opposite_facets(const Rays& rays, std::span<const std::uint32_t> wanted, double thickness_m,
                               int threads) {
  if (!(thickness_m > 0.0))
    throw mtf::UsageError("opposite_facets: the thickness is " + std::to_string(thickness_m) +
                          " m, it must be above 0.");
  const Facets& facets = rays.facets();
  for (const std::uint32_t f : wanted)
    if (f >= facets.size()) throw mtf::UsageError("opposite_facets: there is no facet " + std::to_string(f));
  OppositeFacets found{.opposite = std::vector<std::uint32_t>(wanted.size(), kNone),
                       .distance_m = std::vector<double>(wanted.size(), 0.0)};
  const auto closed = [&](std::uint32_t f) { return facets.shells[facets.facet[f].shell].closed; };
  mtf::parallel_for(static_cast<std::int64_t>(wanted.size()), 1024, threads, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      if (!closed(wanted[i])) continue;
      const Facet& facet = facets.facet[wanted[i]];
      const Vector inwards = -1.0 * facet.normal;
      const Point start = on_facet(facets, wanted[i]) + rays.embree().lift_m() * inwards;
      const Hit hit = rays.first_hit({start, inwards});
      const double distance = hit.distance_m + rays.embree().lift_m();
      if (!hits(hit) || !hit.back || distance > thickness_m || !closed(hit.facet)) continue;
      found.opposite[i] = hit.facet;
      found.distance_m[i] = distance;
    }
  });
  found.unpaired = static_cast<std::size_t>(std::count(found.opposite.begin(), found.opposite.end(), kNone));
  return found;
}

}  // namespace radiometry::scene
