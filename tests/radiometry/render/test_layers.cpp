// SPDX-License-Identifier: Apache-2.0
// Pictures from layers against pictures of facets: what the renderer says of a scene in layers gives its radiance
// again.

#include "radiometry/render/layers/layer_picture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mtf/error.h"
#include "render_cases.h"

namespace radiometry::render::test {
namespace {

namespace air = radiometry::atmosphere;

struct Made {
  SmallScene scene;
  Camera camera;
  RenderedFrame frame;
  SurfaceLayers layers;
};

/// A board in the air, tilted, that sees sky and ground alone, from afar: its own rounding must not shade it. Layers
/// are those that the renderer writes.
Made made_with(bool with_air, bool sun) {
  scene::Mesh mesh = empty_mesh();
  add_plate(mesh, {-3, 0, 5}, {6, 0, 0}, {0, 3, 4}, 6, 4);
  SmallScene made = small_scene(mesh, 300.0, coloured(), 270.0);
  for (std::size_t s = 0; s < made.scene.temperature_k.size(); ++s)
    made.scene.temperature_k[s] += static_cast<float>(s % 17);
  if (with_air)
    made.scene.air = air::Air<double>{.profile = air::model_profile(air::ModelAtmosphere::mid_latitude_summer)};
  if (sun) made.scene.sun = Sun{{0.2, -0.7, 0.6}, 700.0};
  const Camera from = camera({.position = {2, -60, 9}, .look_at = {0, 0, 7}}, 96, 72, 0.0016);
  Renderer renderer(made.scene, {mwir(), lwir()},
                    {.points = 1, .layers = {.temperature = true, .range = true, .finish = true, .normal = true}});
  RenderedFrame frame = renderer.render(from);
  SurfaceLayers layers;
  for (const NamedLayer& layer : frame.layers) {
    mtf::Image copy(layer.plane.width(), layer.plane.height());
    std::copy_n(layer.plane.data(), copy.size(), copy.data());
    if (layer.name == "Z")
      layers.range_m = std::move(copy);
    else if (layer.name == "material")
      layers.finish = std::move(copy);
    else if (layer.name == "temperature")
      layers.temperature_k = std::move(copy);
    else
      layers.normal.push_back(std::move(copy));
  }
  return {std::move(made), from, std::move(frame), std::move(layers)};
}

TEST(Layers, GiveTheRadianceOfTheFacetsThatTheyAreOf) {
  for (const bool with_air : {false, true})
    for (const bool sun : {false, true}) {
      const Made made = made_with(with_air, sun);
      const LayerFrame frame = render_layers(made.scene.scene, std::vector{mwir(), lwir()}, made.camera, made.layers);
      EXPECT_GT(frame.surfaces, 1500u);
      for (std::size_t b = 0; b < 2; ++b) {
        double worst = 0.0, beside = 0.0;
        for (std::int64_t i = 0; i < frame.radiance[b].size(); ++i) {
          const auto wanted = static_cast<double>(made.frame.radiance[b].data()[i]);
          double& error = made.layers.finish.data()[i] < 0.0F ? beside : worst;
          error = std::max(error, std::abs(static_cast<double>(frame.radiance[b].data()[i]) / wanted - 1.0));
        }
        // Two sets of tables, each within its promise.
        EXPECT_LT(worst, made.frame.promised[b] + frame.promised[b] + 2e-6) << with_air << sun << b;
        // The ground is as low as the lowest pixel, which is a little higher than the lowest vertex.
        EXPECT_LT(beside, 1e-3) << with_air << sun << b;
      }
    }
}

TEST(Layers, DepthsBecomeRanges) {
  const Made made = made_with(false, false);
  mtf::Image depth(made.camera.width, made.camera.height);
  // Depths along the optical axis of a plane across it are all the same.
  for (std::int64_t i = 0; i < depth.size(); ++i) depth.data()[i] = 20.0F;
  ranges_of_depths(made.camera, depth);
  for (const auto& [x, y] : {std::pair{0, 0}, {48, 36}, {95, 10}}) {
    const double u = (x + 0.5 - 48.0) * 0.0016, v = (y + 0.5 - 36.0) * 0.0016;
    EXPECT_NEAR(static_cast<double>(depth.at(x, y)), 20.0 * std::sqrt(1.0 + u * u + v * v), 1e-5);
  }
}

TEST(Layers, RefuseWhatIsNoSurface) {
  const std::vector bands{lwir()};
  const auto refused = [&](const auto& change) {
    Made made = made_with(false, false);
    change(made);
    EXPECT_THROW(render_layers(made.scene.scene, bands, made.camera, made.layers), mtf::UsageError);
  };
  refused([](Made& made) { made.layers.finish.at(48, 36) = 7.0F; });
  refused([](Made& made) { made.layers.temperature_k.at(48, 36) = NAN; });
  refused([](Made& made) { made.layers.range_m.at(48, 36) = INFINITY; });
  refused([](Made& made) { made.layers.range_m = mtf::Image(3, 3); });
  for (const float share : {-0.01F, 1.01F, NAN})
    refused([share](Made& made) {
      made.layers.sunlit = mtf::Image(made.camera.width, made.camera.height);
      made.layers.sunlit->at(48, 36) = share;
    });
  refused([](Made& made) {
    for (std::int64_t i = 0; i < made.layers.finish.size(); ++i) made.layers.finish.data()[i] = -1.0F;
  });
}

}  // namespace
}  // namespace radiometry::render::test
