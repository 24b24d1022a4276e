// SPDX-License-Identifier: Apache-2.0

// From meshes to the irradiance of every class, as the heat balance goes: two meshes, one of them with a sheet that is
// received on both sides.

#include <gtest/gtest.h>

#include "radiometry/light/constants.h"
#include "radiometry/scene/classes.h"
#include "radiometry/scene/exchange.h"
#include "tests/radiometry/scene/scene_cases.h"

namespace radiometry::scene {
namespace {

struct WholeScene {
  Rays rays;
  Receivers sides, sets;
  std::vector<SideFinish> finish;  // of sets
  Views rows;                      // of sets
  Exchange exchange;
};

WholeScene whole_scene(bool traced_once) {
  Mesh vehicle = test::empty_mesh(), terrain = test::empty_mesh();
  test::add_box(vehicle, {-1, -0.5, 0.3}, {2, 1, 0.8}, 12);
  test::add_plate(vehicle, {1.2, -0.5, 0.4}, {0, 1, 0}, {0.2, 0, 0.7}, 8, 8);
  test::add_plate(terrain, {-4, -4, 0}, {8, 0, 0}, {0, 8, 0}, 30, 30);
  const std::array<PlacedMesh, 2> placed{{{"vehicle", &vehicle}, {"terrain", &terrain}}};
  Rays rays(facets_of(placed));
  const Facets& facets = rays.facets();

  std::vector<Side> sides = single_sides(facets).sides;
  for (std::uint32_t f = 0; f < facets.size(); ++f)
    if (facets.facet[f].mesh == 0 && !facets.shells[facets.facet[f].shell].closed) sides.push_back({f, true});
  const Receivers each = single_sides(sides);
  std::vector<SideFinish> finish;
  for (const Side side : sides) {
    const bool soil = facets.facet[side.facet].mesh == 1;
    finish.push_back({soil ? 0U : side.back ? 2U : 1U, soil ? 0.8 : 0.5, soil ? 0.95 : side.back ? 0.1 : 0.9});
  }

  std::vector<Vector> to_sun;
  for (int h = 1; h < 24; ++h) to_sun.push_back({std::cos(h * 0.13), -0.4, std::sin(h * 0.13)});
  const ViewOptions rough{.rays = 64};
  std::vector<std::uint32_t> own(each.size());
  for (std::uint32_t i = 0; i < own.size(); ++i) own[i] = i;
  const Views seen = views(rays, each, patches_of_sides(facets, each, own), own.size(), rough);
  const SunVisibility sun = sun_visibility(rays, sides, to_sun);
  const FluxAmplitudes amplitudes{.direct = std::vector<double>(to_sun.size(), 800.0),
                                  .sky_solar = std::vector<double>(9, 100.0),
                                  .sky_longwave = std::vector<double>(9, -100.0),
                                  .ground_solar = 60,
                                  .ground_longwave = 30,
                                  .surfaces_solar = 60,
                                  .surfaces_longwave = 30};
  const Classes classes = classes_of(facets, sides, finish, seen, sun, to_sun, amplitudes, 20.0);
  EXPECT_LT(classes.size(), sides.size());

  // Patches of the leaders; tables of the leaders are rows of those of all sides.
  Views leader_views{.rings = seen.rings, .sky = {}, .ground = {}, .surfaces = {}, .rays = {}, .patches = {}};
  SunVisibility leader_sun{sun.points, sun.directions, {}};
  std::vector<Side> leaders;
  std::vector<SideFinish> leader_finish;
  for (const std::uint32_t i : classes.leader) {
    leaders.push_back(sides[i]);
    leader_finish.push_back(finish[i]);
    for (std::size_t r = 0; r < 9; ++r) leader_views.sky.push_back(seen.sky[9 * i + r]);
    leader_views.ground.push_back(seen.ground[i]);
    leader_views.surfaces.push_back(seen.surfaces[i]);
    for (std::size_t d = 0; d < to_sun.size(); ++d) leader_sun.lit.push_back(sun.lit[i * to_sun.size() + d]);
  }
  const Classes patches = patches_of(facets, leaders, leader_finish, leader_views, leader_sun, to_sun, amplitudes, 40);
  EXPECT_LE(patches.size(), 40U);

  const Receivers sets = sets_of_sides(sides, classes.class_of, classes.size());
  const std::vector<std::uint32_t> patch_of_side = patches_of_sides(facets, sets, patches.class_of);
  std::vector<std::uint32_t> patch_of_receiver;
  for (const std::uint32_t of_class : classes.class_of) patch_of_receiver.push_back(patches.class_of[of_class]);
  Views rows = traced_once ? combined_views(seen, areas_m2(facets, each), classes.class_of, classes.size(),
                                            patch_of_receiver, patches.size())
                           : views(rays, sets, patch_of_side, patches.size(), {.rays = 512});
  Exchange exchange = exchange_of(rows, areas_m2(facets, sets), patches.class_of, patches.size());
  return {std::move(rays), each, sets, leader_finish, std::move(rows), std::move(exchange)};
}

TEST(WholeScene, IsothermalUnderAnIsothermalSky) {
  for (const bool traced_once : {false, true}) {
    const WholeScene scene = whole_scene(traced_once);
    const double flux = kStefanBoltzmann_w_m2_k4 * std::pow(290.0, 4);
    std::vector<double> emitted, reflectance, environment, none(scene.sets.size(), 0.0);
    for (std::size_t i = 0; i < scene.sets.size(); ++i) {
      emitted.push_back(scene.finish[i].emissivity * flux);
      reflectance.push_back(1.0 - scene.finish[i].emissivity);
      environment.push_back((scene.rows.sky_share(i) + scene.rows.ground[i]) * flux);
    }
    const std::vector<double> h = irradiance_w_m2(scene.exchange, {emitted, reflectance, environment, none});
    for (const double value : h) EXPECT_NEAR(value, flux, 1e-12 * flux);
    EXPECT_LT(scene.exchange.own_view, 1e-12);
  }
}

TEST(WholeScene, SidesOfASheetSeeDifferentThings) {
  const WholeScene scene = whole_scene(false);
  const Facets& facets = scene.rays.facets();
  double front = 0.0, back = 0.0;
  for (std::size_t i = 0; i < scene.sides.size(); ++i) {
    const Side side = scene.sides[i][0];
    if (facets.facet[side.facet].mesh == 1 || facets.shells[facets.facet[side.facet].shell].closed) continue;
    const Views seen = views(scene.rays, single_sides(std::vector<Side>{side}), {.rays = 256});
    (side.back ? back : front) += seen.sky_share(0) / 64;
  }
  // The front points away from the box and a little down; nothing hides the sky from it. The back faces the box.
  const double up = 0.2 / std::hypot(0.2, 0.7);
  EXPECT_NEAR(front, 0.5 * (1.0 - up), 1e-12);
  EXPECT_LT(back, 0.5 * (1.0 + up) - 0.2);
}

}  // namespace
}  // namespace radiometry::scene
