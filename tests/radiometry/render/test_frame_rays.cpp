// SPDX-License-Identifier: Apache-2.0
// Camera rays: where they go, what they meet against a search through all triangles in double precision, and that none
// slips through a closed surface.

#include "radiometry/render/frame_rays.h"

#include <gtest/gtest.h>

#include <limits>

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

TEST(Camera, RefusesViewsThatAreNone) {
  const Lens lens{.focal_length_mm = 50.0, .pitch_x_um = 20.0, .pitch_y_um = 20.0, .columns = 64, .rows = 32};
  EXPECT_THROW(camera_of(lens, {.position = {1, 1, 1}, .look_at = {1, 1, 1}}), mtf::UsageError);
  EXPECT_THROW(camera_of(lens, {.position = {1, 1, 1}, .look_at = {1, 1, 0}}), mtf::UsageError);  // along `up`
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

TEST(FrameRays, MeetWhatASearchInDoublePrecisionMeets) {
  scene::Mesh mesh = scene::test::sphere({0.3, 0.1, 0.2}, 1.0, 6);
  add_box(mesh, {-2, -1, -1}, {0.7, 0.9, 1.1});
  add_plate(mesh, {-4, -4, -1.2}, {8, 0, 0}, {0, 8, 0.3}, 3, 3);
  const scene::Rays rays(scene::test::facets(mesh));
  const scene::Facets& facets = rays.facets();
  scene::test::Uniform uniform(3);
  std::size_t compared = 0, at_edges = 0;
  for (int c = 0; c < 100; ++c) {
    const Point from = 3.0 * uniform.direction();
    const Point to = Point{0, 0, -0.4} + uniform() * uniform.direction();
    const Camera eye = camera({.position = from, .look_at = to}, 32, 32, 0.03);
    const RayPlan plan = RayPlan::tiles(eye);
    RayHits hits;
    hits.resize(plan.packets(), true);
    trace_rays(rays, eye, plan, 0, hits, 1);
    for (std::size_t i = 0; i < hits.side.size(); ++i) {
      const RayPlan::Place place = plan.place(i / 16, i % 16);
      const Vector d = eye.direction(place.x, place.y);
      const Nearest brute = nearest_triangle(facets, from, d);
      if (brute.to_edge < 1e-6 * facets.half_extent_m) {
        ++at_edges;
        continue;
      }
      ++compared;
      if (brute.triangle == scene::kNone) {
        ASSERT_EQ(hits.side[i], scene::kNone);
        continue;
      }
      ASSERT_NE(hits.side[i], scene::kNone);
      ASSERT_EQ(hits.side[i] / 2, facets.facet_of[brute.triangle]);
      const double exact = brute.distance * scene::length(d);
      const double precise = scene::distance_to(facets, hits.triangle[i], from, d) * scene::length(d);
      ASSERT_NEAR(precise, exact, 1e-6 * facets.half_extent_m);
    }
  }
  EXPECT_GT(compared, 100000u);
  EXPECT_LT(at_edges, 200u);
}

std::size_t leaks(const scene::Mesh& mesh, int cameras, std::int64_t size, std::uint64_t seed) {
  const scene::Rays rays(scene::test::facets(mesh));
  scene::test::Uniform uniform(seed);
  std::size_t lost = 0;
  for (int c = 0; c < cameras; ++c) {
    const Camera eye = camera({.position = 0.3 * uniform.direction(), .look_at = 4.0 * uniform.direction()}, size, size,
                              2.0 / static_cast<double>(size));
    const RayPlan plan = RayPlan::tiles(eye);
    RayHits hits;
    hits.resize(plan.packets(), false);
    trace_rays(rays, eye, plan, 0, hits, 0);
    lost += static_cast<std::size_t>(std::count(hits.side.begin(), hits.side.end(), scene::kNone));
  }
  return lost;
}

TEST(FrameRays, NoneLeavesAClosedSurface) { EXPECT_EQ(leaks(scene::test::sphere({0, 0, 0}, 1.0, 60), 10, 316, 5), 0u); }
TEST(FrameRaysLong, NoneOfTenMillionLeavesAClosedSurface) {
  EXPECT_EQ(leaks(scene::test::sphere({0, 0, 0}, 1.0, 200), 50, 448, 6), 0u);
  scene::Mesh box = empty_mesh();
  add_box(box, {-1, -1, -1}, {2, 2, 2}, 40, -1);
  EXPECT_EQ(leaks(box, 50, 448, 8), 0u);
}

}  // namespace
}  // namespace radiometry::render::test
