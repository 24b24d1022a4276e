// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/repair/facet_polygon.h"

#include <algorithm>
#include <limits>

namespace radiometry::scene {

PolygonPlane plane_of(std::span<const Point> vertices, std::span<const std::uint32_t> corners) {
  // Differences from the first corner keep the digits of a small face that is far from the origin.
  const Point& base = vertices[corners[0]];
  Vector twice_area{}, low{}, high{}, mean{};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector a = vertices[corners[i]] - base;
    const Vector b = vertices[corners[(i + 1) % corners.size()]] - base;
    twice_area = twice_area + cross(a, b);
    mean = mean + (1.0 / static_cast<double>(corners.size())) * a;
    for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], a[k]), high[k] = std::max(high[k], a[k]);
  }
  PolygonPlane plane{.area_m2 = 0.5 * length(twice_area), .diameter_m = length(high - low)};
  if (plane.area_m2 == 0.0) return plane;
  plane.normal = (0.5 / plane.area_m2) * twice_area;
  for (const std::uint32_t corner : corners)
    plane.deviation_m = std::max(plane.deviation_m, std::abs(dot(plane.normal, vertices[corner] - base - mean)));
  return plane;
}

namespace {

/// Twice the signed area of the triangle, seen against the normal.
double turn(const Point& a, const Point& b, const Point& c, const Vector& normal) {
  return dot(normal, cross(b - a, c - a));
}

bool inside(const Point& p, const Point& a, const Point& b, const Point& c, const Vector& normal) {
  return turn(a, b, p, normal) >= 0.0 && turn(b, c, p, normal) >= 0.0 && turn(c, a, p, normal) >= 0.0;
}

}  // namespace

void append_triangles(std::span<const Point> vertices, std::span<const std::uint32_t> corners, const Vector& normal,
                      std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::vector<std::uint32_t> rest(corners.begin(), corners.end());
  while (rest.size() > 3) {
    const std::size_t n = rest.size();
    // The ear with the largest area, relative to its longest side, gives the best triangles; where rounding or a
    // polygon that crosses itself leaves no ear, the corner that is nearest to one is cut.
    std::size_t best = 0;
    double best_quality = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t before = (i + n - 1) % n, after = (i + 1) % n;
      const Point &a = vertices[rest[before]], &b = vertices[rest[i]], &c = vertices[rest[after]];
      const double longest = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
      double quality = turn(a, b, c, normal) / longest;
      if (quality <= best_quality) continue;
      const bool ear = quality > 0.0 && std::none_of(rest.begin(), rest.end(), [&](std::uint32_t other) {
                         return other != rest[before] && other != rest[i] && other != rest[after] &&
                                inside(vertices[other], a, b, c, normal);
                       });
      if (!ear) quality -= 4.0;  // below any ear's
      if (quality > best_quality) best = i, best_quality = quality;
    }
    triangles.push_back({rest[(best + n - 1) % n], rest[best], rest[(best + 1) % n]});
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(best));
  }
  triangles.push_back({rest[0], rest[1], rest[2]});
}

}  // namespace radiometry::scene
