// SPDX-License-Identifier: Apache-2.0
// What a camera sees: where it looks, what is there against a search through all triangles in double precision, and
// that nothing shows through a closed surface.

#include "radiometry/render/visibility/screen.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "render_cases.h"

namespace radiometry::render::test {
namespace {

using scene::operator-, scene::operator+, scene::operator*;
using scene::dot, scene::cross;

TEST(Camera, SeesAlongItsAxisAndToTheSides) {
  const Camera eye =
      camera_of({.focal_length_mm = 50.0, .pitch_x_um = 20.0, .pitch_y_um = 10.0, .columns = 64, .rows = 32},
                {.position = {1, 2, 3}, .look_at = {1, 12, 3}});
  EXPECT_EQ(eye.width, 128);
  EXPECT_EQ(eye.height, 64);
  const Vector middle = eye.direction(64.0, 32.0), right = eye.direction(65.0, 32.0), down = eye.direction(64.0, 33.0);
  EXPECT_NEAR(scene::length(middle - Vector{0, 1, 0}), 0.0, 1e-15);
  EXPECT_NEAR(scene::length(right - Vector{2e-4, 1, 0}), 0.0, 1e-15);  // looking north, east is to the right
  EXPECT_NEAR(scene::length(down - Vector{0, 1, -1e-4}), 0.0, 1e-15);
}

TEST(Camera, LooksStraightDownWithNorthUp) {
  const Lens lens{.focal_length_mm = 50.0, .pitch_x_um = 20.0, .pitch_y_um = 20.0, .columns = 64, .rows = 32};
  const Camera eye = camera_of(lens, {.position = {1, 1, 100}, .look_at = {1, 1, 0}});
  EXPECT_EQ(eye.right, (Vector{1, 0, 0}));
  EXPECT_EQ(eye.down, (Vector{0, -1, 0}));
}

TEST(Camera, RefusesViewsThatAreNone) {
  const Lens lens{.focal_length_mm = 50.0, .pitch_x_um = 20.0, .pitch_y_um = 20.0, .columns = 64, .rows = 32};
  EXPECT_THROW(camera_of(lens, {.position = {1, 1, 1}, .look_at = {1, 1, 1}}), mtf::UsageError);
  EXPECT_THROW(camera_of(lens, {.position = {1, 1, 1}, .look_at = {1, 2, 1}, .up = {0, 1, 0}}), mtf::UsageError);
  EXPECT_THROW(camera_of(lens, {.position = {NAN, 1, 1}, .look_at = {1, 1, 0}}), mtf::UsageError);
  Lens none = lens;
  none.columns = 0;
  EXPECT_THROW(camera_of(none, {.look_at = {1, 0, 0}}), mtf::UsageError);
  none = lens;
  none.focal_length_mm = 0.0;
  EXPECT_THROW(camera_of(none, {.look_at = {1, 0, 0}}), mtf::UsageError);
}

/// The nearest triangle along a direction, and how near the ray passes to an edge of one before or at it.
struct Nearest {
  std::uint32_t triangle = scene::kNone;
  double distance = std::numeric_limits<double>::infinity(), to_edge = std::numeric_limits<double>::infinity();
};

double distance_to_segment(const Point& p, const Point& a, const Point& b) {
  const Vector ab = b - a;
  const double t = std::clamp(dot(p - a, ab) / dot(ab, ab), 0.0, 1.0);
  return scene::length(p - (a + t * ab));
}

Nearest nearest_triangle(const scene::Facets& facets, const Point& origin, const Vector& direction) {
  Nearest nearest;
  for (std::uint32_t t = 0; t < facets.triangles.size(); ++t) {
    const Point &a = facets.vertices[facets.triangles[t][0]], &b = facets.vertices[facets.triangles[t][1]],
                &c = facets.vertices[facets.triangles[t][2]];
    const Vector normal = cross(b - a, c - a);
    const double towards = dot(normal, direction), along = dot(normal, a - origin) / towards;
    if (!(along > 0.0) || !std::isfinite(along)) continue;
    const Point p = origin + along * direction;
    nearest.to_edge = std::min(
        {nearest.to_edge, distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
    const double u = dot(cross(b - a, p - a), normal), v = dot(cross(c - b, p - b), normal),
                 w = dot(cross(a - c, p - c), normal);
    if (u < 0.0 || v < 0.0 || w < 0.0 || along >= nearest.distance) continue;
    nearest.triangle = t;
    nearest.distance = along;
  }
  return nearest;
}

/// The points of the image that a camera sees: where they are, in samples, and what is there. Of every five sides two
/// are called likely, seen or not. The memory of one screen serves all scenes and cameras, as it does in a flight.
template <class Look>
void each_point(const RenderScene& scene, const Camera& eye, int n, const Look& look) {
  std::vector<std::uint32_t> likely(scene.temperature_k.size(), scene::kNone);
  for (std::size_t side = 0; side < likely.size(); ++side)
    if (side % 5 < 2) likely[side] = 0;
  static Screen screen;
  screen.place(scene, eye, n, likely, 2);
  ScreenRows rows;
  for (std::int64_t band = 0; band < screen.bands(); ++band) {
    screen.draw(band, rows);
    for (std::int64_t y = band * Screen::kRows; y < std::min((band + 1) * Screen::kRows, n * eye.height); ++y)
      for (std::int64_t x = 0; x < n * eye.width; ++x) {
        const auto at = static_cast<std::size_t>((y - band * Screen::kRows) * rows.stride + x);
        look(static_cast<double>(x / n) + point_in_sample(n, static_cast<int>(x % n)),
             static_cast<double>(y / n) + point_in_sample(n, static_cast<int>(y % n)), rows.side[at],
             static_cast<double>(rows.nearness[at]));
      }
  }
}

TEST(Screen, ShowsWhatASearchInDoublePrecisionFinds) {
  scene::Mesh mesh = scene::test::sphere({0.3, 0.1, 0.2}, 1.0, 6);
  add_box(mesh, {-2, -1, -1}, {0.7, 0.9, 1.1});
  add_plate(mesh, {-4, -4, -1.2}, {8, 0, 0}, {0, 8, 0.3}, 3, 3);
  const SmallScene made = small_scene(mesh, 300.0, grey(1.0), 300.0);
  const scene::Facets& facets = made.scene.facets();
  scene::test::Uniform uniform(3);
  std::size_t compared = 0, at_edges = 0;
  for (int c = 0; c < 100; ++c) {
    // Some cameras stand between the bodies, with corners of the plate behind them.
    const Point from = (c % 3 == 0 ? 1.4 : 3.0) * uniform.direction();
    const Point to = Point{0, 0, -0.4} + uniform() * uniform.direction();
    const Camera eye = camera({.position = from, .look_at = to}, 20, 13, 0.05);
    each_point(made.scene, eye, c % 2 == 0 ? 2 : 4, [&](double x, double y, std::uint32_t side, double nearness) {
      const Vector d = eye.direction(x, y);
      const Nearest brute = nearest_triangle(facets, from, d);
      if (brute.to_edge < 1e-6 * facets.half_extent_m) {
        ++at_edges;
        return;
      }
      ++compared;
      if (brute.triangle == scene::kNone) {
        ASSERT_EQ(side, scene::kNone);
        return;
      }
      ASSERT_NE(side, scene::kNone);
      ASSERT_EQ(side / 2, facets.facet_of[brute.triangle]);
      ASSERT_EQ(side % 2 == 1, dot(facets.facet[side / 2].normal, d) > 0.0);
      // The scene's size is that of the box around it; a grazing triangle has the error of the columns in its depth.
      const double slope = std::abs(dot(facets.facet[side / 2].normal, d)) / scene::length(d);
      ASSERT_NEAR(1.0 / nearness, brute.distance, 2e-6 * facets.half_extent_m / std::min(10.0 * slope, 1.0));
    });
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(compared, 100000u);
  EXPECT_LT(at_edges, 400u);
}

// Edges that are level in the image to rounding, which lines of sight at right angles to them make.
TEST(Screen, WallsSeenSquarelyAreWalls) {
  for (int azimuth = 0; azimuth < 720; ++azimuth) {
    const double turn = azimuth * std::numbers::pi / 360.0, x = std::sin(turn), y = std::cos(turn);
    scene::Mesh mesh = empty_mesh();
    add_plate(mesh, {-y, x, 0.7}, {2.0 * y, -2.0 * x, 0.0}, {0.0, 0.0, 0.5});
    const SmallScene made = small_scene(mesh, 300.0, grey(1.0), 300.0);
    const Camera eye = camera({.position = {-50.0 * x, -50.0 * y, azimuth % 2 == 0 ? 12.0 : 1.0}, .look_at = {0, 0, 1}},
                              80, 60, 0.0005);
    for (const int n : {1, 2, 4}) {
      std::size_t seen = 0, all = 0;
      each_point(made.scene, eye, n, [&](double, double, std::uint32_t side, double) {
        ++all;
        seen += side != scene::kNone ? 1 : 0;
      });
      ASSERT_NEAR(static_cast<double>(seen) / static_cast<double>(all), 80.0 * 20.0 / 4800.0, 0.04) << azimuth;
    }
  }
}

// Two plates in one place are equally near everywhere; a sphere hides part of them.
TEST(Screen, WhatIsLikelyToBeSeenChangesNoPoint) {
  scene::Mesh mesh = scene::test::sphere({0.0, 0.0, 0.4}, 0.5, 12);
  add_plate(mesh, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, 9, 7);
  add_plate(mesh, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, 6, 8);
  const SmallScene made = small_scene(mesh, 300.0, grey(1.0), 300.0);
  const Camera eye = camera({.position = {3, 1, 2}, .look_at = {0, 0, 0.2}}, 90, 70, 0.015);
  scene::test::Uniform uniform(11);
  const auto drawn = [&](double share) {
    std::vector<std::uint32_t> likely(share > 0.0 ? made.scene.temperature_k.size() : 0, scene::kNone);
    for (std::uint32_t& one : likely)
      if (uniform() < share) one = 0;
    Screen screen;
    screen.place(made.scene, eye, 2, likely, 1);
    ScreenRows rows;
    std::pair<std::vector<float>, std::vector<std::uint32_t>> all;
    for (std::int64_t band = 0; band < screen.bands(); ++band) {
      screen.draw(band, rows);
      all.first.insert(all.first.end(), rows.nearness.begin(), rows.nearness.end());
      all.second.insert(all.second.end(), rows.side.begin(), rows.side.end());
    }
    return all;
  };
  const auto none = drawn(0.0);
  for (const double share : {0.1, 0.5, 0.9, 1.0}) EXPECT_EQ(drawn(share), none) << share;
}

TEST(Screen, PointsOfASampleBlurAsItsSquareDoes) {
  for (const int n : {2, 4})
    for (int power = 0; power < 2 * ((n + 2) / 2); ++power) {
      double mean = 0.0;
      for (int i = 0; i < n; ++i) mean += std::pow(point_in_sample(n, i) - 0.5, power) / n;
      const double square = power % 2 == 1 ? 0.0 : std::pow(0.5, power) / (power + 1);
      EXPECT_NEAR(mean, square, 1e-15) << n << " " << power;
    }
}

std::size_t leaks(const scene::Mesh& mesh, int cameras, std::int64_t size, std::uint64_t seed) {
  const SmallScene made = small_scene(mesh, 300.0, grey(1.0), 300.0);
  scene::test::Uniform uniform(seed);
  std::size_t lost = 0;
  for (int c = 0; c < cameras; ++c) {
    const Camera eye = camera({.position = 0.3 * uniform.direction(), .look_at = 4.0 * uniform.direction()}, size, size,
                              2.0 / static_cast<double>(size));
    each_point(made.scene, eye, 2,
               [&](double, double, std::uint32_t side, double) { lost += side == scene::kNone ? 1 : 0; });
  }
  return lost;
}

TEST(Screen, NothingShowsThroughAClosedSurface) {
  const scene::Mesh sphere = scene::test::sphere({0, 0, 0}, 1.0, 92);
  EXPECT_GT(sphere.faces(), 16384u);  // more than a chunk of triangles
  EXPECT_EQ(leaks(sphere, 10, 158, 5), 0u);
}
TEST(ScreenLong, NothingShowsThroughAtTwentyMillionPoints) {
  EXPECT_EQ(leaks(scene::test::sphere({0, 0, 0}, 1.0, 200), 50, 224, 6), 0u);
  scene::Mesh box = empty_mesh();
  add_box(box, {-1, -1, -1}, {2, 2, 2}, 40, -1);
  EXPECT_EQ(leaks(box, 50, 224, 8), 0u);
}

}  // namespace
}  // namespace radiometry::render::test
