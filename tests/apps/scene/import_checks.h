// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a mesh that was imported is, and what refusals say.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "apps/scene/import/import_mesh.h"
#include "mesh_samples.h"
#include "mtf/error.h"
#include "tests/expect_error.h"

namespace scene_test {

using apps::scene::import_mesh;
using radiometry::scene::Mesh;
using radiometry::scene::Point;

inline std::vector<Point> face(const Mesh& mesh, std::size_t i) {
  std::vector<Point> points;
  for (std::uint64_t k = mesh.first[i]; k < mesh.first[i + 1]; ++k) points.push_back(mesh.vertices[mesh.corners[k]]);
  return points;
}

inline std::string refusal(const fs::path& file) {
  return message_of([&] { static_cast<void>(import_mesh(file, 1.0)); });
}

inline void expect_refused(const fs::path& file, std::initializer_list<std::string_view> parts) {
  const std::string message = refusal(file);
  expect_says(message, {file.filename().string()});
  expect_says(message, parts);
}

inline double area(const Mesh& mesh) {
  double sum = 0.0;  // of triangles and quads that lie in z = 0
  for (std::size_t i = 0; i < mesh.faces(); ++i) {
    const std::vector<Point> p = face(mesh, i);
    for (std::size_t k = 0; k < p.size(); ++k) {
      const Point &a = p[k], &b = p[(k + 1) % p.size()];
      sum += 0.5 * (a[0] * b[1] - a[1] * b[0]);
    }
  }
  return sum;
}

}  // namespace scene_test
