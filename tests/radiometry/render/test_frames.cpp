// SPDX-License-Identifier: Apache-2.0
// Frames that follow one another: cameras that rise and sink, another time, band or air, temperatures that change.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "render_cases.h"

namespace radiometry::render::test {
namespace {

namespace air = radiometry::atmosphere;

double largest_difference(const mtf::Image& a, const mtf::Image& b) {
  double worst = 0.0;
  for (std::int64_t i = 0; i < a.size(); ++i)
    worst = std::max(worst, std::abs(static_cast<double>(a.data()[i]) / static_cast<double>(b.data()[i]) - 1.0));
  return worst;
}

/// Two walls and some ground at a distance, in hazy air.
SmallScene distant() {
  scene::Mesh mesh = empty_mesh();
  add_plate(mesh, {800, -60, 0}, {0, 120, 0}, {10, 0, 50}, 4, 4);
  add_plate(mesh, {300, -60, 0}, {500, 0, 0}, {0, 120, 0}, 8, 4);
  SmallScene made = small_scene(mesh, 300.0, grey(0.8), 260.0);
  for (std::size_t s = 0; s < made.scene.temperature_k.size(); ++s)
    made.scene.temperature_k[s] = 285.0F + 2.0F * static_cast<float>(s % 13);
  made.scene.sun = Sun{.to_sun = {-0.5, 0.25, 0.6}, .direct_w_m2 = 800.0};
  made.scene.air = air::Air<double>{.profile = air::model_profile(air::ModelAtmosphere::mid_latitude_summer),
                                    .haze = {.kind = air::HazeKind::rural, .visibility_m = 5e3}};
  return made;
}
Camera over(double height_m) { return camera({.position = {0, 0, height_m}, .look_at = {600, 0, 10}}, 64, 48, 0.003); }

// Straight lines between two heights against tables of that very height.
TEST(Renderer, ACameraThatRisesSeesWhatOneThereSees) {
  const SmallScene made = distant();
  for (const RenderBand& band : {mwir(), lwir()}) {
    Renderer flying(made.scene, {band}, {.points = 1, .layers = {.facet = true}});
    for (const double height : {70.0, 71.0, 81.0, 79.0, 131.0, 30.0}) {
      const RenderedFrame seen = flying.render(over(height)),
                          there = Renderer(made.scene, {band}, {.points = 1}).render(over(height));
      // Haze has a step at the height of the camera (AirView), which is among those of the wall at 30 m.
      EXPECT_LT(seen.promised[0], height > 60.0 ? 1e-4 : 2e-3) << height;
      double of_facets = 0.0, of_ground = 0.0;  // cubics of the elevation, 6 km away in haze at the most
      for (std::int64_t i = 0; i < 64 * 48; ++i) {
        const double differs = std::abs(
            static_cast<double>(seen.radiance[0].data()[i]) / static_cast<double>(there.radiance[0].data()[i]) - 1.0);
        double& worst = seen.layers[0].plane.data()[i] >= 0.0F ? of_facets : of_ground;
        worst = std::max(worst, differs);
      }
      EXPECT_LT(of_facets, seen.promised[0] + there.promised[0]) << band.name << " " << height;
      EXPECT_LT(of_ground, height > 60.0 ? 1e-4 : 1e-3) << band.name << " " << height;
    }
  }
}

// A camera that rises and turns away from half of the wall: only the other half is worked out for the new height.
TEST(Renderer, WhatIsNoLongerShownIsNotShaded) {
  const SmallScene made = distant();
  const auto towards = [](double y, double height_m) {
    return camera({.position = {600, 0, height_m}, .look_at = {800, y, 25}}, 64, 48, 0.003);
  };
  Renderer flying(made.scene, {lwir()}, {.points = 1});
  flying.render(towards(-30.0, 30.0));
  flying.render(towards(30.0, 31.0));
  const RenderedFrame both = flying.render(camera({.position = {500, 0, 32}, .look_at = {800, 0, 25}}, 128, 48, 0.004)),
                      half = flying.render(towards(30.0, 33.0));
  EXPECT_EQ(both.shaded, both.sides);
  EXPECT_LT(half.shaded, both.shaded);
  EXPECT_GT(half.shaded, 4u);
  const RenderedFrame there = Renderer(made.scene, {lwir()}, {.points = 1}).render(towards(30.0, 33.0));
  EXPECT_LT(largest_difference(half.radiance[0], there.radiance[0]), 1e-3);
}

// The ground beyond the facets, warm under clear air, for a camera that sinks to it.
TEST(Renderer, ACameraThatSinksSeesTheGroundThroughItsAir) {
  SmallScene made = distant();
  made.scene.air->haze = {};
  made.scene.ground.temperature_k = 310.0;
  Renderer flying(made.scene, {lwir()}, {.points = 1});
  for (const double height : {12.0, 11.0, 7.0, 3.0, 1.0, 0.4, 2.0}) {
    const RenderedFrame seen = flying.render(over(height)),
                        there = Renderer(made.scene, {lwir()}, {.points = 1}).render(over(height));
    EXPECT_LT(largest_difference(seen.radiance[0], there.radiance[0]), 1e-3) << height;
  }
}

// Tables that cover both places of a camera that goes to and fro serve both: their promise stays the same number.
TEST(Renderer, ACameraThatGoesToAndFroKeepsItsTables) {
  const SmallScene made = distant();
  const auto from = [](double x) {
    return camera({.position = {x, 0, 40}, .look_at = {x + 600, 0, 0}}, 64, 48, 0.006);
  };
  Renderer flying(made.scene, {lwir()}, {.points = 1});
  const double far = flying.render(from(0.0)).promised[0], both = flying.render(from(200.0)).promised[0];
  EXPECT_NE(far, both);
  for (const double x : {0.0, 200.0, 100.0}) {
    const RenderedFrame seen = flying.render(from(x)),
                        there = Renderer(made.scene, {lwir()}, {.points = 1}).render(from(x));
    EXPECT_EQ(seen.promised[0], both) << x;
    EXPECT_LT(largest_difference(seen.radiance[0], there.radiance[0]), seen.promised[0] + there.promised[0]) << x;
  }
  // Ranges of another order, near the wall, have tables for them alone.
  EXPECT_NE(flying.render(from(780.0)).promised[0], both);
  EXPECT_EQ(flying.render(from(0.0)).promised[0], far);
}

// A pole of one sample before a wall in the shade has its own light.
TEST(Renderer, ThinThingsHaveTheirOwnShadows) {
  scene::Mesh mesh = empty_mesh();
  add_plate(mesh, {-20, 10, -20}, {40, 0, 0}, {0, 0, 40});  // the wall
  add_plate(mesh, {-20, 4, 8}, {40, 0, 0}, {0, 6.5, 0});    // the roof that shades it
  add_plate(mesh, {0.0, 0, -4}, {0.011, 0, 0}, {0, 0, 8});  // the pole, in the sun
  SmallScene made = small_scene(mesh, 300.0, grey(0.5), 300.0);
  made.scene.sun = Sun{.to_sun = {0.0, -0.3, 1.0}, .direct_w_m2 = 900.0};
  const Camera eye = camera({.position = {0.0055, -10, 0}, .look_at = {0.0055, 0, 0}}, 101, 40, 0.001);
  const RenderedFrame frame = Renderer(made.scene, {mwir()}, {.points = 1, .layers = {.facet = true}}).render(eye);
  const RenderedFrame all = Renderer(made.scene, {mwir()}, {.points = 1, .ray_shadows = true}).render(eye);
  std::size_t pole = 0;
  for (std::int64_t i = 0; i < frame.radiance[0].size(); ++i) {
    if (frame.layers[0].plane.data()[i] != 2.0F) continue;
    ++pole;
    ASSERT_NEAR(frame.radiance[0].data()[i] / all.radiance[0].data()[i], 1.0F, 1e-6F);
  }
  EXPECT_GE(pole, 40u);
}

// What one renderer knows of views serves another light: the picture is that of one that began there.
TEST(Renderer, TakesOverViewsForAnotherTimeBandAndAir) {
  const SmallScene before = distant();
  SmallScene after = distant();
  for (float& kelvin : after.scene.temperature_k) kelvin += 0.4F;
  after.scene.rays = before.scene.rays;  // the same facets
  after.scene.sun->to_sun = {-0.6, 0.2, 0.4};
  after.scene.air->haze.visibility_m = 9e3;
  const RenderOptions same{.view_rays = 256, .most_view_rays = 256};
  Renderer first(before.scene, {lwir()}, same);
  first.render(over(20.0));
  Renderer second(after.scene, {mwir()}, *first.known()), fresh(after.scene, {mwir()}, same);
  const RenderedFrame seen = second.render(over(20.0)), there = fresh.render(over(20.0));
  EXPECT_LT(largest_difference(seen.radiance[0], there.radiance[0]), seen.promised[0] + there.promised[0]);
  // Far from the temperatures that patches were put together by, they are put together anew.
  for (std::size_t s = 0; s < after.scene.temperature_k.size(); ++s)
    after.scene.temperature_k[s] += s % 2 == 0 ? 9.0F : -9.0F;
  Renderer third(after.scene, {mwir()}, *second.known()), anew(after.scene, {mwir()}, same);
  const RenderedFrame far = third.render(over(20.0)), far_there = anew.render(over(20.0));
  EXPECT_LT(largest_difference(far.radiance[0], far_there.radiance[0]), far.promised[0] + far_there.promised[0]);
}

// Temperatures that change are seen at once, inside the range of the tables and outside.
TEST(Renderer, SeesTemperaturesThatChange) {
  SmallScene made = distant();
  for (auto& finish : made.scene.finish) finish.emissivity = grey(1.0);  // what surfaces reflect keeps its own time
  Renderer renderer(made.scene, {lwir()});
  renderer.render(over(20.0));
  for (const float change : {0.3F, -0.2F, 7.0F}) {
    for (float& kelvin : made.scene.temperature_k) kelvin += change;
    renderer.temperatures_changed();
    const RenderedFrame seen = renderer.render(over(20.0)), there = Renderer(made.scene, {lwir()}).render(over(20.0));
    EXPECT_LT(largest_difference(seen.radiance[0], there.radiance[0]), seen.promised[0] + there.promised[0]) << change;
  }
}

}  // namespace
}  // namespace radiometry::render::test
