// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/tracing/ray_sampling.h"

#include <algorithm>

namespace radiometry::scene {

ReceiverSurface::ReceiverSurface(const Facets& facets, std::span<const Side> sides, double lift_m) {
  double area = 0.0;
  for (const Side& side : sides) {
    const Vector normal = (side.back ? -1.0 : 1.0) * facets.facet[side.facet].normal;
    for (std::uint64_t t = facets.first[side.facet]; t < facets.first[side.facet + 1]; ++t) {
      const auto& [a, b, c] = facets.triangles[t];
      const Point& corner = facets.vertices[a];
      const Vector ab = facets.vertices[b] - corner, ac = facets.vertices[c] - corner;
      const double twice = length(cross(ab, ac));
      area += 0.5 * twice;
      // Smaller about its centre, so that no start lies within the lift of a wall that rises from the rim.
      const double inner_radius = twice / (length(ab) + length(ac) + length(ac - ab));
      const double kept = 1.0 - (inner_radius > 4.0 * lift_m ? 2.0 * lift_m / inner_radius : 0.5);
      const Point start = corner + ((1.0 - kept) / 3.0) * (ab + ac) + lift_m * normal;
      pieces_.push_back({start, kept * ab, kept * ac, normal, side, area});
    }
  }
  for (Piece& piece : pieces_) piece.until /= area;
}

ReceiverSurface::Start ReceiverSurface::at(double u, double v) const {
  const auto found = std::find_if(pieces_.begin(), pieces_.end() - 1, [u](const Piece& p) { return u < p.until; });
  const double from = found == pieces_.begin() ? 0.0 : (found - 1)->until;
  const double rest = std::clamp((u - from) / (found->until - from), 0.0, 1.0);
  const double along = std::sqrt(rest);
  return {found->a + (along * (1.0 - v)) * found->ab + (along * v) * found->ac, found->normal, found->side};
}

}  // namespace radiometry::scene
