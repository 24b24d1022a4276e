// SPDX-License-Identifier: Apache-2.0

// Random meshes with every kind of damage: a refusal, or facets that all later steps can use. Embree's assertions would
// end the process.

#include <gtest/gtest.h>

#include <limits>

#include "mtf/error.h"
#include "radiometry/scene/rays.h"
#include "radiometry/scene/sun_visibility.h"
#include "radiometry/scene/views.h"
#include "tests/radiometry/scene/scene_cases.h"

namespace radiometry::scene {
namespace {

/// Coordinates around `scale`, some of them equal, huge, tiny or no numbers; some corners name no vertex.
Mesh damaged(test::Uniform& random, double scale) {
  constexpr std::array<double, 10> kOdd{0.0,    -0.0,   std::numeric_limits<double>::quiet_NaN(),
                                        1e300,  -1e300, std::numeric_limits<double>::infinity(),
                                        1e-300, 5e-324, 1e19,
                                        -1e8};
  const double oddness = random() < 0.5 ? 0.0 : 0.03 * random();
  Mesh mesh = test::empty_mesh();
  const auto vertices = static_cast<std::size_t>(3 + 40 * random());
  for (std::size_t v = 0; v < vertices; ++v) {
    Point p;
    for (double& x : p) {
      x = scale * (random() < 0.5 ? std::floor(4 * random()) : random());
      if (random() < oddness) x = kOdd[static_cast<std::size_t>(10 * random())];
    }
    mesh.vertices.push_back(p);
  }
  const auto faces = static_cast<std::size_t>(60 * random());
  for (std::size_t f = 0; f < faces; ++f) {
    const auto corners = static_cast<std::size_t>(7 * random());
    for (std::size_t c = 0; c < corners; ++c)
      mesh.corners.push_back(static_cast<std::uint32_t>((static_cast<double>(vertices) + oddness) * random()));
    if (random() < oddness && corners > 0) mesh.corners.back() = 0xFFFFFFFFU;
    mesh.first.push_back(mesh.corners.size());
    mesh.group.push_back(0);
    mesh.material.push_back(0);
  }
  return mesh;
}

TEST(DamagedMeshes, AreRefusedOrUsable) {
  test::Uniform random(17);
  int used = 0, refused = 0;
  for (int i = 0; i < 1500; ++i) {
    const double scale = std::pow(10.0, 14 * random() - 7);
    const Mesh mesh = damaged(random, scale);
    try {
      const Rays rays(test::facets(mesh, i % 2 == 0 ? Winding::outward : Winding::as_given));
      const Facets& facets = rays.facets();
      for (const Facet& facet : facets.facet) {
        ASSERT_GT(facet.area_m2, 0.0);
        ASSERT_NEAR(length(facet.normal), 1.0, 1e-9);
        ASSERT_TRUE(finite(facet.centre));
      }
      std::vector<Side> sides;
      std::vector<std::uint32_t> fronts;
      for (std::uint32_t f = 0; f < facets.size(); ++f) sides.push_back({f, f % 2 == 0}), fronts.push_back(f);
      const Views seen = views(rays, single_sides(sides), {.rays = 8, .threads = 1});
      for (std::size_t k = 0; k < seen.size(); ++k)
        ASSERT_NEAR(seen.sky_share(k) + seen.ground[k] + seen.surfaces[k], 1.0, 1e-12);
      const std::vector<Vector> to_sun{{0, 0, 1}, {1, 1, 0.1}};
      ASSERT_EQ(sun_visibility(rays, sides, to_sun, {.threads = 1}).sides(), sides.size());
      ASSERT_EQ(opposite_facets(rays, fronts, scale, 1).opposite.size(), fronts.size());
      ++used;
    } catch (const mtf::UsageError&) {
      ++refused;
    }
  }
  EXPECT_GT(used, 500);
  EXPECT_GT(refused, 50);
}

}  // namespace
}  // namespace radiometry::scene
