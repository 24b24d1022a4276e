// SPDX-License-Identifier: Apache-2.0
// The object of the demo: its size, that it is made of closed shells of plane quads, and that files keep it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "apps/scene/import/import_mesh.h"
#include "apps/scene/outputs/mesh_files.h"
#include "apps/scene/vehicle/vehicle.h"
#include "mesh_samples.h"
#include "mtf/io/sha256.h"

namespace {

using namespace scene_test;
using apps::scene::make_terrain;
using apps::scene::make_vehicle;
using apps::scene::write_obj;
using radiometry::scene::Mesh;
using radiometry::scene::Point;

const Mesh& vehicle() {
  static const Mesh mesh = make_vehicle();
  return mesh;
}

Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Point& a) { return std::sqrt(dot(a, a)); }

std::array<Point, 4> quad(const Mesh& mesh, std::size_t face) {
  std::array<Point, 4> points{};
  for (std::size_t k = 0; k < 4; ++k) points[k] = mesh.vertices[mesh.corners[mesh.first[face] + k]];
  return points;
}

Mesh in_single_precision(Mesh mesh) {
  for (Point& p : mesh.vertices)
    for (double& x : p) x = static_cast<double>(static_cast<float>(x));
  return mesh;
}

/// Distance of the fourth corner from the plane of the first three, by the longer diagonal.
double bend(const std::array<Point, 4>& q) {
  const Point normal = cross(minus(q[1], q[0]), minus(q[2], q[0]));
  return std::abs(dot(normal, minus(q[3], q[0]))) / length(normal) /
         std::max(length(minus(q[2], q[0])), length(minus(q[3], q[1])));
}

void expect_plane_convex_quads(const Mesh& mesh) {
  double worst = 0.0;
  for (std::size_t face = 0; face < mesh.faces(); ++face) {
    ASSERT_EQ(mesh.first[face + 1] - mesh.first[face], 4U);
    const std::array<Point, 4> q = quad(mesh, face);
    const Point normal = cross(minus(q[2], q[0]), minus(q[3], q[1]));
    for (std::size_t k = 0; k < 4; ++k)
      ASSERT_GT(dot(normal, cross(minus(q[(k + 1) % 4], q[k]), minus(q[(k + 2) % 4], q[(k + 1) % 4]))), 0.0) << face;
    worst = std::max(worst, bend(q));
  }
  EXPECT_LT(worst, 1e-6);
}

std::size_t positions(const Mesh& mesh) { return std::set<Point>(mesh.vertices.begin(), mesh.vertices.end()).size(); }

TEST(Vehicle, HasTheVerticesOfThePaper) {
  EXPECT_EQ(vehicle().vertices.size(), 178190U);
  EXPECT_EQ(positions(vehicle()), 178190U);
  EXPECT_EQ(positions(in_single_precision(vehicle())), 178190U);
  EXPECT_NEAR(static_cast<double>(vehicle().faces()), 178000.0, 1000.0);
  EXPECT_EQ(std::set<std::uint32_t>(vehicle().corners.begin(), vehicle().corners.end()).size(), 178190U);
}

TEST(Vehicle, HasFourRegions) {
  std::map<std::string, double> areas;
  for (std::size_t face = 0; face < vehicle().faces(); ++face) {
    const std::array<Point, 4> q = quad(vehicle(), face);
    areas[vehicle().group_names[vehicle().group[face]]] += 0.5 * length(cross(minus(q[2], q[0]), minus(q[3], q[1])));
  }
  ASSERT_EQ(areas.size(), 4U);
  for (const char* region : {"firing_part", "driving_part", "power_top", "others"})
    EXPECT_GT(areas[region], 10.0) << region;
  EXPECT_EQ(vehicle().material_names, (std::vector<std::string>{"armour", "steel", "rubber"}));
  for (const std::uint32_t material : vehicle().material) ASSERT_LT(material, 3U);
}

TEST(Vehicle, StandsOnTheGround) {
  Point low = vehicle().vertices.front(), high = low;
  for (const Point& p : vehicle().vertices)
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  EXPECT_NEAR(low[2], 0.0, 1e-6);
  EXPECT_NEAR(high[0] - low[0], 7.3, 0.05);
  EXPECT_NEAR(high[1] - low[1], 3.2, 0.05);
  EXPECT_NEAR(high[1] + low[1], 0.0, 1e-6);
  EXPECT_NEAR(high[2], 3.4, 0.05);  // of the aerials
}

TEST(Vehicle, QuadsArePlaneInBothPrecisions) {
  expect_plane_convex_quads(vehicle());
  expect_plane_convex_quads(in_single_precision(vehicle()));
}

// Every edge belongs to two faces, which run through it in opposite directions: shells are closed and wound alike. Each
// holds a positive volume: its normals point outwards.
TEST(Vehicle, IsMadeOfClosedShellsWhoseNormalsPointOutwards) {
  const Mesh& mesh = vehicle();
  std::vector<std::uint64_t> edges;
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&parent](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::size_t face = 0; face < mesh.faces(); ++face)
    for (std::size_t k = 0; k < 4; ++k) {
      const std::uint64_t from = mesh.corners[4 * face + k], to = mesh.corners[4 * face + (k + 1) % 4];
      edges.push_back((from << 32U) | to);
      parent[root(static_cast<std::uint32_t>(from))] = root(static_cast<std::uint32_t>(to));
    }
  std::sort(edges.begin(), edges.end());
  EXPECT_EQ(std::adjacent_find(edges.begin(), edges.end()), edges.end());
  for (const std::uint64_t edge : edges)
    ASSERT_TRUE(std::binary_search(edges.begin(), edges.end(), (edge << 32U) | (edge >> 32U)));

  std::map<std::uint32_t, double> volumes;
  for (std::size_t face = 0; face < mesh.faces(); ++face) {
    const std::array<Point, 4> q = quad(mesh, face);
    volumes[root(mesh.corners[4 * face])] += (dot(q[0], cross(q[1], q[2])) + dot(q[0], cross(q[2], q[3]))) / 6.0;
  }
  EXPECT_GT(volumes.size(), 150U);
  for (const auto& [shell, volume] : volumes) EXPECT_GT(volume, 0.0) << "the shell of vertex " << shell;
}

TEST(Vehicle, HasNoFaceTwice) {
  std::set<std::array<std::uint32_t, 4>> faces;
  for (std::size_t face = 0; face < vehicle().faces(); ++face) {
    std::array<std::uint32_t, 4> corners{};
    std::copy_n(vehicle().corners.begin() + static_cast<std::ptrdiff_t>(4 * face), 4, corners.begin());
    std::sort(corners.begin(), corners.end());
    ASSERT_EQ(std::adjacent_find(corners.begin(), corners.end()), corners.end());
    ASSERT_TRUE(faces.insert(corners).second) << face;
  }
}

TEST(Vehicle, Terrain) {
  const Mesh terrain = make_terrain();
  EXPECT_EQ(terrain.faces(), 8100U);
  EXPECT_EQ(positions(terrain), terrain.vertices.size());
  expect_plane_convex_quads(terrain);
  expect_plane_convex_quads(in_single_precision(terrain));
  double lowest = 0.0, highest = 0.0;
  for (const Point& p : terrain.vertices) {
    const bool under = std::abs(p[0]) < 4.0 && std::abs(p[1]) < 2.0;
    ASSERT_TRUE(!under || p[2] == -0.005) << p[2];
    lowest = std::min(lowest, p[2]);
    highest = std::max(highest, p[2]);
  }
  EXPECT_GT(highest - lowest, 0.5);
  EXPECT_LT(std::max(highest, -lowest), 1.0);
  for (std::size_t face = 0; face < terrain.faces(); ++face) {
    const std::array<Point, 4> q = quad(terrain, face);
    ASSERT_GT(cross(minus(q[2], q[0]), minus(q[3], q[1]))[2], 0.0);
  }
}

// The same bytes on every machine: the figure is of gcc 12 on x86-64, with and without FMA and optimisation.
TEST(Vehicle, FilesAreTheSameEverywhere) {
  const Folder folder;
  write_obj(folder / "vehicle.obj", vehicle());
  write_obj(folder / "terrain.obj", make_terrain());
  EXPECT_EQ(mtf::io::sha256_file(folder / "vehicle.obj"),
            "6f33b7d65a78dd7f516af26ca702afc6e638305c1f83322304532d837fe68c37");
  EXPECT_EQ(mtf::io::sha256_file(folder / "terrain.obj"),
            "a9ae96bc5bfbc5fad72677aba1d279e2f937ec21baa1208cdc0138bd4b8217b3");
}

TEST(Vehicle, ComesBackFromAFileAsItWas) {
  const Folder folder;
  const Mesh made = make_vehicle();
  write_obj(folder / "vehicle.obj", made);
  const Mesh read = apps::scene::import_mesh(folder / "vehicle.obj", 1.0);
  ASSERT_EQ(read.faces(), made.faces());
  ASSERT_EQ(read.vertices.size(), made.vertices.size());
  for (std::size_t face = 0; face < made.faces(); ++face) {
    ASSERT_EQ(quad(read, face), quad(made, face));
    ASSERT_EQ(read.group_names[read.group[face]], made.group_names[made.group[face]]);
    ASSERT_EQ(read.material_names[read.material[face]], made.material_names[made.material[face]]);
  }
}

}  // namespace
