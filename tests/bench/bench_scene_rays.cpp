// SPDX-License-Identifier: Apache-2.0

// What the heat balance needs of the geometry of a scene the size of a detailed vehicle on terrain: facets, tree, sky
// view, visibility of the sun, classes, exchange. Processor time in s of all threads, one by default or the number in
// the first argument. The bar: sky view with 64 rays and 72 directions of the sun in 5.8 s of one core for 356,000
// triangles.

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <numeric>

#include "mtf/version.h"
#include "radiometry/scene/classes.h"
#include "radiometry/scene/exchange.h"
#include "radiometry/scene/table_error.h"
#include "tests/radiometry/scene/scene_cases.h"

namespace {

using namespace radiometry::scene;  // NOLINT: a benchmark program

/// A hull, a turret, wheels, tracks and a barrel on rough ground; `fine` times as many facets along each edge.
Mesh vehicle(double fine) {
  const auto n = [fine](int count) { return std::max(2, static_cast<int>(count * fine + 0.5)); };
  Mesh mesh = test::sphere({0.3, 0, 2.0}, 0.9, n(100));
  const auto add_sphere = [&](const Point& centre, double radius, int count) {
    const Mesh ball = test::sphere(centre, radius, count);
    for (std::size_t f = 0; f < ball.faces(); ++f) {
      std::vector<Point> corners;
      for (std::uint64_t c = ball.first[f]; c < ball.first[f + 1]; ++c)
        corners.push_back(ball.vertices[ball.corners[c]]);
      test::add_face(mesh, corners);
    }
  };
  test::add_box(mesh, {-3, -1.2, 0.8}, {6, 2.4, 0.9}, n(80));
  for (int i = 0; i < 7; ++i)
    for (const double y : {-1.5, 1.5}) add_sphere({-2.4 + 0.8 * i, y, 0.4}, 0.35, n(39));
  for (const double y : {-1.75, 1.25}) test::add_box(mesh, {-3, y, 0.9}, {6, 0.5, 0.1}, n(60));
  test::add_box(mesh, {1.2, -0.08, 1.95}, {3.5, 0.16, 0.16}, n(20));
  const int ground = n(165);
  const auto height = [](double x, double y) { return 0.03 * std::sin(1.7 * x) * std::cos(2.3 * y) - 0.03; };
  const auto at = [&](int i, int j) -> Point {
    const double x = -15 + 30.0 * i / ground, y = -15 + 30.0 * j / ground;
    return {x, y, height(x, y)};
  };
  for (int i = 0; i < ground; ++i)
    for (int j = 0; j < ground; ++j) {
      test::add_face(mesh, {at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      test::add_face(mesh, {at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

template <class Work>
auto timed(const char* what, const Work& work) {
  const std::clock_t start = std::clock();
  auto result = work();
  std::printf("  %-44s %7.3f s\n", what, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  return result;
}

/// Sun over a day at a middle latitude, 72 directions from sunrise to sunset.
std::vector<Vector> sun_path() {
  std::vector<Vector> path;
  for (int i = 0; i < 72; ++i) {
    const double hour = 3.14159265 * (i + 0.5) / 72;
    path.push_back({std::cos(hour), -0.5 * std::sin(hour), 0.85 * std::sin(hour)});
  }
  return path;
}

/// Halfway between the directions.
std::vector<SunCheck> checks_of(const std::vector<Vector>& to_sun) {
  std::vector<SunCheck> checks;
  for (std::size_t d = 0; d + 1 < to_sun.size(); ++d) checks.push_back({unit(to_sun[d] + to_sun[d + 1]), d, 0.5});
  return checks;
}

/// 640 x 512 pixels of 30 degrees across, in tiles of 4 x 4, from beside the vehicle.
std::vector<Ray> camera_rays() {
  const Point eye{9, -9, 4};
  const Vector forward = (1.0 / length(eye)) * (-1.0 * eye);
  const Vector right = (1.0 / std::hypot(forward[0], forward[1])) * Vector{forward[1], -forward[0], 0};
  const Vector up = cross(right, forward);
  std::vector<Ray> rays;
  for (int tile = 0; tile < 160 * 128; ++tile)
    for (int k = 0; k < 16; ++k) {
      const double x = (4 * (tile % 160) + k % 4 - 319.5) / 1200, y = (4 * (tile / 160) + k / 4 - 255.5) / 1200;
      rays.push_back({eye, forward + x * right + y * up});
    }
  return rays;
}

void run(double fine, int threads) {
  const Mesh mesh = vehicle(fine);
  const PlacedMesh placed{"vehicle", &mesh, Winding::outward};
  Facets made = timed("facets", [&] { return facets_of(std::span(&placed, 1)); });
  std::printf("  %zu triangles, %zu facets, %zu vertices, %zu open shells\n", made.triangles.size(), made.size(),
              made.vertices.size(), static_cast<std::size_t>(made.report[0].open_shells));
  const Rays rays = timed("tree", [&] { return Rays(std::move(made)); });
  const std::vector<Ray> camera = camera_rays();
  std::vector<Hit> hits_of_camera(camera.size());
  const auto met = timed("640 x 512 camera rays", [&] {
    rays.first_hits(camera, hits_of_camera, threads);
    return std::count_if(hits_of_camera.begin(), hits_of_camera.end(), [](const Hit& hit) { return hits(hit); });
  });
  std::printf("    %.0f %% hit\n", 100.0 * static_cast<double>(met) / static_cast<double>(camera.size()));
  const Receivers receivers = single_sides(rays.facets());
  const std::vector<Vector> to_sun = sun_path();
  const ViewOptions view_options{.rays = 64, .threads = threads};
  const Views seen = timed("sky view, 64 rays a facet", [&] { return views(rays, receivers, view_options); });
  SunVisibility sun;
  for (const int points : {1, 4}) {
    const SunOptions options{.points = points, .threads = threads};
    sun =
        timed(points == 1 ? "72 directions of the sun, 1 point a facet" : "72 directions of the sun, 4 points a facet",
              [&] { return sun_visibility(rays, receivers.sides, to_sun, options); });
    const TableError error = timed(
        "  its error", [&] { return sun_error(rays, receivers.sides, checks_of(to_sun), sun, options).of_directions; });
    std::printf("    %zu facets: rms %.4f, 95 %% %.4f of the direct irradiance\n", error.count, error.rms,
                error.percentile_95);
  }
  const ViewError error =
      timed("  error of the sky view", [&] { return view_error(rays, receivers, seen, view_options); });
  std::printf("    sky: rms %.4f, 95 %% %.4f; surfaces: rms %.4f, 95 %% %.4f\n", error.sky.rms, error.sky.percentile_95,
              error.surfaces.rms, error.surfaces.percentile_95);

  const std::vector<SideFinish> finish(receivers.size(), SideFinish{0, 0.7, 0.9});
  const FluxAmplitudes amplitudes{.direct = std::vector<double>(72, 850.0),
                                  .sky_solar = std::vector<double>(9, 100.0),
                                  .sky_longwave = {220, 222, 224, 228, 234, 243, 256, 276, 310},
                                  .ground_solar = 150,
                                  .ground_longwave = 390,
                                  .surfaces_solar = 100,
                                  .surfaces_longwave = 400};
  Classes classes;
  for (const double tolerance : {1.0, 1.5, 5.0, 15.0}) {
    char what[64];
    std::snprintf(what, sizeof what, "classes within %.1f W/m2", tolerance);
    classes = timed(what, [&] {
      return classes_of(rays.facets(), receivers.sides, finish, seen, sun, to_sun, amplitudes, tolerance, threads);
    });
    std::printf("    %zu classes\n", classes.size());
  }
  const Receivers sets = sets_of_sides(receivers.sides, classes.class_of, classes.size());
  std::vector<std::uint32_t> patch_of(sets.size());
  for (std::uint32_t i = 0; i < patch_of.size(); ++i) patch_of[i] = i % 1000;
  const std::size_t patches = std::min<std::size_t>(1000, sets.size());
  const std::vector<std::uint32_t> of_sides = patches_of_sides(rays.facets(), sets, patch_of);
  timed("views of classes, 512 rays each",
        [&] { return views(rays, sets, of_sides, patches, {.rays = 512, .threads = threads}); });
  std::vector<std::uint32_t> own(receivers.size());
  std::iota(own.begin(), own.end(), 0U);
  const std::vector<std::uint32_t> own_of_sides = patches_of_sides(rays.facets(), receivers, own);
  const Views told = timed("sky view, 64 rays, with the sides that are seen",
                           [&] { return views(rays, receivers, own_of_sides, own.size(), view_options); });
  const std::vector<double> side_areas = areas_m2(rays.facets(), receivers);
  std::vector<std::uint32_t> patch_of_receiver;
  for (const std::uint32_t of_class : classes.class_of) patch_of_receiver.push_back(patch_of[of_class]);
  const Views rows = timed("views of classes from these", [&] {
    return combined_views(told, side_areas, classes.class_of, classes.size(), patch_of_receiver, patches);
  });
  const std::vector<double> areas = areas_m2(rays.facets(), sets);
  const Exchange exchange =
      timed("exchange of 1000 patches", [&] { return exchange_of(rows, areas, patch_of, patches); });
  std::printf("    %zu factors, change %.4f, own view %.1e\n", exchange.factors.value.size(), exchange.change,
              exchange.own_view);
  const std::vector<double> none(sets.size(), 0.0), emitted(sets.size(), 400.0), reflectance(sets.size(), 0.3);
  timed("irradiance, one time step", [&] {
    return irradiance_w_m2(exchange, {emitted, reflectance, none, none}, 1e-10);
  });
}

}  // namespace

int main(int argc, char** argv) {
  const int threads = argc > 1 ? std::atoi(argv[1]) : 1;
  std::printf("mtfkit %s (%s), %d threads, processor time\n", mtf::version, mtf::git_commit, threads);
  for (const double fine : {0.7, 1.0}) run(fine, threads);
}
