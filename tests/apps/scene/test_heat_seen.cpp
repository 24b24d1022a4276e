// SPDX-License-Identifier: Apache-2.0

// Runs for what the camera sees: which facets that are, and that their temperatures are those of a run for all.

#include <cstring>
#include <numbers>
#include <sstream>

#include "radiometry/thermal/heat_scene.h"
#include "tests/apps/scene/heat_run_case.h"
#include "tests/expect_error.h"

namespace apps::scene {
namespace {

using namespace test;

const std::string kSunny = kDay + weather(290.0, 2.0, 700.0, 80.0, 320.0) + kSky +
                           material("paint", 0.7, 0.9, "\"mcadams\"") + kMesh + region("", "material = \"paint\"");

std::string camera(const std::string& position) {
  return "[camera]\nposition = [" + position + "]\nlook_at = [\"5 m\", \"5 m\", \"0 m\"]\n";
}

/// A cube of 1 m: bottom, top, front (-y), right (+x), rear, left.
const std::string kCube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// n x n squares of 10 / n m in triangles around a trench 2 m deep along x, with small bumps.
std::string trench(int n) {
  std::ostringstream obj;
  const double step_m = 10.0 / n;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = step_m * i, y = step_m * j;
      const double deep = 1.0 / (1.0 + std::exp(-6.0 * (y - 3.5))) - 1.0 / (1.0 + std::exp(-6.0 * (y - 6.5)));
      obj << "v " << x << " " << y << " " << -2.0 * deep + 0.02 * std::sin(7.0 * x) * std::cos(5.0 * y) << "\n";
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i + 1, c = a + n + 1;
      obj << "f " << a << " " << a + 1 << " " << c + 1 << "\nf " << a << " " << c + 1 << " " << c << "\n";
    }
  return obj.str();
}

using HeatSeen = HeatRun;

std::vector<bool> seen_from(const HeatScene& scene, const radiometry::scene::Point& from) {
  return seen_facets(scene, from, 2);
}

TEST_F(HeatSeen, ACameraSeesTheThreeSidesOfACubeThatFaceIt) {
  const HeatScene scene = prepare(kSunny, kCube);
  const std::vector<bool> corner{false, true, true, true, false, false}, inside(6, true);
  EXPECT_EQ(seen_from(scene, {4.0, -3.0, 2.0}), corner);
  EXPECT_EQ(seen_from(scene, {0.5, 0.5, 5.0}), (std::vector<bool>{false, true, false, false, false, false}));
  EXPECT_EQ(seen_from(scene, {0.5, 0.5, 0.5}), inside);
}

TEST_F(HeatSeen, APlateInTheShadowOfAnotherIsNotSeenButForItsRim) {
  const HeatScene scene = prepare(kSunny, plate(0.0, 1, "a") + plate(1.0, 5, "b"));
  EXPECT_EQ(seen_from(scene, {0.5, 0.5, 3.0}), (std::vector<bool>{false, true}));
  EXPECT_EQ(seen_from(scene, {0.5, 0.5, 200.0}), (std::vector<bool>{false, true}));
  EXPECT_EQ(seen_from(scene, {0.9, 0.5, 30.0}), (std::vector<bool>{false, true}));
  EXPECT_EQ(seen_from(scene, {3.0, 0.5, 3.0}), (std::vector<bool>{true, true}));
}

// Of 10^5 lines in random directions none may meet a facet that counts as not seen.
TEST_F(HeatSeen, NoLineFromTheCameraMeetsAFacetThatIsNotSeen) {
  const HeatScene scene = prepare(kSunny, trench(30));
  for (const radiometry::scene::Point from : {radiometry::scene::Point{5.0, -8.0, 1.5}, {3.0, 5.0, -1.0}}) {
    const std::vector<bool> seen = seen_from(scene, from);
    std::vector<radiometry::scene::Ray> rays;
    for (int i = 0; i < 100000; ++i) {  // a spiral of equal areas
      const double z = 1.0 - (2.0 * i + 1.0) / 100000.0, turn = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
      const double r = std::sqrt(1.0 - z * z);
      rays.push_back({from, {r * std::cos(turn), r * std::sin(turn), z}});
    }
    std::vector<radiometry::scene::Hit> met(rays.size());
    scene.rays.first_hits(rays, met);
    std::size_t hit = 0;
    for (const radiometry::scene::Hit& one : met) {
      if (!radiometry::scene::hits(one)) continue;
      ++hit;
      EXPECT_TRUE(seen[one.facet]) << one.facet;
    }
    EXPECT_GT(hit, 500U);
    EXPECT_LT(std::ranges::count(seen, true), static_cast<std::ptrdiff_t>(seen.size() * 9 / 10));
  }
}

struct Compared {
  double worst_k = 0.0, rms_k = 0.0;
  std::size_t seen = 0;
};

/// Of facets that have a temperature in the first.
Compared compared(const Outcome& some, const Outcome& all) {
  Compared c;
  for (std::size_t i = 0; i < some.front.size(); ++i)
    for (std::size_t f = 0; f < some.front[i].size(); ++f) {
      if (std::isnan(some.front[i][f])) continue;
      const double error = std::abs(some.front[i][f] - all.front[i][f]);
      c.worst_k = std::max(c.worst_k, error);
      c.rms_k += error * error;
      ++c.seen;
    }
  c.rms_k = std::sqrt(c.rms_k / static_cast<double>(c.seen));
  c.seen /= some.front.size();
  return c;
}

// The near wall of the trench is hidden and warms the far one, which is seen. Both runs have the same views of what is
// seen; the surfaces that it sees are divided into other patches, 60 of them, whose means are a tenth of a kelvin
// apart.
TEST_F(HeatSeen, WhatIsSeenIsAsWarmAsInARunForAll) {
  const std::string text = kSunny + camera("\"5 m\", \"-8 m\", \"1.5 m\""), obj = trench(40);
  const HeatOptions options{.tolerance_k = 0.1, .patches = 60};
  HeatOptions of_seen = options;
  of_seen.seen = true;
  const Outcome all = run(text, obj, options), some = run(text, obj, of_seen);
  ASSERT_TRUE(some.report.left_out);
  EXPECT_FALSE(all.report.left_out);
  const Compared c = compared(some, all);
  EXPECT_EQ(c.seen, some.report.facets - some.report.left_out->facets);
  EXPECT_GT(some.report.left_out->units, 200U);
  EXPECT_LE(some.report.promised.total_k(), 0.1);
  EXPECT_LT(c.rms_k, 0.03);
  EXPECT_LT(c.worst_k, 0.6);
}

// With the same patches and all units solved, what is left out is all that the promise does not have.
TEST_F(HeatSeen, VerificationFindsWhatIsLeftOut) {
  const Outcome some = run(kSunny + camera("\"5 m\", \"-8 m\", \"1.5 m\""), trench(40),
                           {.tolerance_k = 0.1, .patches = 60, .seen = true, .verify = true});
  ASSERT_TRUE(some.report.verified && some.report.left_out);
  const LeftOut& out = *some.report.left_out;
  const RealisedError &same = some.report.verified->as_units, &single = some.report.verified->by_itself;
  EXPECT_EQ(same.count, some.report.facets - out.facets);
  EXPECT_GT(same.largest_k, 0.0);
  EXPECT_GT(out.largest_k, 0.0);
  EXPECT_LE(same.largest_k, some.report.promised.total_k() + 4.0 * out.largest_k);
  EXPECT_LT(single.rms_k, 0.05);
}

/// Squares of 0.5 m, and a block that stands in them: it covers 64, of which the outer ones share corners with squares
/// that are seen.
std::string block_on_squares() {
  constexpr int n = 20;
  std::ostringstream obj;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) obj << "v " << 0.5 * i << " " << 0.5 * j << " 0\n";
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i + 1, c = a + n + 1;
      obj << "f " << a << " " << a + 1 << " " << c + 1 << " " << c << "\n";
    }
  for (const double z : {-0.5, 1.5})
    obj << "v 3 3 " << z << "\nv 7 3 " << z << "\nv 7 7 " << z << "\nv 3 7 " << z << "\n";
  obj << "f -8 -5 -6 -7\nf -4 -3 -2 -1\nf -8 -7 -3 -4\nf -7 -6 -2 -3\nf -6 -5 -1 -2\nf -5 -8 -4 -1\n";
  return obj.str();
}

// Covered facets that are seen have a patch of their own; solved with all others they are one unit with those that are
// not.
TEST_F(HeatSeen, VerificationOfCoveredFacetsThatAreSeenByACorner) {
  const Outcome some = run(kSunny + camera("\"5 m\", \"-8 m\", \"4 m\""), block_on_squares(),
                           {.tolerance_k = 0.3, .patches = 30, .seen = true, .verify = true});
  EXPECT_GT(some.report.covered.size(), 10U);  // of the 28 outer ones, those that touch a facet that is seen
  EXPECT_LE(some.report.covered.size(), 28U);
  ASSERT_TRUE(some.report.verified);
  EXPECT_LT(some.report.verified->by_itself.rms_k, 0.3);  // of which shadows of four points a facet are most
}

TEST_F(HeatSeen, TheSameForEveryNumberOfThreads) {
  const std::string text = kSunny + camera("\"5 m\", \"-8 m\", \"1.5 m\"");
  const Outcome one = run(text, trench(12), {.seen = true, .threads = 1});
  const Outcome two = run(text, trench(12), {.seen = true, .threads = 2});
  ASSERT_EQ(one.front.size(), two.front.size());
  for (std::size_t i = 0; i < one.front.size(); ++i)
    EXPECT_EQ(std::memcmp(one.front[i].data(), two.front[i].data(), one.front[i].size() * sizeof(double)), 0) << i;
}

TEST_F(HeatSeen, AsksForACameraThatSeesSomething) {
  expect_refused<mtf::Error>({"there is no [camera]"}, [&] { prepare(kSunny, plate(0.0), {.seen = true}); });
}

}  // namespace
}  // namespace apps::scene
