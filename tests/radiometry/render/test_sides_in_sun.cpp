// SPDX-License-Identifier: Apache-2.0
// What is said of whole sides, against shadow rays from many points of each.

#include "radiometry/render/visibility/sides_in_sun.h"

#include <gtest/gtest.h>

#include <numbers>

#include "radiometry/render/renderer.h"
#include "radiometry/scene/beam.h"
#include "render_cases.h"

namespace radiometry::render::test {
namespace {

using scene::operator-, scene::operator+, scene::operator*;

struct Counts {
  std::size_t partly = 0, wholly = 0, nowhere = 0, wrong = 0;
};

Counts compared_with_rays(const scene::Mesh& mesh, const Vector& to_sun, int rays, std::uint64_t seed) {
  const SmallScene made = small_scene(mesh, 300.0, grey(0.5), 300.0);
  const scene::Facets& facets = made.scene.facets();
  const scene::Beam beam(*made.scene.rays, to_sun);
  const SidesInSun sides(facets, to_sun, beam.lift_m(), 2);
  scene::test::Uniform uniform(seed);
  Counts counts;
  for (std::uint32_t facet = 0; facet < facets.size(); ++facet)
    for (const bool back : {false, true}) {
      const Vector up = (back ? -1.0 : 1.0) * facets.facet[facet].normal;
      if (scene::dot(up, to_sun) <= 1e-9) continue;
      int lit = 0, all = 0;
      for (std::uint64_t t = facets.first[facet]; t < facets.first[facet + 1]; ++t)
        for (int k = 0; k < rays; ++k, ++all) {
          const auto& [a, b, c] = facets.triangles[t];
          double u = uniform(), v = uniform();
          if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
          // Points nearer to an edge than the rounding of rays belong to neither side of a shadow's outline.
          u = 1e-4 + (1.0 - 3e-4) * u, v = 1e-4 + (1.0 - 3e-4) * v;
          const Point p = facets.vertices[a] + u * (facets.vertices[b] - facets.vertices[a]) +
                          v * (facets.vertices[c] - facets.vertices[a]) + beam.lift_m() * up;
          lit += beam.blocked(std::span(&p, 1)) == 0 ? 1 : 0;
        }
      switch (sides.find({facet, back})) {
        case InSun::partly:
          ++counts.partly;
          break;
        case InSun::wholly:
          ++counts.wholly;
          counts.wrong += lit < all ? 1 : 0;
          break;
        case InSun::nowhere:
          ++counts.nowhere;
          counts.wrong += lit > 0 ? 1 : 0;
      }
    }
  return counts;
}

TEST(SidesInSun, OnlyThoseUnderAnOutlineAreLeftToRays) {
  scene::Mesh mesh = scene::test::sphere({0.0, 0.0, 2.0}, 1.5, 24);
  add_plate(mesh, {-10, -10, 0}, {20, 0, 0}, {0, 20, 0}, 60, 60);
  add_box(mesh, {3, -2, 0.5}, {2, 2, 1}, 5);
  const Counts counts = compared_with_rays(mesh, {0.5, 0.25, 0.6}, 40, 1);
  EXPECT_EQ(counts.wrong, 0u);
  EXPECT_GT(counts.nowhere, 100u);  // squares of 1/3 m in shadows of some 20 square metres
  EXPECT_GT(counts.wholly, 3000u);
  EXPECT_LT(counts.partly, 250u);  // along some 30 m of outline, and round the terminator of the sphere
}

// Sheets and bodies that cut each other, in any direction: no edge is in the place of another.
TEST(SidesInSun, NothingIsWrongAmongTrianglesThatCross) {
  scene::test::Uniform uniform(7);
  Counts sum;
  for (int k = 0; k < 60; ++k) {
    scene::Mesh mesh = empty_mesh();
    for (int n = 0; n < 12; ++n)
      add_plate(mesh, 2.0 * uniform() * uniform.direction(), 2.0 * uniform.direction(), 2.0 * uniform.direction());
    add_box(mesh, {-0.5, -0.5, -0.5}, {1, 1, 1}, 2);
    const Counts counts = compared_with_rays(mesh, uniform.direction(), 300, 100 + static_cast<std::uint64_t>(k));
    sum.wrong += counts.wrong, sum.wholly += counts.wholly, sum.nowhere += counts.nowhere;
  }
  EXPECT_EQ(sum.wrong, 0u);
  EXPECT_GT(sum.wholly, 50u);
  EXPECT_GT(sum.nowhere, 20u);
}

// Facets smaller than the squares that rays are for: nothing but rays of their own tells where the outline is.
TEST(SidesInSun, OutlinesOnSmallFacetsAreThoseOfARayForEverything) {
  for (const int grid : {10, 160}) {
    scene::Mesh mesh = scene::test::sphere({-2.0, 1.0, 1.5}, 0.8, 24);
    add_plate(mesh, {-6, -6, 0}, {12, 0, 0}, {0, 12, 0}, grid, grid);
    add_box(mesh, {-1, -1, 0.5}, {2, 2, 1}, 3);
    SmallScene made = small_scene(mesh, 300.0, grey(0.5), 300.0);
    made.scene.sun = Sun{.to_sun = {0.5, 0.25, 0.6}, .direct_w_m2 = 900.0};
    const Camera eye = camera({.position = {0.1, -9, 12}, .look_at = {-0.8, -0.4, 0}}, 240, 180, 0.003);
    for (const int n : {1, 2}) {
      const RenderedFrame some = Renderer(made.scene, {mwir()}, {.points = n, .view_rays = 4}).render(eye);
      const RenderedFrame all =
          Renderer(made.scene, {mwir()}, {.points = n, .all_shadows = true, .view_rays = 4}).render(eye);
      std::size_t differ = 0;
      for (std::int64_t i = 0; i < eye.width * eye.height; ++i)
        differ += std::abs(some.radiance[0].data()[i] / all.radiance[0].data()[i] - 1.0F) > 1e-5F ? 1 : 0;
      EXPECT_LT(differ, grid == 10 ? 10u : 1u) << grid << " " << n;  // slivers at corners of the box's shadow
      EXPECT_LT(some.shadow_rays, all.shadow_rays / 2) << grid << " " << n;
    }
  }
}

// A cone whose apex all triangles share.
TEST(SidesInSun, ManyTrianglesAtOneVertexTakeNoLonger) {
  constexpr int kTriangles = 60000;
  scene::Mesh mesh = empty_mesh();
  const auto rim = [](int k) {
    const double turn = 2.0 * std::numbers::pi * (k % kTriangles) / kTriangles;
    return Point{std::cos(turn), std::sin(turn), 0.0};
  };
  for (int k = 0; k < kTriangles; ++k) add_face(mesh, {{0, 0, 1}, rim(k), rim(k + 1)});
  const SmallScene made = small_scene(mesh, 300.0, grey(0.5), 300.0);
  const SidesInSun sides(made.scene.facets(), {0, 0, 1}, 1e-7, 1);
  EXPECT_EQ(sides.find({0, false}), InSun::wholly);
}

// A plate in two halves, one of them wound the other way, over a floor: their common edge is no outline. A sheet that
// is folded flat ends in one.
TEST(SidesInSun, EdgesInsideASheetAreNoOutlines) {
  const auto lit_below = [](const Vector& second) {
    scene::Mesh mesh = empty_mesh();
    add_plate(mesh, {-0.1, -0.1, 0}, {0.2, 0, 0}, {0, 0.2, 0});
    add_plate(mesh, {0, -1, 1}, {1, 0, 0}, {0, 2, 0});
    add_plate(mesh, {0, -1, 1}, {0, 2, 0}, second);
    const SmallScene made = small_scene(mesh, 300.0, grey(0.5), 300.0);
    const scene::Facets& facets = made.scene.facets();
    const bool up = facets.facet[0].normal[2] > 0.0;
    return SidesInSun(facets, {0, 0, 1}, 1e-7, 1).find({0, !up});
  };
  EXPECT_EQ(lit_below({-1, 0, 0}), InSun::nowhere);
  EXPECT_EQ(lit_below({1, 0, 0.1}), InSun::partly);
}

}  // namespace
}  // namespace radiometry::render::test
