// SPDX-License-Identifier: Apache-2.0
// Surfaces whose emissivity depends on the angle, and mirrors: rooms of one temperature, closed forms, mirror images at
// the place that geometry gives them.

#include <gtest/gtest.h>

#include <cmath>

#include "mtf/error.h"
#include "render_cases.h"

namespace radiometry::render::test {
namespace {

using scene::operator-, scene::operator+, scene::operator*;
namespace air = radiometry::atmosphere;

TEST(AngularEmissivity, HasTheMeansOfItsClosedForms) {
  for (const double p : {1.0, 5.0, 20.0})
    EXPECT_NEAR(hemispherical_mean(schlick(p)), 1.0 - 2.0 / ((p + 1.0) * (p + 2.0)), 2e-6 * p * p) << p;
  // Howell, Menguc and Siegel, Thermal Radiation Heat Transfer: hemispherical emissivity of a dielectric (Dunkle).
  for (const double n : {1.3, 1.5, 2.5}) {
    const double n2 = n * n, n4 = n2 * n2;
    const double all_sides = 0.5 - (3.0 * n + 1.0) * (n - 1.0) / (6.0 * (n + 1.0) * (n + 1.0)) -
                             n2 * std::pow(n2 - 1.0, 2) / std::pow(n2 + 1.0, 3) * std::log((n - 1.0) / (n + 1.0)) +
                             2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0)) -
                             8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * std::pow(n4 - 1.0, 2)) * std::log(n);
    const double along_normal = 4.0 * n / std::pow(n + 1.0, 2);
    EXPECT_NEAR(hemispherical_mean(dielectric(n)), all_sides / along_normal, 1e-5) << n;
  }
  const AngularEmissivity table = angle_table(std::vector{0.0, 60.0, 90.0}, std::vector{1.0, 0.8, 0.0});
  EXPECT_NEAR(relative_emissivity(table, 0.5), 0.8, 1e-6);
  EXPECT_NEAR(relative_emissivity(table, std::cos(75.0 * std::acos(-1.0) / 180.0)), 0.4, 1e-4);
  EXPECT_EQ(relative_emissivity({}, 0.3), 1.0);
  EXPECT_THROW(schlick(0.5), mtf::UsageError);
  EXPECT_THROW(dielectric(1.0), mtf::UsageError);
  EXPECT_THROW(angle_table(std::vector{0.0, 95.0}, std::vector{1.0, 0.8}), mtf::UsageError);
}

TEST(Angles, ARoomOfOneTemperatureIsBlackWhateverTheAngle) {
  constexpr double kKelvin = 300.0;
  scene::Mesh mesh = empty_mesh();
  add_box(mesh, {-4, -3, 0}, {8, 6, 3}, 4, -1);
  add_box(mesh, {-1, -1, 0.01}, {1, 1.5, 1}, 2);
  const std::vector<Finish> finishes{
      {"paint", coloured(), schlick(5.0), 0.0},
      {"glass", grey(0.9), dielectric(1.5), 0.9},
      {"steel", grey(0.1), {}, 1.0},
      {"brushed", coloured(), angle_table(std::vector{0.0, 80.0}, std::vector{1.0, 1.05}), 0.5}};
  air::Profile<double> layered = air::model_profile(air::ModelAtmosphere::us_standard_1976);
  for (auto& level : layered.levels) level.temperature_k = kKelvin;
  for (const bool with_air : {false, true})
    for (const Finish& finish : finishes) {
      SmallScene made = small_scene(mesh, kKelvin, finish.emissivity, kKelvin);
      made.scene.finish[0] = finish;
      if (with_air) made.scene.air = air::Air<double>{.profile = layered};
      Renderer renderer(made.scene, {mwir(), lwir()}, {.view_rays = 16});
      const RenderedFrame frame =
          renderer.render(camera({.position = {3.5, 2.5, 2.5}, .look_at = {-1, 0, 0.5}}, 40, 30, 0.03));
      for (std::size_t b = 0; b < 2; ++b) {
        const double black = blackbody(b == 0 ? mwir() : lwir(), kKelvin);
        for (std::int64_t i = 0; i < frame.radiance[b].size(); ++i)
          ASSERT_NEAR(static_cast<double>(frame.radiance[b].data()[i]) / black, 1.0, 1e-6) << finish.name;
      }
    }
}

/// A plate under a sky and above a ground of one temperature: eps g B(T) + (1 - eps g) B(T_sky).
TEST(Angles, ATiltedPlateHasTheRadianceOfItsAngle) {
  for (const double degrees : {0.0, 40.0, 70.0, 85.0})
    for (const double gloss : {0.0, 0.6, 1.0}) {
      scene::Mesh mesh = empty_mesh();
      add_plate(mesh, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0});
      SmallScene made = small_scene(mesh, 320.0, grey(0.8), 260.0);
      made.scene.finish[0].by_angle = schlick(5.0);
      made.scene.finish[0].gloss = gloss;
      made.scene.finish.push_back({"soil", grey(1.0), {}, 0.0});
      made.scene.ground.finish = 1;
      const double angle = degrees * std::acos(-1.0) / 180.0;
      const Point from{0.0, -50.0 * std::sin(angle), 50.0 * std::cos(angle)};
      Renderer renderer(made.scene, {lwir()}, {.points = 1, .layers = {.emissivity = true}});
      const RenderedFrame frame =
          renderer.render(camera({.position = from, .look_at = {0, 0, 0}, .up = {0, 1, 0}}, 3, 3, 1e-4));
      const double emissivity = 0.8 * (1.0 - std::pow(1.0 - std::cos(angle), 5.0));
      const double wanted = emissivity * blackbody(lwir(), 320.0) + (1.0 - emissivity) * blackbody(lwir(), 260.0);
      EXPECT_NEAR(static_cast<double>(frame.radiance[0].at(1, 1)) / wanted, 1.0, 1e-5) << degrees << " " << gloss;
      EXPECT_NEAR(static_cast<double>(frame.layers[0].plane.at(1, 1)), emissivity, 1e-5);
    }
}

/// A level mirror, and behind it a warm plate that stands upright and faces the camera. Which pixels of the mirror show
/// the plate follows from the ray that is turned over at z = 0.
TEST(Angles, AMirrorShowsTheWarmPlateWhereGeometrySays) {
  constexpr double kWarm = 340.0, kMirror = 250.0, kSky = 250.0;
  scene::Mesh mesh = empty_mesh();
  add_plate(mesh, {-10, 0, 0}, {20, 0, 0}, {0, 19, 0});
  add_plate(mesh, {-1.5, 20, 1}, {3, 0, 0}, {0, 0, 2});
  SmallScene made = small_scene(mesh, kMirror, grey(0.1), kSky);
  made.scene.finish = {{"mirror", grey(0.1), {}, 1.0}, {"paint", coloured(), {}, 0.0}, {"black", grey(1.0), {}, 0.0}};
  made.scene.finish_of = {0, 0, 1, 1};
  made.scene.temperature_k = {kMirror, kMirror, kWarm, kWarm};
  made.scene.ground = {2, kSky};
  const Camera from = camera({.position = {0.3, -5, 4}, .look_at = {0, 12, 0}}, 240, 180, 0.0015);
  Renderer renderer(made.scene, {mwir()}, {.points = 1, .view_rays = 256, .layers = {.facet = true}});
  const RenderedFrame frame = renderer.render(from);
  // Paint that emits in its own colours and reflects what is as cold as the sky, seen in a grey mirror.
  const auto of_paint = [&](const std::vector<double>& weight) {
    const BandNodes nodes = band_nodes(mwir().curves, std::vector{coloured()});
    const std::vector<double> eps = at_nodes(nodes, coloured()), warm = blackbody_at(nodes, kWarm),
                              cold = blackbody_at(nodes, kSky);
    std::vector<double> sum(nodes.size());
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] = weight[0] * (eps[k] * warm[k] + (1.0 - eps[k]) * cold[k]);
    return integral(nodes, sum);
  };
  const double warm = 0.1 * blackbody(mwir(), kMirror) + of_paint({0.9}),
               cold = 0.1 * blackbody(mwir(), kMirror) + 0.9 * blackbody(mwir(), kSky);
  EXPECT_GT(warm, 3.0 * cold);
  int shown = 0, wrong = 0;
  for (std::int64_t y = 0; y < from.height; ++y)
    for (std::int64_t x = 0; x < from.width; ++x) {
      const Vector d = from.direction(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
      if (frame.layers[0].plane.at(x, y) != 0.0F) continue;
      // In the mirror world the plate stands from z = -1 to -3, at y = 20.
      const double t = 25.0 / d[1];
      const double across = 0.3 + t * d[0], height = -(4.0 + t * d[2]);
      const bool plate = std::abs(across) < 1.5 && height > 1.0 && height < 3.0;
      // Within 1e-4 m of an edge single precision decides.
      if (std::min({std::abs(std::abs(across) - 1.5), std::abs(height - 1.0), std::abs(height - 3.0)}) < 1e-4) continue;
      const auto value = static_cast<double>(frame.radiance[0].at(x, y));
      shown += plate ? 1 : 0;
      // The mirror is as cold as the sky, so that the paint reflects their light alone, but for its own in the mirror.
      if (std::abs(value / (plate ? warm : cold) - 1.0) > (plate ? 1e-3 : 1e-5)) ++wrong;
    }
  EXPECT_GT(shown, 500);
  EXPECT_EQ(wrong, 0);
}

/// A level mirror under layered air shows the sky of the elevation that it is seen at, through the air before it.
TEST(Angles, AMirrorShowsTheSkyOfItsElevation) {
  constexpr double kMirror = 285.0;
  scene::Mesh mesh = empty_mesh();
  add_plate(mesh, {-300, -10, 0}, {600, 0, 0}, {0, 400, 0});
  SmallScene made = small_scene(mesh, kMirror, coloured(), 280.0);
  made.scene.finish[0].gloss = 1.0;
  made.scene.sky.cloud_cover = 0.2, made.scene.sky.cloud_k = 275.0;
  made.scene.air = air::Air<double>{.profile = air::model_profile(air::ModelAtmosphere::mid_latitude_summer)};
  const Camera from = camera({.position = {0, -20, 8}, .look_at = {0, 8, 0}}, 9, 61, 0.008);
  Renderer renderer(made.scene, {lwir()}, {.points = 1, .layers = {.range = true, .facet = true}});
  const RenderedFrame frame = renderer.render(from);
  const std::vector<Spectrum> curves{coloured()};
  const BandNodes nodes = band_nodes(lwir().curves, curves);
  const std::vector<double> eps = at_nodes(nodes, coloured()), own = blackbody_at(nodes, kMirror);
  const AirView ground(*made.scene.air, nodes, 0.0, 0.0), before(*made.scene.air, nodes, 0.0, 8.0, 300.0);
  const std::vector<double> of_air = fold(nodes, blackbody_at(nodes, before.reference_k()));
  int seen = 0;
  for (std::int64_t y = 0; y < from.height; y += 5) {
    if (frame.layers[1].plane.at(4, y) != 0.0F) continue;
    const Vector d = from.direction(4.5, static_cast<double>(y) + 0.5);
    const std::vector<double> sky = sky_at(made.scene.sky, nodes, &ground, std::acos(-d[2] / scene::length(d)));
    std::vector<double> light(nodes.size());
    for (std::size_t k = 0; k < light.size(); ++k) light[k] = eps[k] * own[k] + (1.0 - eps[k]) * sky[k];
    const std::vector<double> folded = fold(nodes, light);
    const AirSamples air = before.to(static_cast<double>(frame.layers[0].plane.at(4, y)), 0.0);
    double wanted = 0.0;
    for (std::size_t s = 0; s < folded.size(); ++s)
      wanted += air.transmission[s] * folded[s] + air.source[s] * of_air[s];
    // Cubics between 33 elevations: worst near the horizon.
    EXPECT_NEAR(static_cast<double>(frame.radiance[0].at(4, y)) / wanted, 1.0, 1e-4) << y;
    ++seen;
  }
  EXPECT_GT(seen, 6);
}

/// A finish that says nothing new makes the same picture.
TEST(Angles, WithoutEffectChangeNothing) {
  scene::Mesh mesh = empty_mesh();
  add_plate(mesh, {-20, -20, 0}, {40, 0, 0}, {0, 40, 0}, 4, 4);
  add_box(mesh, {-1, -1, 0.5}, {2, 2, 2}, 2);
  const auto frame_of = [&](const AngularEmissivity& curve) {
    SmallScene made = small_scene(mesh, 300.0, coloured(), 260.0);
    for (std::size_t s = 0; s < made.scene.temperature_k.size(); ++s)
      made.scene.temperature_k[s] += static_cast<float>(s % 7);
    made.scene.finish[0].by_angle = curve;
    made.scene.sun = Sun{{0.5, -0.3, 0.8}, 800.0};
    made.scene.air = air::Air<double>{.profile = air::model_profile(air::ModelAtmosphere::mid_latitude_summer)};
    Renderer renderer(made.scene, {mwir()}, {.layers = {.surface = true, .transmittance = true}});
    return renderer.render(camera({.position = {9, -30, 8}, .look_at = {0, 0, 0.5}}, 80, 60, 0.01));
  };
  const RenderedFrame plain = frame_of({}), same = frame_of(angle_table(std::vector{0.0, 90.0}, std::vector{1.0, 1.0}));
  double most = 0.0, layer = 0.0;
  for (std::int64_t i = 0; i < plain.radiance[0].size(); ++i) {
    const auto a = static_cast<double>(plain.radiance[0].data()[i]),
               b = static_cast<double>(same.radiance[0].data()[i]);
    most = std::max(most, std::abs(b / a - 1.0));
    layer = std::max(layer,
                     static_cast<double>(std::abs(
                         plain.layers[0].plane.data()[i] / std::max(1e-30F, same.layers[0].plane.data()[i]) - 1.0F)) *
                         (plain.layers[0].plane.data()[i] > 0.0F ? 1.0 : 0.0));
  }
  EXPECT_LT(most, 2e-6);  // sums in single against double precision
  EXPECT_LT(layer, 2e-6);
}

}  // namespace
}  // namespace radiometry::render::test
