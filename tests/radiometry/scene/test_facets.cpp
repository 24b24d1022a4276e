// SPDX-License-Identifier: Apache-2.0

// Facets of meshes: what is kept, what is repaired and counted, and what is refused.

#include <gtest/gtest.h>

#include <limits>

#include "tests/expect_error.h"
#include "tests/radiometry/scene/scene_cases.h"

namespace radiometry::scene {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();

double total_area(const Facets& facets) {
  double sum = 0.0;
  for (const Facet& facet : facets.facet) sum += facet.area_m2;
  return sum;
}

TEST(Facets, BoxIsSixClosedFacetsWithWeldedCorners) {
  Mesh mesh = test::empty_mesh();
  test::add_box(mesh, {1, 2, 3}, {2, 3, 4});
  const Facets facets = test::facets(mesh);
  ASSERT_EQ(facets.size(), 6U);
  EXPECT_EQ(facets.triangles.size(), 12U);
  EXPECT_EQ(facets.vertices.size(), 8U);
  EXPECT_EQ(facets.report[0].welded, 16U);
  EXPECT_EQ(facets.report[0].turned, 0U);
  ASSERT_EQ(facets.shells.size(), 1U);
  EXPECT_TRUE(facets.shells[0].closed);
  EXPECT_EQ(facets.shells[0].facets, 6U);
  EXPECT_NEAR(total_area(facets), 2 * (6 + 8 + 12), 1e-13);
  EXPECT_TRUE(facets.warnings.empty());
  const Point middle{2, 3.5, 5};
  for (const Facet& facet : facets.facet) {
    EXPECT_NEAR(length(facet.normal), 1.0, 1e-15);
    EXPECT_GT(dot(facet.normal, facet.centre - middle), 0.5);
  }
}

TEST(Facets, TurnedFacesAndInvertedShellsAreMended) {
  Mesh mesh = test::empty_mesh();
  test::add_box(mesh, {0, 0, 0}, {1, 1, 1}, 3, -1);
  const auto reverse = [&](std::size_t face) {
    std::reverse(mesh.corners.begin() + static_cast<std::ptrdiff_t>(mesh.first[face]),
                 mesh.corners.begin() + static_cast<std::ptrdiff_t>(mesh.first[face + 1]));
  };
  for (const std::size_t face : {0U, 7U, 20U, 41U}) reverse(face);
  const Facets outward = test::facets(mesh, Winding::outward), given = test::facets(mesh, Winding::as_given);
  EXPECT_EQ(outward.report[0].turned, 50U);
  EXPECT_EQ(given.report[0].turned, 4U);
  for (const Facet& facet : outward.facet) EXPECT_GT(dot(facet.normal, facet.centre - Point{0.5, 0.5, 0.5}), 0.4);
  for (const Facet& facet : given.facet) EXPECT_LT(dot(facet.normal, facet.centre - Point{0.5, 0.5, 0.5}), -0.4);
}

TEST(Facets, BoxesThatShareAnEdgeAreClosedShellsOfTheirOwn) {
  Mesh mesh = test::empty_mesh();
  test::add_box(mesh, {0, 0, 0}, {1, 1, 1});
  test::add_box(mesh, {1, 1, 0}, {1, 1, 1});
  const Facets facets = test::facets(mesh, Winding::outward);
  EXPECT_EQ(facets.report[0].shells, 2U);
  EXPECT_EQ(facets.report[0].open_shells, 0U);
  EXPECT_EQ(facets.report[0].turned, 0U);
}

TEST(Facets, MoebiusStripIsOpenAndOneSided) {
  Mesh mesh = test::empty_mesh();
  constexpr int n = 24;
  const auto rim = [](int i, double w) -> Point {
    const double a = 2.0 * std::numbers::pi * i / n, b = 0.5 * a;
    return {(2 + w * std::cos(b)) * std::cos(a), (2 + w * std::cos(b)) * std::sin(a), w * std::sin(b)};
  };
  for (int i = 0; i < n; ++i) {
    const bool last = i + 1 == n;
    const Point a = rim(i, -0.5), b = rim(i, 0.5), c = last ? rim(0, -0.5) : rim(i + 1, 0.5),
                d = last ? rim(0, 0.5) : rim(i + 1, -0.5);
    test::add_face(mesh, {a, b, c});
    test::add_face(mesh, {a, c, d});
  }
  const Facets facets = test::facets(mesh);
  EXPECT_EQ(facets.report[0].shells, 1U);
  EXPECT_EQ(facets.report[0].open_shells, 1U);
  EXPECT_EQ(facets.report[0].one_sided, 1U);
  ASSERT_EQ(facets.warnings.size(), 1U);
  expect_says(facets.warnings[0], {"of 1 shells", "hole", "winding"});
}

TEST(Facets, HolesAreWarnedOfAndSheetsAreNot) {
  Mesh mesh = test::empty_mesh();
  test::add_plate(mesh, {0, 0, 0}, {5, 0, 0}, {0, 5, 0}, 4, 4);
  EXPECT_TRUE(test::facets(mesh).warnings.empty());
  EXPECT_EQ(test::facets(mesh).report[0].open_shells, 1U);
  test::add_box(mesh, {0, 0, 1}, {1, 1, 1}, 2);
  mesh.corners.resize(mesh.corners.size() - 4);
  mesh.first.pop_back(), mesh.group.pop_back(), mesh.material.pop_back();
  const Facets facets = test::facets(mesh);
  EXPECT_EQ(facets.report[0].open_shells, 2U);
  EXPECT_EQ(facets.report[0].with_hole, 1U);
  ASSERT_EQ(facets.warnings.size(), 1U);
  expect_says(facets.warnings[0], {"mesh `made`", "1 of 2 shells", "hole"});
}

TEST(Facets, FlatPolygonsStayAndOthersAreDivided) {
  Mesh mesh = test::empty_mesh();
  test::add_face(mesh, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5e-6}, {0, 1, 0}});  // flat within 1e-6 of 1.4 m
  test::add_face(mesh, {{2, 0, 0}, {3, 0, 0}, {3, 1, 1e-3}, {2, 1, 0}});    // not flat
  // Concave, an L: area 3, first moments 2.5.
  test::add_face(mesh, {{5, 0, 0}, {7, 0, 0}, {7, 1, 0}, {6, 1, 0}, {6, 2, 0}, {5, 2, 0}});
  const Facets facets = test::facets(mesh);
  ASSERT_EQ(facets.size(), 4U);
  EXPECT_EQ(facets.report[0].not_flat, 1U);
  EXPECT_EQ(facets.facet[1].face, 1U);
  EXPECT_EQ(facets.facet[2].face, 1U);
  EXPECT_EQ(facets.first[1] - facets.first[0], 2U);
  EXPECT_EQ(facets.first[2] - facets.first[1], 1U);
  EXPECT_EQ(facets.first[4] - facets.first[3], 4U);
  EXPECT_NEAR(facets.facet[3].area_m2, 3.0, 1e-14);
  EXPECT_NEAR(facets.facet[3].centre[0], 5 + 2.5 / 3, 1e-14);
  EXPECT_NEAR(facets.facet[3].centre[1], 2.5 / 3, 1e-14);
  // No triangle of the L reaches over its inner corner.
  for (std::uint64_t t = facets.first[3]; t < facets.first[4]; ++t) {
    const auto& [a, b, c] = facets.triangles[t];
    EXPECT_GT(cross(facets.vertices[b] - facets.vertices[a], facets.vertices[c] - facets.vertices[a])[2], 0.0);
  }
}

TEST(Facets, CoordinatesRoundedToSinglePrecisionStayFlat) {
  Mesh mesh = test::empty_mesh();
  const Vector u{0.03, 0.01, 0.02}, v{-0.01, 0.03, 0.005};
  test::add_plate(mesh, {4, 3, 2}, 40.0 * u, 40.0 * v, 40, 40);
  for (Point& p : mesh.vertices)
    for (double& x : p) x = static_cast<float>(x);
  EXPECT_EQ(test::facets(mesh).size(), 1600U);
}

TEST(Facets, BadFacesAreLeftOutAndCounted) {
  Mesh mesh = test::empty_mesh();
  test::add_plate(mesh, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  test::add_face(mesh, {{kNaN, 0, 0}, {1, 0, 0}, {1, 1, 0}});
  test::add_face(mesh, {{0, kInf, 0}, {1, 0, 0}, {1, 1, 0}});
  test::add_face(mesh, {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}});             // no area
  test::add_face(mesh, {{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {1, 0, 0}});  // two corners
  test::add_face(mesh, {{1, 1, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}});  // the plate again
  test::add_face(mesh, {{1, 1, 0}, {1, 0, 0}, {0, 0, 0}, {0, 1, 0}});  // and from behind
  test::add_face(mesh, {{0, 0, 5}, {1, 0, 5}, {1, 1, 5}});
  mesh.corners.back() = 4000000000U;
  const Facets facets = test::facets(mesh);
  const MeshReport& report = facets.report[0];
  EXPECT_EQ(facets.size(), 1U);
  EXPECT_EQ(report.faces, 8U);
  EXPECT_EQ(report.not_finite, 2U);
  EXPECT_EQ(report.degenerate, 2U);
  EXPECT_EQ(report.duplicate, 2U);
  EXPECT_EQ(report.bad_index, 1U);
  ASSERT_FALSE(facets.warnings.empty());
  expect_says(facets.warnings[0], {"mesh `made`", "7 of 8 faces"});
  const Rays rays(facets);
  EXPECT_EQ(rays.first_hit({{0.5, 0.5, 1}, {0, 0, -1}}).facet, 0U);
}

TEST(Facets, ScenesWithoutFacesAreRefusedByName) {
  const Mesh none = test::empty_mesh();
  expect_refused({"made", "no face"}, [&] { test::facets(none); });
  expect_refused({"no face"}, [] { facets_of({}); });
  Mesh bad = test::empty_mesh();
  test::add_face(bad, {{kNaN, 0, 0}, {1, 0, 0}, {1, 1, 0}});
  expect_refused({"made", "1 of 1 faces"}, [&] { test::facets(bad); });
  Mesh torn = test::empty_mesh();
  test::add_plate(torn, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  torn.first.back() = 77;
  expect_refused({"made", "list of corners"}, [&] { test::facets(torn); });
  torn.first.pop_back();
  expect_refused({"made", "starts of faces"}, [&] { test::facets(torn); });
  torn.material.clear();
  expect_refused({"made", "materials"}, [&] { test::facets(torn); });
}

TEST(Facets, UnlikelySizesAreWarnedOfAndImpossibleOnesRefused) {
  Mesh large = test::empty_mesh();
  test::add_box(large, {0, 0, 0}, {7000, 3000, 2500});
  const Facets facets = test::facets(large);
  ASSERT_EQ(facets.warnings.size(), 1U);
  expect_says(facets.warnings[0], {"mesh `made`", "7000 m", "unit"});
  Mesh huge = test::empty_mesh();
  test::add_plate(huge, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  huge.vertices[2][0] = 1e30;
  expect_refused({"made", "1e9 m along x"}, [&] { test::facets(huge); });
  huge.vertices[2][0] = 1e308, huge.vertices[0][0] = -1e308;
  expect_refused({"made", "1e9 m along x"}, [&] { test::facets(huge); });
  Mesh many = test::empty_mesh();
  std::vector<Point> corners;
  for (int i = 0; i < 2001; ++i) corners.push_back({std::cos(i * 3e-3), std::sin(i * 3e-3), 0});
  test::add_face(many, corners);
  expect_refused({"made", "2001 corners"}, [&] { test::facets(many); });
}

TEST(Facets, FarFromTheOriginAreasAndRaysStayExact) {
  Mesh mesh = test::empty_mesh();
  const Point far{1e7, -1e7, 1e7};
  test::add_box(mesh, far, {2, 2, 2}, 8);
  const Facets facets = test::facets(mesh);
  EXPECT_TRUE(facets.shells[0].closed);
  for (const Facet& facet : facets.facet) EXPECT_NEAR(facet.area_m2, 0.0625, 1e-8);
  const Rays rays(facets);
  const Hit hit = rays.first_hit({far + Vector{0.6, 0.7, 5}, {0, 0, -2}});
  ASSERT_TRUE(hits(hit));
  EXPECT_NEAR(hit.distance_m, 3.0, 1e-8);
  EXPECT_FALSE(hit.back);
  EXPECT_NEAR(rays.facets().facet[hit.facet].centre[0] - far[0], 0.625, 1e-8);
}

TEST(Facets, OneTriangle) {
  Mesh mesh = test::empty_mesh();
  test::add_face(mesh, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const Rays rays(test::facets(mesh));
  EXPECT_EQ(rays.first_hit({{0.2, 0.2, -1}, {0, 0, 1}}).back, true);
  EXPECT_FALSE(hits(rays.first_hit({{0.8, 0.8, -1}, {0, 0, 1}})));
}

TEST(Facets, SetsOfSides) {
  const std::vector<Side> sides{{4, false}, {2, true}, {7, false}};
  const Receivers sets = sets_of_sides(sides, std::vector<std::uint32_t>{1, 0, 1}, 2);
  ASSERT_EQ(sets.size(), 2U);
  EXPECT_EQ(sets[0].size(), 1U);
  EXPECT_EQ(sets[0][0], (Side{2, true}));
  EXPECT_EQ(sets[1][0], (Side{4, false}));
  EXPECT_EQ(sets[1][1], (Side{7, false}));
  expect_refused({"set 1 of 1"}, [&] { sets_of_sides(sides, std::vector<std::uint32_t>{1, 0, 1}, 1); });
}

}  // namespace
}  // namespace radiometry::scene
