// SPDX-License-Identifier: Apache-2.0

// Classes keep the bound that they are made with, computed here again from the tables.

#include "radiometry/scene/classes.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/expect_error.h"
#include "tests/radiometry/scene/scene_cases.h"

namespace radiometry::scene {
namespace {

struct Case {
  Facets facets;
  std::vector<Side> sides;
  std::vector<SideFinish> finish;
  std::vector<Vector> to_sun;
  Views seen;
  SunVisibility sun;
  FluxAmplitudes amplitudes;
};

Case made_case() {
  Mesh mesh = test::sphere({0, 0, 1.2}, 1.0, 24);
  test::add_plate(mesh, {-3, -3, 0}, {6, 0, 0}, {0, 6, 0}, 30, 30);
  test::add_box(mesh, {1.2, 0, 0.1}, {1, 1, 1}, 12);
  const Rays rays(test::facets(mesh));
  Case c{.facets = rays.facets(),
         .sides = single_sides(rays.facets()).sides,
         .finish = {},
         .to_sun = {},
         .seen = {},
         .sun = {},
         .amplitudes = {}};
  for (int h = 1; h < 18; ++h) c.to_sun.push_back({std::cos(h * 0.174), -0.5, 0.8 * std::sin(h * 0.174)});
  c.seen = views(rays, single_sides(rays.facets()), {.rays = 256});
  c.sun = sun_visibility(rays, c.sides, c.to_sun);
  for (std::size_t i = 0; i < c.sides.size(); ++i)
    c.finish.push_back(
        {.key = c.facets.facet[i].centre[2] < 1e-9 ? 0U : 1U, .solar_absorptance = 0.7, .emissivity = 0.9});
  c.amplitudes = {.direct = std::vector<double>(c.to_sun.size(), 850.0),
                  .sky_solar = std::vector<double>(9, 120.0),
                  .sky_longwave = {220, 222, 224, 228, 234, 243, 256, 276, 310},
                  .ground_solar = 200,
                  .ground_longwave = 400,
                  .surfaces_solar = 100,
                  .surfaces_longwave = 420};
  return c;
}

Classes classes(const Case& c, double tolerance) {
  return classes_of(c.facets, c.sides, c.finish, c.seen, c.sun, c.to_sun, c.amplitudes, tolerance);
}

/// The bound of the header, in double precision.
double bound(const Case& c, std::size_t i, std::size_t j) {
  const auto direct = [&](std::size_t k, std::size_t d) {
    const Vector& v = c.to_sun[d];
    return c.finish[k].solar_absorptance * c.amplitudes.direct[d] *
           std::max(0.0, dot(c.facets.facet[k].normal, v) / length(v)) * c.sun.share(k, d);
  };
  const auto seen = [&](std::size_t k, const std::vector<double>& sky, double ground, double surfaces) {
    double sum = ground * c.seen.ground[k] + surfaces * c.seen.surfaces[k];
    for (std::size_t r = 0; r < 9; ++r) sum += sky[r] * c.seen.sky[9 * k + r];
    return sum;
  };
  double worst = 0.0;
  for (std::size_t d = 0; d < c.to_sun.size(); ++d) worst = std::max(worst, std::abs(direct(i, d) - direct(j, d)));
  const FluxAmplitudes& a = c.amplitudes;
  const auto solar = [&](std::size_t k) {
    return c.finish[k].solar_absorptance * seen(k, a.sky_solar, a.ground_solar, a.surfaces_solar);
  };
  const auto longwave = [&](std::size_t k) {
    return c.finish[k].emissivity * seen(k, a.sky_longwave, a.ground_longwave, a.surfaces_longwave);
  };
  return worst + std::abs(solar(i) - solar(j)) + std::abs(longwave(i) - longwave(j));
}

TEST(Classes, KeepTheirBound) {
  const Case c = made_case();
  std::size_t before = c.sides.size() + 1;
  for (const double tolerance : {0.0, 1.0, 5.0, 30.0, 200.0}) {
    const Classes made = classes(c, tolerance);
    ASSERT_EQ(made.class_of.size(), c.sides.size());
    EXPECT_LT(made.size(), before) << tolerance;
    before = made.size();
    double worst = 0.0;
    for (std::size_t i = 0; i < c.sides.size(); ++i) {
      const std::size_t leader = made.leader[made.class_of[i]];
      EXPECT_EQ(c.finish[i].key, c.finish[leader].key);
      worst = std::max(worst, bound(c, i, leader));
    }
    EXPECT_LE(worst, tolerance + 1e-3);
    EXPECT_NEAR(worst, made.bound_w_m2, 1e-3);
    if (tolerance == 0.0) {
      EXPECT_EQ(made.size(), c.sides.size());
    }
  }
  EXPECT_LT(before, c.sides.size() / 10);
}

TEST(Classes, NoLeaderIsWithinTheToleranceOfAnother) {
  // Otherwise the grid would have missed one: the second would have joined the first.
  const Case c = made_case();
  const Classes made = classes(c, 30.0);
  for (std::size_t a = 0; a < made.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      if (c.finish[made.leader[a]].key != c.finish[made.leader[b]].key) continue;
      EXPECT_GT(bound(c, made.leader[a], made.leader[b]), 30.0 - 1e-3);
    }
}

TEST(Classes, DifferentFinishesAreNotMerged) {
  Case c = made_case();
  const std::size_t same = classes(c, 1e6).size();
  EXPECT_EQ(same, 2U);
  c.finish[5].emissivity = 0.5;
  c.finish[6].solar_absorptance = 0.2;
  EXPECT_EQ(classes(c, 1e6).size(), 4U);
}

TEST(Patches, AreAsManyAsAllowedAndOfNearlyEqualMeanFlux) {
  const Case c = made_case();
  double wider = 0.0;
  for (const std::size_t most : {500U, 100U, 20U}) {
    const Classes made = patches_of(c.facets, c.sides, c.finish, c.seen, c.sun, c.to_sun, c.amplitudes, most);
    EXPECT_LE(made.size(), most);
    EXPECT_GT(made.size(), most / 2);
    EXPECT_GT(made.bound_w_m2, wider);
    wider = made.bound_w_m2;
    const auto mean_direct = [&](std::size_t i) {
      double sum = 0.0;
      for (std::size_t d = 0; d < c.to_sun.size(); ++d)
        sum += 0.7 * 850.0 * std::max(0.0, dot(c.facets.facet[i].normal, c.to_sun[d]) / length(c.to_sun[d])) *
               c.sun.share(i, d);
      return sum / static_cast<double>(c.to_sun.size());
    };
    for (std::size_t i = 0; i < c.sides.size(); ++i) {
      const std::size_t leader = made.leader[made.class_of[i]];
      EXPECT_EQ(c.finish[i].key, c.finish[leader].key);
      EXPECT_LT(std::abs(mean_direct(i) - mean_direct(leader)), made.bound_w_m2 + 1e-3);
    }
  }
  expect_refused({"1 different finishes"},
                 [&] { (void)patches_of(c.facets, c.sides, c.finish, c.seen, c.sun, c.to_sun, c.amplitudes, 1); });
}

TEST(Classes, Refusals) {
  Case c = made_case();
  expect_refused({"tolerance"}, [&] { (void)classes(c, std::numeric_limits<double>::quiet_NaN()); });
  expect_refused({"tolerance"}, [&] { (void)classes(c, -1.0); });
  c.amplitudes.ground_solar = std::numeric_limits<double>::quiet_NaN();
  expect_refused({"amplitude"}, [&] { (void)classes(c, 1.0); });
  c.amplitudes.ground_solar = 0.0;
  c.finish[3].emissivity = 2.0;
  expect_refused({"emissivity 2"}, [&] { (void)classes(c, 1.0); });
  c.amplitudes.sky_solar.pop_back();
  expect_refused({"solar amplitudes is 8", "should be 9"}, [&] { (void)classes(c, 1.0); });
  c.finish.pop_back();
  expect_refused({"finishes"}, [&] { (void)classes(c, 1.0); });
}

}  // namespace
}  // namespace radiometry::scene
