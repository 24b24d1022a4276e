// SPDX-License-Identifier: Apache-2.0

// Shadows at the place that geometry gives, and what needs no ray.

#include "radiometry/scene/sun_visibility.h"

#include <gtest/gtest.h>

#include <limits>

#include "radiometry/scene/table_error.h"
#include "tests/radiometry/expect_refused.h"
#include "tests/radiometry/scene/scene_cases.h"

namespace radiometry::scene {
namespace {

using radiometry::test::expect_refused;

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

TEST(SunVisibility, StatedError) {
  const Rays rays(test::facets(plate_over_ground()));
  const std::vector<Side> sides = fronts(rays.facets());
  std::vector<Vector> coarse, fine;
  for (int h = 2; h < 11; ++h) coarse.push_back({std::cos(h * 0.26), -0.3, std::sin(h * 0.26)});
  for (int h = 20; h < 110; ++h) fine.push_back({std::cos(h * 0.026), -0.3, std::sin(h * 0.026)});
  const auto error = [&](const std::vector<Vector>& to_sun, int points) {
    const SunOptions options{.points = points};
    return sun_error(rays, sides, to_sun, sun_visibility(rays, sides, to_sun, options), options);
  };
  // More directions and more points each lower it.
  EXPECT_EQ(error(fine, 4).count, 401U);
  EXPECT_LT(error(fine, 16).rms, 0.75 * error(fine, 1).rms);
  EXPECT_LT(error(fine, 16).rms, 0.75 * error(coarse, 16).rms);
  EXPECT_LE(error(fine, 16).percentile_95, error(coarse, 16).percentile_95);
  const std::vector<Side> top{{400, false}};
  const SunVisibility open = sun_visibility(rays, top, fine);
  EXPECT_EQ(sun_error(rays, top, fine, open, {}).rms, 0.0);
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
