// SPDX-License-Identifier: Apache-2.0
// Pictures whose radiance is known: rooms of one temperature, silhouettes, shadows, mirrors of rounding.

#include "radiometry/render/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "mtf/error.h"
#include "radiometry/light/constants.h"
#include "render_cases.h"

namespace radiometry::render::test {
namespace {

using scene::operator-, scene::operator+, scene::operator*;
using scene::dot;
namespace air = radiometry::atmosphere;

double mean_of(const mtf::Image& image) {
  double sum = 0.0;
  for (std::int64_t i = 0; i < image.size(); ++i) sum += static_cast<double>(image.data()[i]);
  return sum / static_cast<double>(image.size());
}

/// A room that faces inwards, with a box and a sphere in it.
scene::Mesh room() {
  scene::Mesh mesh = empty_mesh();
  add_box(mesh, {-4, -3, 0}, {8, 6, 3}, 4, -1);
  add_box(mesh, {-1, -1, 0.01}, {1, 1.5, 1}, 2);
  return mesh;
}

TEST(Renderer, ARoomOfOneTemperatureIsBlackWhateverItsEmissivity) {
  constexpr double kKelvin = 300.0;
  air::Profile<double> layered = air::model_profile(air::ModelAtmosphere::us_standard_1976);
  for (auto& level : layered.levels) level.temperature_k = kKelvin;
  const std::vector<air::Air<double>> airs{{.profile = air::surface_air(101325.0, kKelvin, 50.0)},
                                           {.profile = layered}};
  for (const Spectrum& emissivity : {grey(0.05), grey(0.5), coloured(), grey(1.0)})
    for (std::size_t a = 0; a < 3; ++a) {
      SmallScene made = small_scene(room(), kKelvin, emissivity, kKelvin);
      if (a > 0) made.scene.air = airs[a - 1];
      Renderer renderer(made.scene, {mwir(), lwir()}, {.view_rays = 16});
      const RenderedFrame frame =
          renderer.render(camera({.position = {3.5, 2.5, 2.5}, .look_at = {-1, 0, 0.5}}, 40, 30, 0.03));
      for (std::size_t b = 0; b < 2; ++b) {
        const double black = blackbody(b == 0 ? mwir() : lwir(), kKelvin);
        const mtf::Image& image = frame.radiance[b];
        for (std::int64_t i = 0; i < image.size(); ++i)
          ASSERT_NEAR(static_cast<double>(image.data()[i]) / black, 1.0, 1e-6) << emissivity.source << " " << a;
      }
    }
}

double polygon_area(std::vector<std::array<double, 2>> points) {
  // Convex hull (Andrew), then the shoelace formula.
  std::sort(points.begin(), points.end());
  const auto turn = [](const auto& o, const auto& a, const auto& b) {
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
  };
  std::vector<std::array<double, 2>> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = hull.size();
    for (const auto& p : points) {
      while (hull.size() >= start + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0.0) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  double area = 0.0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const auto &a = hull[i], &b = hull[(i + 1) % hull.size()];
    area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
  }
  return std::abs(area);
}

/// Where a point is in the image, in samples.
std::array<double, 2> projected(const Camera& eye, const Point& point) {
  const Vector d = point - eye.position;
  const double depth = dot(d, eye.ahead);
  return {eye.axis_x + dot(d, eye.right) / depth / eye.step_x, eye.axis_y + dot(d, eye.down) / depth / eye.step_y};
}

/// The mean of a picture of a convex body before a uniform background, from the area of its silhouette.
void expect_silhouette(const scene::Mesh& mesh, const Camera& eye, double least_area) {
  SmallScene made = small_scene(mesh, 310.0, grey(1.0), 280.0);
  made.scene.ground.temperature_k = 280.0;
  Renderer renderer(made.scene, {lwir()}, {.points = 4});
  const RenderedFrame frame = renderer.render(eye);
  std::vector<std::array<double, 2>> points;
  for (const Point& vertex : mesh.vertices) points.push_back(projected(eye, vertex));
  const double area = polygon_area(points), all = static_cast<double>(eye.width * eye.height);
  ASSERT_GT(area, least_area);
  const double warm = blackbody(lwir(), 310.0), cold = blackbody(lwir(), 280.0);
  const double expected = cold + (warm - cold) * area / all;
  EXPECT_NEAR(mean_of(frame.radiance[0]) / expected, 1.0, 1e-4);
  EXPECT_NEAR(mean_of(frame.radiance[0]) / expected, 1.0, 2e-5);
}

TEST(Renderer, ASphereHasTheRadianceOfItsSilhouette) {
  const scene::Mesh ball = scene::test::sphere({0.02, 0.01, 1.03}, 1.0, 40);
  const Camera eye = camera({.position = {0, -10, 1}, .look_at = {0, 0, 1}}, 260, 250, 0.001);
  expect_silhouette(ball, eye, std::numbers::pi * 98.0 * 98.0);
}

TEST(Renderer, ATiltedPlateHasTheRadianceOfItsSilhouette) {
  scene::Mesh plate = empty_mesh();
  add_plate(plate, {-0.9, -0.5, 0.3}, {1.7, 0.4, 0.1}, {-0.2, 0.8, 1.1}, 3, 3);
  const Camera eye = camera({.position = {0.3, -10, 1}, .look_at = {0, 0, 1}}, 260, 250, 0.001);
  expect_silhouette(plate, eye, 10000.0);
}

TEST(Renderer, SamplesAreMeansOfTheirPoints) {
  const scene::Mesh ball = scene::test::sphere({0, 0, 1}, 1.0, 40);
  SmallScene made = small_scene(ball, 310.0, grey(1.0), 280.0);
  const Camera eye = camera({.position = {0, -10, 1}, .look_at = {0, 0, 1}}, 260, 250, 0.001);
  const RenderedFrame points = Renderer(made.scene, {lwir()}, {.points = 1}).render(eye);
  const RenderedFrame means = Renderer(made.scene, {lwir()}, {.points = 4}).render(eye);
  EXPECT_EQ(points.divided, 0u);
  const double warm = blackbody(lwir(), 310.0), cold = blackbody(lwir(), 280.0);
  std::size_t between = 0;
  for (std::int64_t i = 0; i < 260 * 250; ++i) {
    const double whole = (static_cast<double>(points.radiance[0].data()[i]) - cold) / (warm - cold);
    const double sixteenths = 16.0 * (static_cast<double>(means.radiance[0].data()[i]) - cold) / (warm - cold);
    ASSERT_NEAR(whole, std::round(whole), 1e-5);
    ASSERT_NEAR(sixteenths, std::round(sixteenths), 1e-4);
    if (sixteenths > 0.5 && sixteenths < 15.5) ++between;
  }
  EXPECT_GT(between, 500u);
  EXPECT_LT(between, means.divided);  // and samples that show several facets of the ball
}

TEST(Renderer, ShadowsEndWhereTheyShould) {
  scene::Mesh mesh = empty_mesh();
  add_plate(mesh, {-10, -10, 0}, {20, 0, 0}, {0, 20, 0});
  add_plate(mesh, {-1, -1, 2}, {2, 0, 0}, {0, 2, 0});
  SmallScene made = small_scene(mesh, 300.0, grey(0.5), 300.0);
  made.scene.sun = Sun{.to_sun = {0.5, 0.25, 1.0}, .direct_w_m2 = 900.0};
  Renderer renderer(made.scene, {mwir()}, {.points = 1, .view_rays = 256, .layers = {.facet = true}});
  const Camera eye = camera({.position = {0.1, -9, 12}, .look_at = {-0.8, -0.4, 0}}, 200, 200, 0.002);
  const RenderedFrame frame = renderer.render(eye);
  // What the sun adds: (1 - eps) E cos / pi, E by Planck's law at 5772 K.
  const Vector to_sun = (1.0 / scene::length(made.scene.sun->to_sun)) * made.scene.sun->to_sun;
  const double sun = 0.5 * 900.0 * to_sun[2] / std::numbers::pi * blackbody(mwir(), kSun_k) /
                     (kStefanBoltzmann_w_m2_k4 * std::pow(kSun_k, 4) / std::numbers::pi);
  std::size_t dark = 0, lit = 0;
  double dark_sum = 0.0, lit_sum = 0.0;
  for (std::int64_t y = 0; y < eye.height; ++y)
    for (std::int64_t x = 0; x < eye.width; ++x) {
      if (frame.layers[0].plane.at(x, y) != 0.0F) continue;  // the plate
      const Vector d = eye.direction(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
      const Point p = eye.position + (-eye.position[2] / d[2]) * d;
      // The ray to the sun meets the height of the plate there:
      const double u = std::abs(p[0] + 2.0 * 0.5), v = std::abs(p[1] + 2.0 * 0.25);
      const double outside = std::max(u, v) - 1.0;
      if (std::abs(outside) < 2e-4) continue;  // single precision at 20 m
      const auto value = static_cast<double>(frame.radiance[0].at(x, y));
      (outside > 0.0 ? lit : dark)++;
      (outside > 0.0 ? lit_sum : dark_sum) += value;
      const double level = 0.5 * sun + 1.0 * blackbody(mwir(), 300.0);
      ASSERT_EQ(value > level, outside > 0.0) << x << " " << y << " " << outside;
    }
  ASSERT_GT(dark, 1000u);
  ASSERT_GT(lit, 1000u);
  EXPECT_NEAR((lit_sum / static_cast<double>(lit) - dark_sum / static_cast<double>(dark)) / sun, 1.0, 1e-4);
}

TEST(Renderer, ReflectsWhatASideSees) {
  // A level plate under a sky of 250 K sees it alone: L = eps B(T) + (1 - eps) B(sky).
  scene::Mesh mesh = empty_mesh();
  add_plate(mesh, {-5, -5, 0}, {10, 0, 0}, {0, 10, 0});
  SmallScene made = small_scene(mesh, 300.0, coloured(), 250.0);
  for (const RenderBand& band : {mwir(), lwir()}) {
    Renderer renderer(made.scene, {band}, {.points = 1});
    const RenderedFrame frame = renderer.render(camera({.position = {0, 0, 6}, .look_at = {0, 0.1, 0}}, 16, 16, 0.01));
    const double expected =
        scene_radiance(band.curves,
                       {.temperature_k = 300.0,
                        .emissivity = make_spectrum("c", coloured().wavelength_um, coloured().value),
                        .surroundings_k = 250.0},
                       {});
    EXPECT_NEAR(static_cast<double>(frame.radiance[0].at(8, 8)) / expected, 1.0, 1e-6);
  }
}

TEST(Renderer, PicturesDoNotDependOnThreadsOrOnWhatWasSeenBefore) {
  SmallScene made = small_scene(room(), 300.0, grey(0.7), 260.0);
  for (std::size_t s = 0; s < made.scene.temperature_k.size(); ++s)
    made.scene.temperature_k[s] = 280.0F + 3.0F * static_cast<float>(s % 17);
  made.scene.air = air::Air<double>{.profile = air::model_profile(air::ModelAtmosphere::us_standard_1976)};
  const Camera here = camera({.position = {3.5, 2.5, 2.5}, .look_at = {-1, 0, 0.5}}, 64, 48, 0.02);
  const Camera there = camera({.position = {-3.5, 2.0, 2.5}, .look_at = {1, 0, 0.5}}, 64, 48, 0.02);
  Renderer one(made.scene, {lwir()}, {.threads = 1}), two(made.scene, {lwir()}, {.threads = 2});
  const RenderedFrame first = one.render(here), second = two.render(here);
  one.render(there);
  const RenderedFrame again = one.render(here);
  EXPECT_EQ(again.shaded, 0u);
  for (std::int64_t i = 0; i < 64 * 48; ++i) {
    ASSERT_EQ(first.radiance[0].data()[i], second.radiance[0].data()[i]);
    ASSERT_NEAR(first.radiance[0].data()[i] / again.radiance[0].data()[i], 1.0F, 2e-5F);
  }
  // Light of a side does not depend on what else is seen: a camera that saw other sides before.
  Renderer other(made.scene, {lwir()}, {.threads = 1});
  other.render(there);
  const RenderedFrame late = other.render(here);
  for (std::int64_t i = 0; i < 64 * 48; ++i)
    ASSERT_NEAR(first.radiance[0].data()[i] / late.radiance[0].data()[i], 1.0F, 2e-5F);
}

TEST(Renderer, LayersSayWhatIsSeen) {
  scene::Mesh mesh = empty_mesh();
  add_plate(mesh, {-5, -5, 0}, {10, 0, 0}, {0, 10, 0});
  add_plate(mesh, {-1, -1, 2}, {2, 0, 0}, {0, 2, 0});
  SmallScene made = small_scene(mesh, 300.0, grey(0.8), 260.0);
  made.scene.temperature_k[2] = 320.0F;
  made.scene.air = air::Air<double>{.profile = air::surface_air(101325.0, 280.0, 50.0)};
  const Camera eye = camera({.position = {0, 0, 12}, .look_at = {0, 0.001, 0}}, 64, 64, 0.03);
  Renderer renderer(made.scene, {lwir()}, {.points = 1, .layers = {true, true, true, true, true, true, true, true}});
  const RenderedFrame frame = renderer.render(eye);
  const auto layer = [&](const std::string& name, std::int64_t x, std::int64_t y) {
    for (const NamedLayer& one : frame.layers)
      if (one.name == name) return static_cast<double>(one.plane.at(x, y));
    ADD_FAILURE() << name;
    return 0.0;
  };
  EXPECT_EQ(layer("temperature", 32, 32), 320.0);
  EXPECT_NEAR(layer("emissivity", 32, 32), 0.8, 1e-6);
  EXPECT_NEAR(layer("Z", 32, 32), 10.0, 3e-3);
  EXPECT_EQ(layer("facet", 32, 32), 1.0);
  EXPECT_EQ(layer("facet", 32, 23), 0.0);
  EXPECT_EQ(layer("facet", 0, 0), -1.0);
  EXPECT_TRUE(std::isnan(layer("temperature", 0, 0)));
  EXPECT_EQ(layer("normal.Z", 32, 32), 1.0);
  const double surface = layer("surface", 32, 32), tau = layer("transmittance", 32, 32);
  EXPECT_GT(tau, 0.9);
  EXPECT_LT(tau, 0.999);
  EXPECT_NEAR(surface, 0.8 * blackbody(lwir(), 320.0) + 0.2 * blackbody(lwir(), 260.0), 1e-5 * surface);
}

/// Of the ground beyond the facets against the air's transmission at the place that a ray meets, weighted with the
/// light of the ground; of the sky it is 0.
TEST(Renderer, TransmittanceOfTheGroundIsThatOfItsRange) {
  scene::Mesh mesh = empty_mesh();
  add_plate(mesh, {-40, -10, 0}, {20, 0, 0}, {0, 20, 0});
  SmallScene made = small_scene(mesh, 300.0, grey(1.0), 285.0);
  made.scene.air =
      atmosphere::Air<double>{.profile = atmosphere::model_profile(atmosphere::ModelAtmosphere::mid_latitude_summer)};
  const Camera from = camera({.position = {0, -200, 50}, .look_at = {0, 0, 20}}, 65, 65, 0.01);
  Renderer renderer(made.scene, {lwir()}, {.points = 1, .layers = {.range = true, .transmittance = true}});
  const RenderedFrame frame = renderer.render(from);
  const mtf::Image &z = frame.layers[0].plane, &tau = frame.layers[1].plane;
  EXPECT_EQ(tau.at(32, 0), 0.0F);
  const std::vector<Spectrum> curves{grey(1.0)};
  const BandNodes nodes = band_nodes(lwir().curves, curves);
  const std::vector<double> ground = fold(nodes, blackbody_at(nodes, 285.0));
  const AirView view(*made.scene.air, nodes, 0.0, 50.0, 300.0);
  for (const std::int64_t y : {25, 40, 64}) {
    const auto range_m = static_cast<double>(z.at(32, y));
    const Vector d = from.direction(32.5, static_cast<double>(y) + 0.5);
    EXPECT_NEAR(range_m, 50.0 * scene::length(d) / -d[2], 1e-5 * range_m);
    const AirSamples air = view.to(range_m, 0.0);
    double through = 0.0, all = 0.0;
    for (std::size_t s = 0; s < ground.size(); ++s) through += air.transmission[s] * ground[s], all += ground[s];
    // 1e-3: cubics of the elevation between 33 angles, near the horizon.
    EXPECT_NEAR(static_cast<double>(tau.at(32, y)), through / all, 5e-5) << range_m;  // cubics between 33 elevations
    EXPECT_LT(through / all, 0.99);
  }
}

/// Beside a plate that is seen straight down from 300 km, and from farther, is the ground: at the height over the
/// cosine and, without air, a blackbody.
TEST(Renderer, TheGroundIsSeenFromSpace) {
  scene::Mesh mesh = empty_mesh();
  add_plate(mesh, {-500, -500, 0}, {1000, 0, 0}, {0, 1000, 0});
  SmallScene made = small_scene(mesh, 300.0, grey(1.0), 285.0);
  Renderer renderer(made.scene, {lwir()}, {.points = 1, .layers = {.range = true}});
  for (const double height_m : {3e5, 9e5}) {
    const Camera from = camera({.position = {0, 0, height_m}, .look_at = {0, 1, 0}}, 33, 33, 1e-3);
    const RenderedFrame frame = renderer.render(from);
    const Vector d = from.direction(0.5, 0.5);
    EXPECT_NEAR(frame.layers[0].plane.at(0, 0), height_m * scene::length(d) / -d[2], 1e-6 * height_m);
    EXPECT_NEAR(frame.radiance[0].at(0, 0), blackbody(lwir(), 285.0), 1e-6 * blackbody(lwir(), 285.0));
  }
}

TEST(Renderer, RefusesCamerasThatSeeNothingOrStandInASolid) {
  scene::Mesh mesh = empty_mesh();
  add_box(mesh, {-1, -1, 0}, {2, 2, 2});
  SmallScene made = small_scene(mesh, 300.0, grey(0.8), 260.0, scene::Winding::outward);
  for (std::size_t s = 1; s < made.scene.temperature_k.size(); s += 2) made.scene.temperature_k[s] = NAN;
  Renderer renderer(made.scene, {lwir()});
  EXPECT_THROW(renderer.render(camera({.position = {9, 0, 1}, .look_at = {19, 0, 1}}, 16, 16, 0.01)), mtf::UsageError);
  EXPECT_THROW(renderer.render(camera({.position = {0, 0, 1}, .look_at = {19, 0, 1}}, 16, 16, 0.01)), mtf::UsageError);
  EXPECT_NO_THROW(renderer.render(camera({.position = {9, 0, 1}, .look_at = {0, 0, 1}}, 16, 16, 0.01)));
  made.scene.temperature_k[0] = -3.0F;
  EXPECT_THROW(Renderer(made.scene, {lwir()}), mtf::UsageError);
}

}  // namespace
}  // namespace radiometry::render::test
