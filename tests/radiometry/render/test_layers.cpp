// SPDX-License-Identifier: Apache-2.0
// Pictures from layers against pictures of facets: what the renderer says of a scene in layers gives its radiance
// again.

#include "radiometry/render/layers/layer_picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

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

/// A board in the air, tilted, that sees sky and ground alone, from afar: its own rounding must not shade it. It leans
/// back along `up`. Layers are those that the renderer writes.
Made made_with(bool with_air, bool sun, const Finish& finish = {"paint", coloured()}, const Vector& up = {0, 3, 4}) {
  scene::Mesh mesh = empty_mesh();
  add_plate(mesh, {-3, 0, 5}, {6, 0, 0}, up, 6, 4);
  SmallScene made = small_scene(mesh, 300.0, coloured(), 270.0);
  made.scene.finish[0] = finish;
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

void expect_the_facets(const Made& made, const LayerFrame& frame, const std::string& what) {
  for (std::size_t b = 0; b < 2; ++b) {
    double worst = 0.0, beside = 0.0;
    for (std::int64_t i = 0; i < frame.radiance[b].size(); ++i) {
      const auto wanted = static_cast<double>(made.frame.radiance[b].data()[i]);
      double& error = made.layers.finish.data()[i] < 0.0F ? beside : worst;
      error = std::max(error, std::abs(static_cast<double>(frame.radiance[b].data()[i]) / wanted - 1.0));
    }
    // Two sets of tables, each within its promise.
    EXPECT_LT(worst, made.frame.promised[b] + frame.promised[b] + 2e-6) << what << b;
    // The ground is as low as the lowest pixel, which is a little higher than the lowest vertex.
    EXPECT_LT(beside, 1e-3) << what << b;
  }
}

TEST(Layers, GiveTheRadianceOfTheFacetsThatTheyAreOf) {
  for (const bool with_air : {false, true})
    for (const bool sun : {false, true}) {
      const Made made = made_with(with_air, sun);
      const LayerFrame frame = render_layers(made.scene.scene, std::vector{mwir(), lwir()}, made.camera, made.layers);
      EXPECT_GT(frame.surfaces, 1500u);
      EXPECT_EQ(frame.mirrors + frame.as_matt + frame.unlit, 0u);
      expect_the_facets(made, frame, std::to_string(with_air) + std::to_string(sun));
    }
}

const std::vector<Finish>& finishes_with_angles() {
  static const std::vector<Finish> all{{"paint", coloured(), schlick(5.0), 0.0},
                                       {"steel", coloured(), {}, 1.0},
                                       {"glass", coloured(), dielectric(1.5), 0.6}};
  return all;
}

/// Boards that mirror the sky high up, the sky near the horizon at a grazing angle, and the ground.
TEST(Layers, HaveTheGlossAndTheEmissivityOfTheirAngle) {
  for (const Vector& up : {Vector{0, 3, 4}, {0, 6, 0.5}, {0, -3, 4}})
    for (const Finish& finish : finishes_with_angles())
      for (const bool with_air : {false, true})
        for (const bool sun : {false, true}) {
          const Made made = made_with(with_air, sun, finish, up);
          const LayerFrame frame =
              render_layers(made.scene.scene, std::vector{mwir(), lwir()}, made.camera, made.layers);
          EXPECT_GT(frame.surfaces, 300u);
          EXPECT_EQ(frame.mirrors, finish.gloss > 0.0 ? frame.surfaces : 0u);
          EXPECT_EQ(frame.as_matt, 0u);
          expect_the_facets(made, frame, finish.name + std::to_string(with_air) + std::to_string(sun));
        }
}

/// A grey mirror shows the sky above it or the ground below it, by a formula without tables.
TEST(Layers, MirrorWhatLiesWhereTheirNormalsSay) {
  Made made = made_with(false, true, {"mirror", grey(0.2), {}, 1.0}, {0, 3, 4});
  made.scene.scene.finish.push_back({"soil", grey(1.0)});
  made.scene.scene.ground = {1, 310.0};
  const auto middle_with = [&](float y, float z) {
    for (std::int64_t i = 0; i < made.layers.finish.size(); ++i)
      made.layers.normal[0].data()[i] = 0.0F, made.layers.normal[1].data()[i] = y, made.layers.normal[2].data()[i] = z;
    const LayerFrame frame = render_layers(made.scene.scene, std::vector{lwir()}, made.camera, made.layers);
    return static_cast<double>(frame.radiance[0].at(48, 36));
  };
  const double own = 0.2 * blackbody(lwir(), static_cast<double>(made.layers.temperature_k.at(48, 36)));
  // A mirror shows the sun only as a point, so that none of it is here.
  EXPECT_NEAR(middle_with(-1.0F, 1.0F) / (own + 0.8 * blackbody(lwir(), 270.0)), 1.0, 1e-5);
  EXPECT_NEAR(middle_with(-1.0F, -1.0F) / (own + 0.8 * blackbody(lwir(), 310.0)), 1.0, 1e-5);
}

/// Without normals no angle is known: a matt finish with the mean of the emissivity over the hemisphere, and how often.
TEST(Layers, AreMattAndMeansWithoutNormals) {
  for (const Finish& finish : finishes_with_angles()) {
    Made made = made_with(true, true, finish);
    made.layers.normal.clear();
    const std::vector bands{mwir(), lwir()};
    const LayerFrame frame = render_layers(made.scene.scene, bands, made.camera, made.layers);
    EXPECT_EQ(frame.as_matt, frame.surfaces);
    EXPECT_EQ(frame.unlit, frame.surfaces);
    EXPECT_EQ(frame.mirrors, 0u);
    Finish& matt = made.scene.scene.finish[0];
    for (double& value : matt.emissivity.value) value *= hemispherical_mean(finish.by_angle);
    matt.by_angle = {}, matt.gloss = 0.0;
    const LayerFrame wanted = render_layers(made.scene.scene, bands, made.camera, made.layers);
    EXPECT_EQ(wanted.as_matt, 0u);
    for (std::size_t b = 0; b < 2; ++b)
      for (std::int64_t i = 0; i < frame.radiance[b].size(); ++i)
        ASSERT_NEAR(frame.radiance[b].data()[i] / wanted.radiance[b].data()[i], 1.0F, 2e-6F) << finish.name << b;
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
  refused([](Made& made) { made.scene.scene.finish[0].gloss = 1.5; });
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
