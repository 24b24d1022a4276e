// SPDX-License-Identifier: Apache-2.0
// Where the sun reaches sides, against shadow rays from many points of each.

#include "radiometry/render/visibility/sides_in_sun.h"

#include <gtest/gtest.h>

#include <numbers>
#include <numeric>
#include <optional>

#include "radiometry/render/renderer.h"
#include "radiometry/scene/rays.h"
#include "render_cases.h"

namespace radiometry::render::test {
namespace {

using scene::operator-, scene::operator+, scene::operator*;

struct Counts {
  std::size_t partly = 0, wholly = 0, nowhere = 0, unknown = 0, places = 0, wrong = 0;
};

/// Every side that faces the sun, at places all over it. A place that is nearer to an outline than rays are exact may
/// be in the shadow or in the sun: rays that start close by disagree there, and it does not count. Rays start with a
/// lift, which moves a shadow on a side by the lift over the cosine of the sun.
Counts compared_with_rays(const scene::Mesh& mesh, const Vector& to_sun, int rays, std::uint64_t seed) {
  SmallScene made = small_scene(mesh, 300.0, grey(0.5), 300.0);
  made.scene.sun = Sun{.to_sun = (1.0 / scene::length(to_sun)) * to_sun, .direct_w_m2 = 900.0};
  const scene::Facets& facets = made.scene.facets();
  const scene::Beam beam(*made.scene.rays, to_sun);
  const Patches patches;
  VisibleSides sides(made.scene, patches, {.views = false});
  std::vector<std::uint32_t> all(2 * facets.size());
  std::iota(all.begin(), all.end(), 0U);
  sides.add(all);
  SidesInSun in_sun(facets, made.scene.sun->to_sun, beam.lift_m(), 2);
  in_sun.add(sides, 2);
  const auto lit_by_ray = [&](const Point& p) { return beam.blocked(std::span(&p, 1)) == 0; };
  scene::test::Uniform uniform(seed);
  Counts counts;
  for (std::size_t number = 0; number < sides.size(); ++number) {
    if (sides.sun_cosine(number) <= 1e-6F) continue;
    const std::uint32_t facet = sides.side(number) / 2;
    const Vector up = (sides.side(number) % 2 == 1 ? -1.0 : 1.0) * facets.facet[facet].normal;
    const InSun how = in_sun.of(number);
    ++(how == InSun::partly    ? counts.partly
       : how == InSun::wholly  ? counts.wholly
       : how == InSun::nowhere ? counts.nowhere
                               : counts.unknown);
    if (how == InSun::unknown) continue;
    const double rounding_m = 2e-5 + 2.0 * beam.lift_m() / static_cast<double>(sides.sun_cosine(number));
    for (std::uint64_t t = facets.first[facet]; t < facets.first[facet + 1]; ++t)
      for (int k = 0; k < rays; ++k, ++counts.places) {
        const auto& [a, b, c] = facets.triangles[t];
        const Vector ab = facets.vertices[b] - facets.vertices[a], ac = facets.vertices[c] - facets.vertices[a];
        double u = uniform(), v = uniform();
        if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
        u = 1e-4 + (1.0 - 3e-4) * u, v = 1e-4 + (1.0 - 3e-4) * v;  // rays at edges may slip past neighbours
        const Point on = facets.vertices[a] + u * ab + v * ac, p = on + beam.lift_m() * up;
        std::uint8_t lit = how == InSun::wholly ? 1 : 0;
        if (how == InSun::partly) {
          SunQuestion question{static_cast<std::uint32_t>(number), {}};
          for (std::size_t axis = 0; axis < 2; ++axis)
            question.place[axis] = scene::dot(in_sun.picture().axes()[axis], on - facets.middle);
          in_sun.reaches(std::span(&question, 1), std::span(&lit, 1));
        }
        const bool ray = lit_by_ray(p);
        if (ray == (lit != 0)) continue;
        bool outline = false;
        for (const Vector& aside : {ab, -1.0 * ab, ac, -1.0 * ac})
          outline = outline || lit_by_ray(p + rounding_m / scene::length(aside) * aside) != ray;
        counts.wrong += outline ? 0 : 1;
      }
  }
  return counts;
}

TEST(SidesInSun, MostSidesAreInTheSunOrInTheShadowAsAWhole) {
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
  scene::test::Uniform uniform(11);
  Counts sum;
  for (int k = 0; k < 60; ++k) {
    scene::Mesh mesh = empty_mesh();
    for (int n = 0; n < 12; ++n)
      add_plate(mesh, 2.0 * uniform() * uniform.direction(), 2.0 * uniform.direction(), 2.0 * uniform.direction());
    add_box(mesh, {-0.5, -0.5, -0.5}, {1, 1, 1}, 2);
    const Counts counts = compared_with_rays(mesh, uniform.direction(), 300, 100 + static_cast<std::uint64_t>(k));
    sum.wrong += counts.wrong, sum.wholly += counts.wholly, sum.nowhere += counts.nowhere;
    sum.partly += counts.partly, sum.unknown += counts.unknown;
  }
  EXPECT_EQ(sum.wrong, 0u);
  EXPECT_GT(sum.wholly, 50u);
  EXPECT_GT(sum.nowhere, 20u);
  EXPECT_GT(sum.partly, 500u);
  EXPECT_LT(sum.unknown, 20u);
}

// Large facets and some smaller than samples.
TEST(SidesInSun, PicturesAreThoseOfARayForEverything) {
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
          Renderer(made.scene, {mwir()}, {.points = n, .ray_shadows = true, .view_rays = 4}).render(eye);
      std::size_t differ = 0;
      for (std::int64_t i = 0; i < eye.width * eye.height; ++i)
        differ += std::abs(some.radiance[0].data()[i] / all.radiance[0].data()[i] - 1.0F) > 1e-5F ? 1 : 0;
      EXPECT_LT(differ, 1u) << grid << " " << n;
      EXPECT_EQ(some.shadow_rays, 0u) << grid << " " << n;
    }
  }
}

/// One side of a scene in the sun, and whether the sun reaches places of it.
struct OneSide {
  OneSide(const scene::Mesh& mesh, std::uint32_t side, const Vector& to_sun)
      : made(small_scene(mesh, 300.0, grey(0.5), 300.0)) {
    made.scene.sun = Sun{.to_sun = (1.0 / scene::length(to_sun)) * to_sun, .direct_w_m2 = 900.0};
    const scene::Beam beam(*made.scene.rays, to_sun);
    VisibleSides sides(made.scene, patches, {.views = false});
    sides.add(std::vector{side});
    in_sun.emplace(made.scene.facets(), made.scene.sun->to_sun, beam.lift_m(), 1);
    in_sun->add(sides, 1);
  }
  SunPicture::Place place(const Point& p) const {
    const Vector from_middle = p - made.scene.facets().middle;
    return {scene::dot(in_sun->picture().axes()[0], from_middle), scene::dot(in_sun->picture().axes()[1], from_middle)};
  }
  bool lit(const SunPicture::Place& p) const {
    if (in_sun->of(0) != InSun::partly) return in_sun->of(0) == InSun::wholly;
    const SunQuestion question{0, p};
    std::uint8_t answer = 0;
    in_sun->reaches(std::span(&question, 1), std::span(&answer, 1));
    return answer != 0;
  }
  SmallScene made;
  Patches patches;
  std::optional<SidesInSun> in_sun;
};

// A sphere of 2 m and edges of 8 cm over a plain of one square facet: its shadow is a disc in the picture of the sun.
TEST(SidesInSun, ALargeFacetHasTheOutlinesOfSmallOnes) {
  scene::test::Uniform uniform(5);
  for (const double plain_m : {100.0, 2000.0}) {
    const Point centre{0.3 * plain_m, -0.2 * plain_m, 5.0};
    scene::Mesh mesh = scene::test::sphere(centre, 1.0, 40);
    const auto ground = static_cast<std::uint32_t>(mesh.first.size() - 1);
    add_plate(mesh, {-plain_m / 2, -plain_m / 2, 0}, {plain_m, 0, 0}, {0, plain_m, 0});
    const OneSide side(mesh, 2 * ground, {0.5, 0.25, 0.6});
    ASSERT_EQ(side.in_sun->of(0), InSun::partly);
    const SunPicture::Place middle = side.place(centre);
    for (int k = 0; k < 20000; ++k) {
      const double x = 3.0 * uniform() - 1.5, y = 3.0 * uniform() - 1.5, from = std::hypot(x, y);
      if (from > 0.99 && from < 1.001) continue;  // the sphere has edges
      ASSERT_EQ(side.lit({middle[0] + x, middle[1] + y}), from > 1.0) << plain_m << " " << x << " " << y;
    }
  }
}

// The L-shaped roof of a house in coordinates of a map, written in millimetres, with its walls and nothing above it: it
// is flat only to the rounding of those coordinates, and a wall comes above its mean plane by that.
TEST(SidesInSun, ARoofFarFromTheOriginIsInTheSun) {
  scene::test::Uniform uniform(4);
  constexpr std::array<std::array<double, 2>, 6> kPlan{{{0, 0}, {20, 0}, {20, 8}, {9, 8}, {9, 17}, {0, 17}}};
  const auto written = [](double m) { return std::round(1e3 * m) / 1e3; };
  for (int house = 0; house < 60; ++house) {
    const Point at{std::floor(3e5 + 4e5 * uniform()), std::floor(5.2e6 + 5e5 * uniform()), 100.0};
    const double turn = 2.0 * std::numbers::pi * uniform(), pitch = 0.3 * uniform();
    std::vector<Point> roof;
    for (const auto& [x, y] : kPlan)
      roof.push_back({written(at[0] + std::cos(turn) * x - std::sin(turn) * y),
                      written(at[1] + std::sin(turn) * x + std::cos(turn) * y),
                      written(at[2] + 6.0 + pitch * (0.6 * x + 0.8 * y))});
    scene::Mesh mesh = empty_mesh();
    add_face(mesh, roof);
    for (std::size_t i = 0; i < roof.size(); ++i) {
      const Point &p = roof[i], &q = roof[(i + 1) % roof.size()];
      add_face(mesh, {{p[0], p[1], at[2]}, {q[0], q[1], at[2]}, q, p});
    }
    add_plate(mesh, at + Vector{-50, -50, 0}, {100, 0, 0}, {0, 100, 0});
    const OneSide side(mesh, 0, {0.3 * uniform(), 0.3 * uniform(), 1.0});
    const scene::Facets& facets = side.made.scene.facets();
    for (int k = 0; k < 1000; ++k) {
      const auto& [a, b, c] = facets.triangles[static_cast<std::size_t>(k) % (facets.first[1] - facets.first[0])];
      const double u = uniform(), v = (1.0 - u) * uniform();
      ASSERT_TRUE(side.lit(side.place(facets.vertices[a] + u * (facets.vertices[b] - facets.vertices[a]) +
                                      v * (facets.vertices[c] - facets.vertices[a]))))
          << house;
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
  EXPECT_EQ(sides.find({0, false}).in_sun, InSun::wholly);
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
    return SidesInSun(facets, {0, 0, 1}, 1e-7, 1).find({0, !up}).in_sun;
  };
  EXPECT_EQ(lit_below({-1, 0, 0}), InSun::nowhere);
  EXPECT_EQ(lit_below({1, 0, 0.1}), InSun::partly);
}

}  // namespace
}  // namespace radiometry::render::test
