// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/scene/vehicle/solids.h"
#include "apps/scene/vehicle/vehicle.h"

namespace apps::scene {
namespace {

constexpr int cells = 90;                            // along a side
constexpr double half_side = 40.0, height = -0.005;  // m, the latter under the vehicle

// Lines that are 0.3 m apart in the middle and farther outwards.
double line(int i) {
  constexpr double stretch = 2.9;
  const double u = 2.0 * i / cells - 1.0;
  return to_micrometres(half_side * std::sinh(stretch * u) / std::sinh(stretch));
}

// From 0 where |x| < flat to 1 at twice that, smoothly.
double away(double x, double flat) {
  const double u = std::clamp(std::abs(x) / flat - 1.0, 0.0, 1.0);
  return u * u * (3.0 - 2.0 * u);
}

double wave(double x, double length, double phase) { return std::sin(2 * std::numbers::pi * x / length + phase); }

double along_x(double x) { return away(x, 5.0) * (0.30 * wave(x, 31.0, 0.4) + 0.10 * wave(x, 11.0, 2.0)); }
double along_y(double y) { return away(y, 3.5) * (0.35 * wave(y, 37.0, 1.1) + 0.08 * wave(y, 9.0, 0.3)); }

}  // namespace

// z = f(x) + g(y) over a rectangular grid: opposite corners of a cell have the same sum of heights, so it is plane.
radiometry::scene::Mesh make_terrain() {
  radiometry::scene::Mesh mesh;
  mesh.group_names = mesh.material_names = {"terrain"};
  mesh.first.push_back(0);
  const auto number = [](int i, int j) { return static_cast<std::uint32_t>(i * (cells + 1) + j); };
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= cells; ++j)
      mesh.vertices.push_back(
          {line(i), line(j),
           to_micrometres(height + to_micrometres(along_x(line(i))) + to_micrometres(along_y(line(j))))});
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      for (const std::uint32_t corner : {number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)})
        mesh.corners.push_back(corner);
      mesh.first.push_back(mesh.corners.size());
      mesh.group.push_back(0);
      mesh.material.push_back(0);
    }
  return mesh;
}

}  // namespace apps::scene
