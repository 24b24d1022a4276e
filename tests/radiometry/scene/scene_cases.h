// SPDX-License-Identifier: Apache-2.0
#pragma once

// Meshes for tests, made of rectangles.

#include <cmath>
#include <numbers>
#include <vector>

#include "radiometry/scene/rays.h"

namespace radiometry::scene::test {

inline Mesh empty_mesh() {
  Mesh mesh;
  mesh.first = {0};
  mesh.group_names = {"all"};
  mesh.material_names = {"paint"};
  return mesh;
}

inline void add_face(Mesh& mesh, const std::vector<Point>& corners) {
  for (const Point& corner : corners) {
    mesh.corners.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    mesh.vertices.push_back(corner);
  }
  mesh.first.push_back(mesh.corners.size());
  mesh.group.push_back(0);
  mesh.material.push_back(0);
}

/// The parallelogram at `corner` with sides `u` and `v`, divided into n x m; its front is where u x v points.
inline void add_plate(Mesh& mesh, const Point& corner, const Vector& u, const Vector& v, int n = 1, int m = 1) {
  const auto at = [&](int i, int j) {
    return corner + (static_cast<double>(i) / n) * u + (static_cast<double>(j) / m) * v;
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) add_face(mesh, {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
}

/// A box, each side divided into n x n; `facing` 1: normals point out, -1: in.
inline void add_box(Mesh& mesh, const Point& low, const Vector& size, int n = 1, int facing = 1) {
  const Vector x{size[0], 0, 0}, y{0, size[1], 0}, z{0, 0, size[2]};
  const auto add = [&](const Point& corner, const Vector& u, const Vector& v) {
    if (facing > 0)
      add_plate(mesh, corner, u, v, n, n);
    else
      add_plate(mesh, corner, v, u, n, n);
  };
  add(low, y, x), add(low + z, x, y);
  add(low, x, z), add(low + y, z, x);
  add(low, z, y), add(low + x, y, z);
}

/// A sphere of triangles and quads, normals out.
inline Mesh sphere(const Point& centre, double radius, int n) {
  Mesh mesh = empty_mesh();
  const auto at = [&](int i, int j) -> Point {
    const double t = std::numbers::pi * i / n, p = std::numbers::pi * (j % (2 * n)) / n;
    if (i == 0 || i == n) return centre + Vector{0, 0, i == 0 ? radius : -radius};
    return centre + radius * Vector{std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)};
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 2 * n; ++j) {
      if (i == 0)
        add_face(mesh, {at(0, 0), at(1, j), at(1, j + 1)});
      else if (i == n - 1)
        add_face(mesh, {at(i, j), at(n, 0), at(i, j + 1)});
      else
        add_face(mesh, {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

inline Facets facets(const Mesh& mesh, Winding winding = Winding::as_given) {
  const PlacedMesh placed{"made", &mesh, winding};
  return facets_of(std::span(&placed, 1));
}

/// Numbers in [0, 1) by a linear congruence (Knuth's MMIX).
class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : state_(seed) {}
  double operator()() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return 0x1p-53 * static_cast<double>(state_ >> 11);
  }
  Vector direction() {
    const double z = 2.0 * (*this)() - 1.0, p = 2.0 * std::numbers::pi * (*this)(), s = std::sqrt(1.0 - z * z);
    return {s * std::cos(p), s * std::sin(p), z};
  }

 private:
  std::uint64_t state_;
};

}  // namespace radiometry::scene::test
