// SPDX-License-Identifier: Apache-2.0

// Rays against brute force in double precision, inside closed meshes, and those that Embree must never see.

#include <gtest/gtest.h>

#include <limits>

#include "radiometry/scene/rays.h"
#include "tests/expect_error.h"
#include "tests/radiometry/scene/scene_cases.h"

namespace radiometry::scene {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();

/// A scene with boxes, a sphere and tilted plates on a ground, some facets hidden behind others.
Facets cluttered() {
  static const Mesh mesh = [] {
    Mesh made = test::sphere({0.3, -0.2, 1.4}, 0.8, 12);
    test::add_plate(made, {-5, -5, 0}, {10, 0, 0}, {0, 10, 0}, 9, 11);
    test::add_box(made, {1, 1, 0.1}, {1, 2, 0.7}, 3);
    test::Uniform random(5);
    for (int i = 0; i < 60; ++i) {
      const Point corner{6 * random() - 3, 6 * random() - 3, 3 * random()};
      test::add_plate(made, corner, random.direction(), 0.5 * random.direction(), 2, 2);
    }
    return made;
  }();
  return test::facets(mesh);
}

struct Found {
  double distance = kInf, edge = 1.0;  // `edge`: least barycentric coordinate of the hit
  std::uint32_t facet = kNone;
  double next = kInf;  // distance of the second hit
};

/// Moeller and Trumbore's test of every triangle.
Found brute_force(const Facets& facets, const Ray& ray) {
  Found found;
  for (std::size_t t = 0; t < facets.triangles.size(); ++t) {
    const auto& [a, b, c] = facets.triangles[t];
    const Vector ab = facets.vertices[b] - facets.vertices[a], ac = facets.vertices[c] - facets.vertices[a];
    const Vector p = cross(ray.direction, ac), s = ray.origin - facets.vertices[a], q = cross(s, ab);
    const double det = dot(ab, p);
    if (det == 0.0) continue;
    const double u = dot(s, p) / det, v = dot(ray.direction, q) / det, distance = dot(ac, q) / det;
    const double inside = std::min({u, v, 1.0 - u - v});
    if (inside < -1e-6 || distance <= 0.0) continue;
    // Of a ray that passes within 1e-6 of an edge, and of two facets at the same distance, either answer is right.
    if (distance < found.distance)
      found = {distance, inside, facets.facet_of[t], found.distance};
    else
      found.next = std::min(found.next, distance);
  }
  return found;
}

TEST(Rays, FacetAndDistanceAreThoseOfBruteForce) {
  const Rays rays(cluttered());
  test::Uniform random(1);
  std::vector<Ray> list;
  for (int i = 0; i < 40000; ++i)
    list.push_back({{8 * random() - 4, 8 * random() - 4, 4 * random() - 0.5}, random.direction()});
  std::vector<Hit> many(list.size());
  rays.first_hits(list, many, 2);
  int compared = 0, hit = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Found truth = brute_force(rays.facets(), list[i]);
    if (std::abs(truth.edge) < 1e-6 || truth.next - truth.distance < 1e-6) continue;
    for (const Hit& got : {rays.first_hit(list[i]), many[i]}) {
      ASSERT_EQ(got.facet, truth.facet) << i;
      if (truth.facet == kNone) continue;
      ASSERT_NEAR(got.distance_m, truth.distance, 1e-9 * (1 + truth.distance)) << i;
      ASSERT_EQ(got.back, dot(rays.facets().facet[got.facet].normal, list[i].direction) > 0.0);
    }
    ++compared;
    hit += truth.facet != kNone ? 1 : 0;
  }
  EXPECT_GT(compared, 39600);
  EXPECT_GT(hit, 15000);
}

TEST(Rays, NoneLeavesAClosedMesh) {
  Mesh box = test::empty_mesh();
  test::add_box(box, {100, 200, 300}, {3, 2, 1}, 7);
  for (const Mesh& mesh : {test::sphere({10, 20, 30}, 2.0, 40), box}) {
    const Rays rays(test::facets(mesh));
    ASSERT_TRUE(rays.facets().shells[0].closed);
    const Point middle = rays.facets().middle;
    test::Uniform random(2);
    std::vector<Ray> list;
    for (int i = 0; i < 500000; ++i)
      list.push_back({middle + (0.4 * random()) * random.direction(), random.direction()});
    std::vector<Hit> found(list.size());
    rays.first_hits(list, found);
    const auto leaks = std::count_if(found.begin(), found.end(), [](const Hit& h) { return !hits(h) || !h.back; });
    EXPECT_EQ(leaks, 0);
  }
}

TEST(Rays, HitsDoNotDependOnThreads) {
  const Rays rays(cluttered());
  test::Uniform random(3);
  std::vector<Ray> list;
  for (int i = 0; i < 30001; ++i)
    list.push_back({{8 * random() - 4, 8 * random() - 4, 4 * random()}, random.direction()});
  std::vector<Hit> one(list.size()), two(list.size());
  rays.first_hits(list, one, 1);
  rays.first_hits(list, two, 2);
  for (std::size_t i = 0; i < list.size(); ++i) {
    ASSERT_EQ(one[i].facet, two[i].facet);
    ASSERT_EQ(one[i].distance_m, two[i].distance_m);
  }
}

TEST(Rays, ThoseThatEndTheProcessInEmbreeAreRefused) {
  const Rays rays(cluttered());
  const Point origin{0, 0, 5};
  const Vector down{0, 0, -1};
  for (const double bad : {kNaN, kInf, -kInf}) {
    expect_refused({"ray 0", "not finite"}, [&] { (void)rays.first_hit({{bad, 0, 0}, down}); });
    expect_refused({"ray 0", "not finite"}, [&] { (void)rays.first_hit({origin, {0, bad, -1}}); });
  }
  expect_refused({"1e12 m"}, [&] { (void)rays.first_hit({{0, 2e18, 0}, down}); });
  expect_refused({"direction"}, [&] { (void)rays.first_hit({origin, {0, 0, 0}}); });
  expect_refused({"direction"}, [&] { (void)rays.first_hit({origin, {0, 1e300, 0}}); });
  std::vector<Ray> list(40, {origin, down});
  std::vector<Hit> found(list.size());
  list[37].direction[2] = kNaN;
  expect_refused({"ray 37"}, [&] { rays.first_hits(list, found); });
  expect_refused({"space for 39"}, [&] { rays.first_hits(list, std::span(found).first(39)); });
  // Those just within the limits are traced: long and short directions, and a start far away.
  EXPECT_TRUE(hits(rays.first_hit({origin, {0, 0, -1e149}})));
  EXPECT_TRUE(hits(rays.first_hit({origin, {0, 0, -1e-149}})));
  EXPECT_FALSE(hits(rays.first_hit({{9e11, 9e11, 9e11}, {0, 0, 1}})));
  EXPECT_TRUE(hits(rays.first_hit({{0.1, 0.1, 9e11}, down})));
}

TEST(OppositeFacets, WallsOfAClosedBoxArePaired) {
  Mesh mesh = test::empty_mesh();
  test::add_box(mesh, {0, 0, 0}, {2, 1, 0.02});
  test::add_plate(mesh, {0, 0, 5}, {1, 0, 0}, {0, 1, 0});
  const Rays rays(test::facets(mesh));
  std::vector<std::uint32_t> all(rays.facets().size());
  for (std::uint32_t f = 0; f < all.size(); ++f) all[f] = f;
  const OppositeFacets found = opposite_facets(rays, all, 0.05);
  EXPECT_EQ(found.unpaired, 5U);  // the narrow sides and the open plate
  EXPECT_EQ(found.opposite[0], 1U);
  EXPECT_EQ(found.opposite[1], 0U);
  EXPECT_NEAR(found.distance_m[0], 0.02, 1e-9);
  EXPECT_EQ(opposite_facets(rays, all, 0.01).unpaired, 7U);
  expect_refused({"thickness"}, [&] { (void)opposite_facets(rays, all, kNaN); });
}

}  // namespace
}  // namespace radiometry::scene
