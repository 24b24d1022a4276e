// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/rays.h"

#include <algorithm>
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

}  // namespace radiometry::scene
