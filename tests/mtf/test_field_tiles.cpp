// SPDX-License-Identifier: Apache-2.0
// OTFs over the field in tiles: images against those of the modes of the whole image, which share neither transforms
// nor halos with them; against the definition where that is quick (test_field.cpp).
#include "mtf/engines/kept_scene.h"
#include "mtf/field/tile_modes.h"
#include "mtf/otf/taper.h"
#include "tests/expect_error.h"
#include "tests/mtf/field_systems.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

System<double> some_lens() {
  System<double> s = seidel(0.05, 0.3, 0.5, 0.2, 0.1);
  s.add(Stage::presample, footprint(15.0));
  s.add(Stage::presample, rc(6.0, 0));  // phase at the Nyquist frequency
  return s;
}

Plan compiled(const System<double>& s, const Image& scene, const SampleGrid& out, double ratio, Border border,
              double tolerance, Method method) {
  PlanOptions options = options_for(scene, border, tolerance, 0.3);
  options.method = method;
  return compile(s, scene_grid(s, scene.width(), scene.height(), ratio, ratio), out, options);
}

struct TileCase {
  std::int64_t width, height;
  double ratio;
  Border border;
  double tolerance;
};

/// Tiles and modes of the image err by no more than both promise.
void agrees(const TileCase& c) {
  const System<double> s = some_lens();
  const SampleGrid out{c.width, c.height, 15.0, 15.0};
  const Image scene = random_image(static_cast<std::int64_t>(static_cast<double>(c.width) * c.ratio),
                                   static_cast<std::int64_t>(static_cast<double>(c.height) * c.ratio), 3, 2.0);
  const Plan tiles = compiled(s, scene, out, c.ratio, c.border, c.tolerance, Method::field_tiles),
             modes = compiled(s, scene, out, c.ratio, c.border, 0.05 * c.tolerance, Method::field_modes);
  ASSERT_EQ(tiles.report().method, "field_tiles");
  EXPECT_LE(tiles.report().predicted.total(), c.tolerance);
  const Image exact = run(modes, scene, 0.3);
  const double realised = rms_distance(run(tiles, scene, 0.3), {exact.data(), exact.data() + exact.size()}) /
                          options_for(scene, c.border, 1e-3).scene->std;
  EXPECT_LE(realised, tiles.report().predicted.total() + modes.report().predicted.total()) << tiles.explain();
  // One that adds nothing, or adds it elsewhere, is far off.
  EXPECT_GT(modes.report().field.one_otf_error, 3.0 * c.tolerance);
  EXPECT_LT(realised, 0.5 * c.tolerance) << tiles.explain();
  std::printf("%s %g a pitch: realised %.1e, promised %.1e, wrap %.1e, modes %.1e; %s\n",
              std::string(kBorderNames[static_cast<std::size_t>(c.border)]).c_str(), c.ratio, realised,
              tiles.report().predicted.total(), tiles.report().predicted.wrap, tiles.report().predicted.modes,
              tiles.report().candidates.back().detail.c_str());
}

TEST(FieldTiles, AgreeWithModesOfTheWholeImage) {
  agrees({300, 200, 1.0, Border::reflect, 1e-2});
  agrees({264, 131, 1.0, Border::reflect, 1e-2});  // a prime side is interpolated to twice as many samples
  agrees({200, 160, 2.0, Border::constant, 4e-2});
}

class FieldTilesLong : public testing::TestWithParam<TileCase> {};
TEST_P(FieldTilesLong, AgreeWithModesOfTheWholeImage) { agrees(GetParam()); }
std::vector<TileCase> tile_cases() {
  std::vector<TileCase> cases;
  for (const Border border : kBorders) cases.push_back({301, 263, 2.0, border, 4e-2});
  for (const Border border : {Border::reflect, Border::periodic})
    for (const double ratio : {1.0, 1.5, 3.0}) cases.push_back({432, 300, ratio, border, 3e-3});
  return cases;
}
INSTANTIATE_TEST_SUITE_P(Sizes, FieldTilesLong, testing::ValuesIn(tile_cases()));

TEST(FieldTiles, UniformScenesThreadsAndKeptScenes) {
  const System<double> s = some_lens();
  const Image scene = random_image(300, 200, 5);
  const SampleGrid out{300, 200, 15.0, 15.0};
  const Plan plan = compiled(s, scene, out, 1.0, Border::reflect, 2e-2, Method::field_tiles);
  const Image plain = run(plan, scene, 0.0, 1);
  EXPECT_TRUE(same_bits(plain, run(plan, scene, 0.0, 2)));
  auto planes = std::make_shared<std::vector<Image>>();
  planes->push_back(scene.clone());
  KeptScene kept(planes);
  Image again(300, 200);
  const ImageView<float> view = again.view();
  for (int i = 0; i < 2; ++i) {
    plan.run(kept, std::span(&view, 1), 0.0, 1);
    EXPECT_TRUE(same_bits(again, plain));
  }
  Image own = scene.clone();
  plan.run(own.view(), own.view(), 0.0, 1);
  EXPECT_TRUE(same_bits(own, plain));
  const Image image = run(plan, image_of(300, 200, [](auto, auto) { return 3.25; }));
  for (std::int64_t i = 0; i < image.size(); ++i) ASSERT_EQ(image.data()[i], 3.25F);
}

// Where modes are many, and the image has room for several tiles, the quicker way is taken by itself.
TEST(FieldTiles, AreTakenWhereModesAreMany) {
  const System<double> s = some_lens();
  for (const std::int64_t height : {std::int64_t{270}, std::int64_t{120}}) {
    const Image scene = random_image(300, height, 5);
    PlanOptions options = options_for(scene, Border::reflect, 2e-3);
    const Plan plan = compile(s, scene_grid(s, 300, height, 1.0, 1.0), {300, height, 15.0, 15.0}, options);
    const std::vector<Candidate>& ways = plan.report().candidates;
    const auto way = [&](Method method) { return *std::ranges::find(ways, method, &Candidate::method); };
    const Candidate modes = way(Method::field_modes), tiles = way(Method::field_tiles);
    ASSERT_TRUE(modes.possible);
    const bool quicker = tiles.possible && tiles.cost_ms < modes.cost_ms;
    EXPECT_EQ(quicker, height == 270) << plan.explain();
    EXPECT_EQ(plan.report().method, quicker ? "field_tiles" : "field_modes");
    EXPECT_EQ((quicker ? modes : tiles).reason, quicker ? "takes longer"
                                                        : "planned for 12 modes and more of an image of several tiles, "
                                                          "or where asked for by name");
    EXPECT_EQ((quicker ? tiles : modes).reason, "");
  }
}

TEST(FieldTiles, ExplainShowsBothWays) {
  const System<double> s = some_lens();
  const Image scene = random_image(300, 200, 5);
  const Plan plan = compiled(s, scene, {300, 200, 15.0, 15.0}, 1.0, Border::reflect, 2e-2, Method::field_tiles);
  expect_says(plan.explain(), {"chosen    field_tiles: ", " modes a tile", "other     field_modes: the mean OTF and ",
                               "another was asked for", " a tile, from OTFs at"});
  // A pitch that is no ratio of small whole numbers of samples has no tiles of whole pixels.
  const SampleGrid in = scene_grid(s, 300, 200, 1.0, 1.0);
  PlanOptions options = options_for(scene, Border::reflect, 2e-2);
  options.method = Method::field_tiles;
  expect_refused({"method field_tiles: the pitch is not a ratio of small whole numbers of samples"}, [&] {
    compile(s, in, {200, 130, 15.0 * std::sqrt(2.0), 15.0}, options);
  });
}

TEST(FieldTiles, TheTaperIsOneInTheBandAndFallsSmoothly) {
  const Taper taper{.from_cy_mm = {10.0, 20.0}, .to_cy_mm = {12.5, 25.0}, .sharpness = 9.0};
  EXPECT_EQ(taper.factor(0, -10.0), 1.0);
  EXPECT_EQ(taper.factor(1, 25.0), 0.0);
  EXPECT_NEAR(taper.factor(0, 11.25), 0.5, 1e-12);  // the window is even
  for (double f = 10.0; f < 12.5; f += 0.01) EXPECT_GE(taper.factor(0, f), taper.factor(0, f + 0.01));
  EXPECT_NEAR(taper.factor(0, 11.0) + taper.factor(0, 11.5), 1.0, 1e-12);
}

}  // namespace
}  // namespace mtf::test
