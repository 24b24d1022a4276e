// SPDX-License-Identifier: Apache-2.0

// Shadows at the place that geometry gives, and what needs no ray.

#include "radiometry/scene/sun_visibility.h"

#include <gtest/gtest.h>

#include <limits>

#include "radiometry/scene/table_error.h"
#include "tests/expect_error.h"
#include "tests/radiometry/scene/scene_cases.h"

namespace radiometry::scene {
namespace {

/// A plate of 1 m x 1 m, 0.5 m above a ground of 20 x 20 squares of 0.2 m.
Mesh plate_over_ground() {
  Mesh mesh = test::empty_mesh();
  test::add_plate(mesh, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, 20, 20);
  test::add_plate(mesh, {-0.5, -0.5, 0.5}, {1, 0, 0}, {0, 1, 0});
  return mesh;
}

std::vector<Side> fronts(const Facets& facets) { return single_sides(facets).sides; }

double overlap(double a, double b, double c, double d) { return std::max(0.0, std::min(b, d) - std::max(a, c)); }

TEST(SunVisibility, ShadowOfAPlateIsAtItsPlace) {
  const Rays rays(test::facets(plate_over_ground()));
  const std::vector<Side> sides = fronts(rays.facets());
  const std::vector<Vector> to_sun{{0.5, 0.2, 1.0}, {-1.0, 0.7, 2.0}, {0, 0, 3}};
  const SunVisibility sun = sun_visibility(rays, sides, to_sun, {.points = 200});
  int partly = 0;
  double squares = 0.0;
  for (std::size_t d = 0; d < to_sun.size(); ++d) {
    const double x = -0.5 * to_sun[d][0] / to_sun[d][2],
                 y = -0.5 * to_sun[d][1] / to_sun[d][2];  // of the shadow's middle
    for (std::size_t i = 0; i < 400; ++i) {
      const Point& c = rays.facets().facet[i].centre;
      const double dark =
          overlap(c[0] - 0.1, c[0] + 0.1, x - 0.5, x + 0.5) * overlap(c[1] - 0.1, c[1] + 0.1, y - 0.5, y + 0.5) / 0.04;
      if (dark < 1e-9 || dark > 1 - 1e-9) {
        EXPECT_EQ(sun.share(i, d), dark < 0.5 ? 1.0 : 0.0) << i;
      } else {
        EXPECT_NEAR(sun.share(i, d), 1.0 - dark, 0.04) << i;
        squares += (sun.share(i, d) - 1.0 + dark) * (sun.share(i, d) - 1.0 + dark);
        ++partly;
      }
    }
    EXPECT_EQ(sun.share(400, d), 1.0);
  }
  EXPECT_GT(partly, 40);
  EXPECT_LT(std::sqrt(squares / partly), 0.012);
}

TEST(SunVisibility, SidesTurnedAwayAndASunThatIsDownGiveNothing) {
  const Rays rays(test::facets(plate_over_ground()));
  const std::vector<Side> sides{{400, false}, {400, true}};
  const std::vector<Vector> to_sun{{0, 0, 1}, {1, 0, 0}, {1, 0, -0.1}, {1, 0, 0.01}};
  const SunVisibility sun = sun_visibility(rays, sides, to_sun);
  EXPECT_EQ(sun.lit, (std::vector<std::uint8_t>{4, 0, 0, 4, 0, 0, 0, 0}));
}

TEST(SunVisibility, DoesNotDependOnThreadsAndInteriorsAreDark) {
  Mesh mesh = plate_over_ground();
  test::add_box(mesh, {-1, -1, 0.8}, {0.9, 0.8, 0.7}, 5);
  const Rays rays(test::facets(mesh));
  std::vector<Side> sides;
  for (std::uint32_t f = 0; f < rays.facets().size(); ++f) sides.push_back({f, false}), sides.push_back({f, true});
  std::vector<Vector> to_sun;
  for (int h = 1; h < 12; ++h) to_sun.push_back({std::cos(h * 0.26), -0.3, std::sin(h * 0.26)});
  const SunVisibility one = sun_visibility(rays, sides, to_sun, {.points = 7, .threads = 1});
  EXPECT_EQ(one.lit, sun_visibility(rays, sides, to_sun, {.points = 7, .threads = 2}).lit);
  EXPECT_NE(one.lit, sun_visibility(rays, sides, to_sun, {.points = 7, .seed = 1}).lit);
  for (std::size_t i = 0; i < sides.size(); ++i)
    for (std::size_t d = 0; sides[i].facet > 400 && sides[i].back && d < to_sun.size(); ++d)
      EXPECT_EQ(one.share(i, d), 0.0);
}

/// Halfway between the directions, and at them.
std::vector<SunCheck> checks_of(const std::vector<Vector>& to_sun) {
  std::vector<SunCheck> checks;
  for (std::size_t d = 0; d + 1 < to_sun.size(); ++d) {
    checks.push_back({unit(to_sun[d]), d, 0.0});
    checks.push_back({unit(unit(to_sun[d]) + unit(to_sun[d + 1])), d, 0.5});
  }
  return checks;
}

// A wall at the edge of the plane that the sun rises from: what the sun does to the wall is its cosine, and no shadow.
TEST(SunVisibility, ASideIsNoShadowOfItself) {
  Mesh mesh = test::empty_mesh();
  test::add_plate(mesh, {0, 0, 0}, {0, 1, 0}, {0, 0, 1});   // faces east, nothing before it
  test::add_plate(mesh, {10, 0, 0}, {0, 1, 0}, {0, 0, 1});  // the same, behind a wall that stands across its plane
  test::add_plate(mesh, {9, 2, 0}, {2, 0, 0}, {0, 0, 5});
  const Rays rays(test::facets(mesh));
  std::vector<Vector> to_sun;
  for (int h = 0; h <= 12; ++h) {
    const double azimuth = (124.0 - 10.0 * h) * 3.14159265358979 / 180.0;  // 90: north; the plane of the walls
    to_sun.push_back({std::cos(azimuth), std::sin(azimuth), 0.3});
  }
  const SunVisibility sun = sun_visibility(rays, std::vector<Side>{{0}, {1}}, to_sun);
  const double normal = rays.facets().facet[0].normal[0];
  ASSERT_NEAR(std::abs(normal), 1.0, 1e-12);
  ASSERT_LT(normal * to_sun[3][0], 0.0);  // 4 degrees behind the side, the next 6 before it
  for (std::size_t d = 0; d < to_sun.size(); ++d) EXPECT_EQ(sun.share(0, d), d < 3 ? 0.0 : 1.0) << d;
  EXPECT_LT(sun.share(1, 4), 1.0);
  EXPECT_EQ(sun.share(1, 3), sun.share(1, 4));
}

// A roof whose plane the sun just reaches at noon: in no direction of the list is it before the roof.
TEST(SunVisibility, ASunThatTouchesThePlaneIsNotShaded) {
  const double roof = 0.7, sun_height = roof - 0.0005;  // rad
  Mesh mesh = test::empty_mesh();
  test::add_plate(mesh, {0, 0, 0}, {1, 0, 0}, {0, -std::cos(roof), std::sin(roof)});
  const Rays rays(test::facets(mesh));
  std::vector<Vector> to_sun;
  for (const double east : {-0.06, 0.06}) {
    const double rest = std::sqrt(1.0 - east * east);
    to_sun.push_back({east, -rest * std::cos(sun_height), rest * std::sin(sun_height)});
  }
  const Side upper{0, rays.facets().facet[0].normal[2] < 0.0};
  const double behind = (upper.back ? -1.0 : 1.0) * dot(rays.facets().facet[0].normal, to_sun[0]);
  ASSERT_NEAR(behind, -0.0005, 1e-5);
  const SunVisibility sun = sun_visibility(rays, std::vector<Side>{upper}, to_sun);
  EXPECT_EQ(sun.lit, (std::vector<std::uint8_t>{4, 4}));
}

TEST(SunVisibility, StatedError) {
  const Rays rays(test::facets(plate_over_ground()));
  const std::vector<Side> sides = fronts(rays.facets());
  std::vector<Vector> coarse, fine;
  for (int h = 2; h < 11; ++h) coarse.push_back({std::cos(h * 0.26), -0.3, std::sin(h * 0.26)});
  for (int h = 20; h < 110; ++h) fine.push_back({std::cos(h * 0.026), -0.3, std::sin(h * 0.026)});
  const auto error = [&](const std::vector<Vector>& to_sun, int points) {
    const SunOptions options{.points = points};
    return sun_error(rays, sides, checks_of(to_sun), sun_visibility(rays, sides, to_sun, options), options)
        .of_directions;
  };
  // More directions and more points each lower it.
  EXPECT_EQ(error(fine, 4).count, 401U);
  EXPECT_LT(error(fine, 16).rms, 0.75 * error(fine, 1).rms);
  EXPECT_LT(error(fine, 16).rms, 0.75 * error(coarse, 16).rms);
  EXPECT_LE(error(fine, 16).percentile_95, error(coarse, 16).percentile_95);
  const std::vector<Side> top{{400, false}};
  const SunVisibility open = sun_visibility(rays, top, fine);
  EXPECT_EQ(sun_error(rays, top, checks_of(fine), open, {}).of_sides.rms, 0.0);
}

TEST(SunVisibility, Refusals) {
  const Rays rays(test::facets(plate_over_ground()));
  const std::vector<Side> sides{{0}};
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e200})
    expect_refused({"direction 1"}, [&] {
      (void)sun_visibility(rays, sides, std::vector<Vector>{{0, 0, 1}, {bad, 0, 1}});
    });
  expect_refused({"direction 0"}, [&] { (void)sun_visibility(rays, sides, std::vector<Vector>{{0, 0, 0}}); });
  expect_refused({"points"}, [&] { (void)sun_visibility(rays, sides, {}, {.points = 256}); });
  expect_refused({"no facet 401"}, [&] {
    (void)sun_visibility(rays, std::vector<Side>{{401}}, std::vector<Vector>{{0, 0, 1}});
  });
  EXPECT_EQ(sun_visibility(rays, sides, {}).sides(), 0U);
}

}  // namespace
}  // namespace radiometry::scene
