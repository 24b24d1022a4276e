// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/pencil.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "radiometry/scene/tracing/embree_scene.h"

namespace radiometry::scene {

static_assert(kPencilRays == kPacket);

Pencil::Pencil(const Rays& rays, const Point& origin) : rays_(rays), origin_() {
  const Vector from_middle = origin - rays.facets().middle;
  const bool near = finite(origin) && std::all_of(from_middle.begin(), from_middle.end(),
                                                  [](double x) { return std::abs(x) <= kFarthestOrigin_m; });
  if (!near) throw mtf::UsageError("rays start at a point that is not finite, or more than 1e12 m from the scene.");
  origin_ = rays.embree().single(origin, {0.0, 0.0, 1.0}).origin;
}

void Pencil::trace(const PencilDirections& directions, PencilHits& hits) const {
  rays_.embree().first_triangles(origin_, directions, hits);
}

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

double distance_to(const Facets& facets, std::uint32_t triangle, const Point& origin, const Vector& direction) {
  const auto& [a, b, c] = facets.triangles[triangle];
  const Point& corner = facets.vertices[a];
  const Vector normal = cross(facets.vertices[b] - corner, facets.vertices[c] - corner);
  const double towards = dot(normal, direction);
  // A ray in the plane of the triangle, to rounding, has no better distance than that of the corner.
  const double distance = towards != 0.0 ? dot(normal, corner - origin) / towards
                                         : dot(corner - origin, direction) / dot(direction, direction);
  return std::max(0.0, distance);
}

}  // namespace radiometry::scene
