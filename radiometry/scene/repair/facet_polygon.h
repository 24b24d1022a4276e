// SPDX-License-Identifier: Apache-2.0
#pragma once

// One polygon of a mesh: its mean plane, its diameter, and triangles that cover it.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "radiometry/scene/vectors.h"

namespace radiometry::scene {

struct PolygonPlane {
  Vector normal{};  ///< of length 1; 0 where there is no area
  double area_m2 = 0.0;
  double diameter_m = 0.0;   ///< diagonal of the box around it
  double deviation_m = 0.0;  ///< largest distance of a corner from the plane through the mean of the corners
};

/// Newell's plane. `corners` index `vertices`.
PolygonPlane plane_of(std::span<const Point> vertices, std::span<const std::uint32_t> corners);

/// Appends triangles that cover the polygon, by cutting ears (Meisters, "Polygons have ears", Am. Math. Mon. 82, 1975);
/// concave polygons too. Of one that crosses itself the triangles still use all corners, in the order of the polygon.
void append_triangles(std::span<const Point> vertices, std::span<const std::uint32_t> corners, const Vector& normal,
                      std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace radiometry::scene
