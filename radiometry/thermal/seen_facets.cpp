// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/seen_facets.h"

#include <algorithm>
#include <array>
#include <limits>

#include "mtf/parallel.h"

namespace radiometry::thermal {
namespace {

namespace geometry = radiometry::scene;
using geometry::Point, geometry::Vector;
using geometry::operator-, geometry::operator+, geometry::operator*;

constexpr std::array<std::array<double, 3>, 7> kPoints{{{1.0 / 3, 1.0 / 3, 1.0 / 3},
                                                        {0.9, 0.05, 0.05},
                                                        {0.05, 0.9, 0.05},
                                                        {0.05, 0.05, 0.9},
                                                        {0.48, 0.48, 0.04},
                                                        {0.04, 0.48, 0.48},
                                                        {0.48, 0.04, 0.48}}};

/// Whether the camera lies within the box around each shell: then it may stand inside of it.
std::vector<bool> shells_around(const geometry::Facets& facets, const Point& camera) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::vector<Point> low(facets.shells.size(), {kFar, kFar, kFar}), high(facets.shells.size(), {-kFar, -kFar, -kFar});
  for (std::size_t t = 0; t < facets.triangles.size(); ++t)
    for (const std::uint32_t v : facets.triangles[t])
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::uint32_t shell = facets.facet[facets.facet_of[t]].shell;
        low[shell][axis] = std::min(low[shell][axis], facets.vertices[v][axis]);
        high[shell][axis] = std::max(high[shell][axis], facets.vertices[v][axis]);
      }
  std::vector<bool> around(facets.shells.size(), true);
  for (std::size_t s = 0; s < around.size(); ++s)
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (camera[axis] < low[s][axis] || camera[axis] > high[s][axis]) around[s] = false;
  return around;
}

/// Which facets may turn a side to the camera.
std::vector<bool> facing_facets(const geometry::Facets& facets, const Point& camera) {
  const std::vector<bool> around = shells_around(facets, camera);
  std::vector<bool> may_face(facets.size());
  for (std::size_t f = 0; f < facets.size(); ++f) {
    const geometry::Facet& facet = facets.facet[f];
    may_face[f] = !facets.shells[facet.shell].closed || around[facet.shell] ||
                  geometry::dot(facet.normal, camera - facet.centre) > 0.0;
  }
  return may_face;
}

/// What lines from the camera to some facets meet first.
void trace(const HeatScene& scene, const Point& camera, std::span<const std::uint32_t> targets,
           std::vector<geometry::Hit>& met) {
  const geometry::Facets& facets = scene.facets();
  std::vector<geometry::Ray> rays;
  for (const std::uint32_t f : targets)
    for (std::uint64_t t = facets.first[f]; t < facets.first[f + 1]; ++t) {
      const auto& [a, b, c] = facets.triangles[t];
      for (const auto& at : kPoints) {
        const Vector to = at[0] * facets.vertices[a] + at[1] * facets.vertices[b] + at[2] * facets.vertices[c] - camera;
        if (geometry::length(to) > 0.0) rays.push_back({camera, to});
      }
    }
  met.resize(rays.size());
  scene.rays.first_hits(rays, met, 1);
}

/// Adds facets that share a corner with a seen one.
void add_neighbours(const geometry::Facets& facets, const std::vector<bool>& may_face, std::vector<bool>& seen) {
  std::vector<bool> corner(facets.vertices.size(), false);
  for (std::size_t t = 0; t < facets.triangles.size(); ++t)
    if (seen[facets.facet_of[t]])
      for (const std::uint32_t v : facets.triangles[t]) corner[v] = true;
  for (std::size_t t = 0; t < facets.triangles.size(); ++t)
    if (const std::uint32_t f = facets.facet_of[t]; may_face[f] && !seen[f])
      seen[f] = std::ranges::any_of(facets.triangles[t], [&](std::uint32_t v) { return corner[v]; });
}

}  // namespace

std::vector<bool> seen_facets(const HeatScene& scene, const Point& camera_m, int threads) {
  constexpr std::int64_t kAtOnce = 1024;
  const geometry::Facets& facets = scene.facets();
  const auto count = static_cast<std::uint32_t>(facets.size());
  const std::vector<bool> may_face = facing_facets(facets, camera_m);
  std::vector<std::uint32_t> targets;
  for (std::uint32_t f = 0; f < count; ++f)
    if (may_face[f]) targets.push_back(f);
  std::vector<std::vector<geometry::Hit>> met(targets.size() / kAtOnce + 1);
  mtf::parallel_for(
      static_cast<std::int64_t>(targets.size()), kAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
        trace(scene, camera_m,
              std::span(targets).subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin)),
              met[static_cast<std::size_t>(begin / kAtOnce)]);
      });
  std::vector<bool> seen(count, false);
  for (const std::vector<geometry::Hit>& some : met)
    for (const geometry::Hit& hit : some)
      if (geometry::hits(hit)) seen[hit.facet] = true;
  add_neighbours(facets, may_face, seen);
  const std::vector<bool> fronts = seen;
  for (std::uint32_t f = 0; f < count; ++f)
    if (const std::uint32_t opposite = scene.opposite_of(f); fronts[f] && opposite != geometry::kNone)
      seen[opposite] = true;
  return seen;
}

}  // namespace radiometry::thermal
