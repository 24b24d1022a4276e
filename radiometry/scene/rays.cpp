// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/rays.h"

#include <algorithm>
#include <array>
#include <string>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "radiometry/scene/tracing/embree_scene.h"

namespace radiometry::scene {
namespace {

void check(const Ray& ray, const Point& middle, std::size_t number) {
  const auto refuse = [&](const std::string& what) {
    throw mtf::UsageError("ray " + std::to_string(number) + " " + what);
  };
  if (!finite(ray.origin) || !finite(ray.direction)) refuse("has a component that is not finite.");
  const Vector from_middle = ray.origin - middle;
  if (std::any_of(from_middle.begin(), from_middle.end(), [](double x) { return std::abs(x) > kFarthestOrigin_m; }))
    refuse("starts more than 1e12 m from the scene.");
  const double norm = length(ray.direction);
  if (!(norm > 1e-150 && norm < 1e150)) refuse("has a direction without a length from 1e-150 to 1e150.");
}

/// The hit of a triangle, with the distance to its plane along a direction of any length, in that length, in double
/// precision.
Hit hit_of(const Facets& facets, std::uint32_t triangle, const Point& origin, const Vector& direction) {
  if (triangle == kNone) return {};
  const auto& [a, b, c] = facets.triangles[triangle];
  const Point& corner = facets.vertices[a];
  const Vector normal = cross(facets.vertices[b] - corner, facets.vertices[c] - corner);
  const double towards = dot(normal, direction);
  // A ray in the plane of the triangle, to rounding, has no better distance than that of the corner.
  const double distance = towards != 0.0 ? dot(normal, corner - origin) / towards
                                         : dot(corner - origin, direction) / dot(direction, direction);
  return {facets.facet_of[triangle], towards > 0.0, std::max(0.0, distance)};
}

/// A concave facet may not hold its centre of area, but the middle of its first triangle.
Point on_facet(const Facets& facets, std::uint32_t facet) {
  const auto& [a, b, c] = facets.triangles[facets.first[facet]];
  const Point& corner = facets.vertices[a];
  return corner + (1.0 / 3.0) * ((facets.vertices[b] - corner) + (facets.vertices[c] - corner));
}

}  // namespace

Rays::Rays(Facets facets) : facets_(std::move(facets)), embree_(std::make_unique<EmbreeScene>(facets_)) {}
Rays::Rays(Rays&&) noexcept = default;
Rays& Rays::operator=(Rays&&) noexcept = default;
Rays::~Rays() = default;

Hit Rays::first_hit(const Ray& ray) const {
  check(ray, facets_.middle, 0);
  const Vector direction = unit(ray.direction);
  return hit_of(facets_, embree_->first_triangle(embree_->single(ray.origin, direction)).number, ray.origin, direction);
}

void Rays::first_hits(std::span<const Ray> rays, std::span<Hit> hits, int threads) const {
  if (hits.size() != rays.size())
    throw mtf::UsageError("there are " + std::to_string(rays.size()) + " rays and space for " +
                          std::to_string(hits.size()) + " hits.");
  for (std::size_t i = 0; i < rays.size(); ++i) check(rays[i], facets_.middle, i);
  constexpr std::int64_t kChunk = 64 * kPacket;
  mtf::parallel_for(static_cast<std::int64_t>(rays.size()), kChunk, threads, [&](std::int64_t begin, std::int64_t end) {
    std::array<SingleRay, kPacket> packet;
    std::array<Vector, kPacket> direction;
    std::array<std::uint32_t, kPacket> triangle;
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); i += kPacket) {
      const std::size_t count = std::min(kPacket, static_cast<std::size_t>(end) - i);
      for (std::size_t k = 0; k < count; ++k) {
        direction[k] = unit(rays[i + k].direction);
        packet[k] = embree_->single(rays[i + k].origin, direction[k]);
      }
      embree_->first_triangles(std::span(packet).first(count), triangle);
      for (std::size_t k = 0; k < count; ++k)
        hits[i + k] = hit_of(facets_, triangle[k], rays[i + k].origin, direction[k]);
    }
  });
}

static_assert(kBeamRays == kPacket);

Beam::Beam(const Rays& rays, const Vector& direction) : rays_(rays), direction_(direction) {
  const double norm = length(direction);
  if (!(norm > 1e-150 && norm < 1e150))
    throw mtf::UsageError("rays go in a direction without a length from 1e-150 to 1e150.");
  direction_ = (1.0 / norm) * direction;
}

std::uint32_t Beam::blocked(std::span<const Point> from) const {
  std::array<SingleRay, kPacket> packet;
  for (std::size_t i = 0; i < from.size(); ++i) packet[i] = rays_.embree().single(from[i], direction_);
  return rays_.embree().blocked(std::span<const SingleRay>(packet).first(from.size()));
}

double Beam::lift_m() const { return rays_.embree().lift_m(); }

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
  mtf::parallel_for_each(static_cast<std::int64_t>(wanted.size()), 1024, threads, [&](std::size_t i) {
    if (!closed(wanted[i])) return;
    const Facet& facet = facets.facet[wanted[i]];
    const Vector inwards = -1.0 * facet.normal;
    const Point start = on_facet(facets, wanted[i]) + rays.embree().lift_m() * inwards;
    const Hit hit = rays.first_hit({start, inwards});
    const double distance = hit.distance_m + rays.embree().lift_m();
    if (!hits(hit) || !hit.back || distance > thickness_m || !closed(hit.facet)) return;
    found.opposite[i] = hit.facet;
    found.distance_m[i] = distance;
  });
  found.unpaired = static_cast<std::size_t>(std::count(found.opposite.begin(), found.opposite.end(), kNone));
  return found;
}

}  // namespace radiometry::scene
