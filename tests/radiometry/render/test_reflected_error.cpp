// SPDX-License-Identifier: Apache-2.0
// The light that surfaces reflect is told by rays: what they err by is stated, and is smaller than a camera's noise.

#include <gtest/gtest.h>

#include "radiometry/render/renderer.h"
#include "render_cases.h"

namespace radiometry::render::test {
namespace {

constexpr double kPlate_k = 300.0, kSoil_k = 320.0;

/// A wall of small facets above warm soil, both of one temperature each: its image is smooth.
SmallScene wall(double emissivity) {
  scene::Mesh mesh = empty_mesh();
  add_plate(mesh, {-1, 0, 0.2}, {2, 0, 0}, {0, 0, 2}, 12, 12);
  add_plate(mesh, {-6, -6, 0}, {12, 0, 0}, {0, 12, 0});
  SmallScene made = small_scene(mesh, kPlate_k, grey(emissivity), 265.0);
  for (std::size_t side = 2 * 144; side < 2 * 145; ++side) made.scene.temperature_k[side] = kSoil_k;
  return made;
}

RenderedFrame seen(const SmallScene& made, const RenderOptions& options) {
  Renderer renderer(made.scene, {lwir()}, options);
  return renderer.render(camera({.position = {0, -10, 1.2}, .look_at = {0, 0, 1.2}}, 48, 48, 0.004));
}

double per_k() { return blackbody(lwir(), 300.5) - blackbody(lwir(), 299.5); }

double rms_k(const mtf::Image& a, const mtf::Image& b) {
  double sum = 0.0;
  for (std::int64_t i = 0; i < a.size(); ++i) {
    const double difference = static_cast<double>(a.data()[i]) - static_cast<double>(b.data()[i]);
    sum += difference * difference;
  }
  return std::sqrt(sum / static_cast<double>(a.size())) / per_k();
}

// Against sixteen thousand rays a side.
TEST(ReflectedLight, ErrorIsStatedAndBelowHalfOfTheNoise) {
  for (const double emissivity : {0.9, 0.6}) {
    const SmallScene made = wall(emissivity);
    const RenderedFrame truth = seen(made, {.view_rays = 16384, .most_view_rays = 16384}),
                        coarse = seen(made, {.most_view_rays = 64}), usual = seen(made, {});
    const double off = rms_k(coarse.radiance[0], truth.radiance[0]);
    EXPECT_EQ(coarse.view_rays, 64);
    EXPECT_GT(off, 0.03);
    EXPECT_NEAR(coarse.reflected_k[0] / off, 1.0, 0.3);
    const double left = rms_k(usual.radiance[0], truth.radiance[0]);
    EXPECT_GT(usual.view_rays, 64);
    EXPECT_LT(left, 0.5 * lwir().noise_k);
    EXPECT_LT(usual.reflected_k[0], 0.5 * lwir().noise_k);
    EXPECT_NEAR(usual.reflected_k[0] / left, 1.0, 0.4);
  }
}

TEST(ReflectedLight, NothingThatReflectsHasNoError) {
  const RenderedFrame frame = seen(wall(1.0), {});
  EXPECT_EQ(frame.view_rays, 64);
  EXPECT_EQ(frame.reflected_k[0], 0.0);
}

}  // namespace
}  // namespace radiometry::render::test
