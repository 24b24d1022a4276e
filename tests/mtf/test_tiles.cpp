// SPDX-License-Identifier: Apache-2.0
// Tiles: the same image as the exact reference and as the whole-image route, within the tolerance, for every border.
#include "mtf/tiles/tiles.h"

#include <cstdlib>
#include <limits>

#include "tests/expect_error.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

Image tiled(const TiledSensorPlan& plan, const Image& scene, double border_value, TileTally* tally = nullptr) {
  const ImageView<const float> view = scene.view();
  std::vector<Image> out = plan.run(std::span(&view, 1), border_value, tally);
  return std::move(out.front());
}

double rms_between(const Image& a, const Image& b) {
  double squares = 0.0;
  for (std::int64_t i = 0; i < a.size(); ++i) squares += std::pow(static_cast<double>(a.data()[i]) - b.data()[i], 2);
  return std::sqrt(squares / static_cast<double>(a.size()));
}

// Half dark, half bright, noise on both: what far tails carry matters.
Image two_halves(std::int64_t width, std::int64_t height) {
  Image scene = random_image(width, height, 11, 5.0, 0.3);
  for (std::int64_t y = 0; y < height; ++y)
    for (std::int64_t x = 0; x < width; ++x) scene.at(x, y) += 2 * x + y < width ? 0.0F : 3.0F;
  return scene;
}

TEST(Tiles, keep_the_promise_against_the_reference) {
  int cut = 0;
  for (const Border border : kBorders)
    for (const double ratio : {1.0, 2.0, 3.0, 3.7, 1.5})
      for (const double tolerance : {1e-2, 1e-4}) {
        const System<double> system = with(bare(), {gaussian(16.0), motion(4.0, 30.0)});
        const SampleGrid in = scene_grid(system, 51, 44, ratio, ratio);
        const Image scene = two_halves(in.width, in.height);
        const PlanOptions options = options_for(scene, border, tolerance, 2.0);
        const TiledSensorPlan plan = compile_tiled(system, in, options, {.threads = 1, .side = 5});
        cut += plan.report().whole ? 0 : 1;
        const Image out = tiled(plan, scene, 2.0);
        const auto expected = reference_image(scene, in, plan.out(), otf_of(system, Stage::presample), border, 2.0);
        EXPECT_LE(rms_distance(out, expected) / options.scene->std, plan.report().predicted_error)
            << kBorderNames[static_cast<std::size_t>(border)] << " " << ratio << " " << tolerance << " "
            << plan.report().reason;
        EXPECT_LE(plan.report().predicted_error, tolerance);
      }
  EXPECT_GT(cut, 24) << "too few of the cases are tiles at all";
}

TEST(Tiles, split_otf_equals_the_whole_image) {
  int split = 0;
  for (const Border border : kBorders)
    for (const bool filters : {false, true})
      for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
        System<double> system = mwir();
        if (filters) system.add(Stage::postsample, fir({{0, -0.25, 0}, {-0.25, 2.0, -0.25}, {0, -0.25, 0}}));
        const SampleGrid in{803, 710, 3.75, 3.75};
        const Image scene = two_halves(in.width, in.height);
        const PlanOptions options = options_for(scene, border, tolerance, 2.0);
        const TiledSensorPlan plan = compile_tiled(system, in, options, {.threads = 2, .side = 96});
        split += plan.report().every > 0 ? 1 : 0;
        const SensorPlan all = compile_sensor(system, in, options);
        const ImageView<const float> view = scene.view();
        const double rms = rms_between(tiled(plan, scene, 2.0), all.run(std::span(&view, 1), 2.0, 1).front());
        EXPECT_LE(rms / options.scene->std, plan.report().predicted_error + all.predicted_error)
            << kBorderNames[static_cast<std::size_t>(border)] << " " << tolerance << " " << plan.report().reason;
        EXPECT_LE(plan.report().predicted_error, tolerance);
      }
  EXPECT_GE(split, 8);
}

TEST(Tiles, a_region_is_that_part_of_the_whole_image) {
  const System<double> system = mwir();
  const SampleGrid in{900, 800, 3.75, 3.75};
  const Image scene = two_halves(in.width, in.height);
  const PlanOptions options = options_for(scene, Border::reflect, 1e-3);
  const SensorPlan all = compile_sensor(system, in, options);
  const ImageView<const float> view = scene.view();
  const Image expected = std::move(all.run(std::span(&view, 1), 0.0, 1).front());
  for (const Region region : {Region{0, 0, 1, 1}, Region{101, 67, 33, 20}, Region{200, 180, 25, 20}}) {
    const TiledSensorPlan plan = compile_tiled(system, in, options, {.threads = 1, .region = region});
    EXPECT_FALSE(plan.report().whole) << plan.report().reason;
    const Image out = tiled(plan, scene, 0.0);
    ASSERT_EQ(out.width(), region.width);
    for (std::int64_t y = 0; y < out.height(); ++y)
      for (std::int64_t x = 0; x < out.width(); ++x)
        EXPECT_NEAR(out.at(x, y), expected.at(region.x + x, region.y + y), 2e-3 * options.scene->std);
  }
  for (const Region region : {Region{-1, 0, 5, 5}, Region{220, 0, 6, 1}, Region{0, 0, 0, 4}})
    EXPECT_THROW(compile_tiled(system, in, options, {.region = region}), UsageError);
}

TEST(Tiles, same_bits_for_any_threads) {
  System<double> system = mwir();
  system.add(Stage::postsample, fir({{0, -0.25, 0}, {-0.25, 2.0, -0.25}, {0, -0.25, 0}}));
  const SampleGrid in{700, 640, 3.75, 3.75};
  const Image scene = two_halves(in.width, in.height);
  const PlanOptions options = options_for(scene, Border::replicate, 1e-3);
  const Image one = tiled(compile_tiled(system, in, options, {.threads = 1, .side = 40}), scene, 0.0);
  const Image four = tiled(compile_tiled(system, in, options, {.threads = 4, .side = 40}), scene, 0.0);
  EXPECT_TRUE(same_bits(one, four));
}

TEST(Tiles, flat_tiles_are_not_computed) {
  const System<double> system = with(bare(15.0, 15.0), {gaussian(8.0)});
  const SampleGrid in{4096, 2048, 3.75, 3.75};
  Image scene = random_image(in.width, in.height, 3, 4.0, 1.0);
  for (std::int64_t y = 0; y < in.height; ++y)
    for (std::int64_t x = in.width / 4; x < in.width; ++x) scene.at(x, y) = 7.25F;
  const PlanOptions options = options_for(scene, Border::reflect, 1e-3);
  const ImageView<const float> view = scene.view();
  const auto plan = worth_tiling(system, in, std::span(&view, 1), 0.0, options);
  ASSERT_TRUE(plan.has_value());
  TileTally tally;
  const Image out = tiled(*plan, scene, 0.0, &tally);
  EXPECT_GE(tally.flat, plan->report().count / 3);
  EXPECT_EQ(tally.flat + tally.computed, plan->report().count);
  EXPECT_DOUBLE_EQ(plan->flat_share(std::span(&view, 1), 0.0),
                   static_cast<double>(tally.flat) / static_cast<double>(plan->report().count));
  EXPECT_EQ(out.at(out.width() - 1, out.height() - 1), 7.25F);
  const Image noise = random_image(in.width, in.height, 3);
  const ImageView<const float> busy = noise.view();
  EXPECT_FALSE(worth_tiling(system, in, std::span(&busy, 1), 0.0, options).has_value());
}

TEST(Tiles, too_little_memory_names_what_is_enough) {
  const System<double> system = mwir();
  const SampleGrid in{16384, 16384, 3.75, 3.75};
  PlanOptions options;
  options.scene = SceneSummary{1.0, 5.0, 2.0};
  try {
    compile_tiled(system, in, options, {.memory = 16 << 20, .row_bytes = 65536, .threads = 1});
    FAIL() << "16 MiB cannot be enough";
  } catch (const UsageError& e) {
    const std::string what = e.what();
    const auto at = what.find("allow ");
    ASSERT_NE(at, std::string::npos) << what;
    const std::int64_t least = std::strtoll(what.c_str() + at + 6, nullptr, 10);
    const TiledSensorPlan plan =
        compile_tiled(system, in, options, {.memory = least << 20, .row_bytes = 65536, .threads = 1});
    EXPECT_FALSE(plan.report().whole);
    EXPECT_LE(plan.report().bytes, least << 20);
  }
}

/// The number after `before` in a message.
double number_after(const std::string& what, const std::string& before) {
  const std::size_t at = what.find(before);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? 0.0 : std::strtod(what.c_str() + at + before.size(), nullptr);
}

// A scene of little contrast: its samples round by a good part of the tolerance. The memory that the refusal names
// keeps the tolerance with one plan, or says with which tolerance; the tolerance that it names goes through the memory.
TEST(Tiles, a_refused_scene_goes_through_with_what_the_message_names) {
  const SampleGrid in{7000, 7000, 3.75, 3.75};
  const TileOptions tiles{.memory = 400 << 20, .row_bytes = 28000, .threads = 1};
  for (const double std : {5e-3, 2e-3}) {  // the second one allows no plan 1e-4
    PlanOptions options;
    options.scene = SceneSummary{std, 5.0, 2.0 * std};
    std::string what;
    try {
      compile_tiled(mwir(), in, options, tiles);
      FAIL() << "400 MiB and 1e-4 cannot be enough";
    } catch (const UsageError& e) {
      what = e.what();
    }
    const bool too_tight = what.find(" and that tolerance") != std::string::npos;
    EXPECT_EQ(too_tight, std < 3e-3) << what;
    PlanOptions at_once = options, looser = options;
    if (too_tight) at_once.tolerance = number_after(what, ", with a tolerance of ");
    TileOptions larger = tiles;
    larger.memory = static_cast<std::int64_t>(number_after(what, "allow ")) << 20;
    EXPECT_TRUE(compile_tiled(mwir(), in, at_once, larger).report().whole) << what;
    looser.tolerance = number_after(what, ", or a tolerance of ");
    EXPECT_FALSE(compile_tiled(mwir(), in, looser, tiles).report().whole) << what;
    expect_says(what, {"float32"});
  }
}

TEST(Tiles, memory_holds_what_the_caller_and_the_receiver_take) {
  const SampleGrid in{16384, 16384, 3.75, 3.75};
  PlanOptions options;
  options.scene = SceneSummary{1.0, 5.0, 2.0};
  const auto plan = [&](double receiver_bytes, std::int64_t held_bytes) {
    return compile_tiled(mwir(), in, options,
                         {.memory = 400 << 20,
                          .row_bytes = 65536,
                          .receiver_bytes = receiver_bytes,
                          .held_bytes = held_bytes,
                          .threads = 2})
        .report();
  };
  const TileReport bare = plan(0.0, 0), receiver = plan(40.0, 0), held = plan(0.0, 30 << 20);
  for (const TileReport& report : {bare, receiver, held}) EXPECT_LE(report.bytes, 400 << 20);
  EXPECT_EQ(receiver.side, bare.side);
  EXPECT_NEAR(static_cast<double>(receiver.bytes - bare.bytes),
              40.0 * static_cast<double>(bare.in_flight * bare.side[0] * bare.side[1]), 2.0);
  EXPECT_EQ(held.side, bare.side);
  EXPECT_EQ(held.bytes - bare.bytes, 30 << 20);
  EXPECT_LT(plan(4000.0, 0).side[0], bare.side[0]);  // smaller tiles where a receiver takes much
}

// A complex OTF takes twice the memory of a real one, or four times.
TEST(Tiles, memory_holds_what_the_plans_take) {
  System<double> complex = mwir();
  complex.add(Stage::postsample, fir({{0, 0, 0}, {0, 0.7, 0.2}, {0, 0.1, 0}}));
  complex.add(Stage::presample, rc(60.0, 0));
  const SampleGrid in{16384, 16384, 3.75, 3.75};
  PlanOptions options;
  options.scene = SceneSummary{1.0, 5.0, 2.0};
  for (const System<double>& system : {mwir(), complex})
    for (const std::int64_t memory : {400 << 20, 800 << 20}) {
      const TiledSensorPlan plan =
          compile_tiled(system, in, options, {.memory = memory, .row_bytes = 65536, .more_rows = 64, .threads = 2});
      const PlanReport& near = plan.inner().presample.report();
      const auto canvas = static_cast<double>(near.in.width * near.in.height);
      EXPECT_LE(plan.report().bytes, memory);
      EXPECT_GE(static_cast<double>(plan.report().bytes),
                static_cast<double>(near.otf_bytes) + 65536.0 * static_cast<double>(near.in.height) +
                    plan.report().in_flight * (static_cast<double>(near.run_bytes) + 4.0 * canvas));
    }
}

TEST(Tiles, ratios_that_are_none_of_small_numbers_take_the_whole_image) {
  const System<double> system = with(bare(15.0, 15.0), {gaussian(9.0)});
  const SampleGrid in{120, 100, 15.0 / 3.14159, 15.0 / 3.14159};
  const Image scene = two_halves(in.width, in.height);
  const PlanOptions options = options_for(scene, Border::reflect, 1e-3);
  const TiledSensorPlan plan = compile_tiled(system, in, options, {.threads = 1, .side = 8});
  EXPECT_TRUE(plan.report().whole);
  const auto expected = reference_image(scene, in, plan.out(), otf_of(system, Stage::presample), Border::reflect);
  EXPECT_LE(rms_distance(tiled(plan, scene, 0.0), expected) / options.scene->std, 1e-3);
}

TEST(Tiles, pixels_that_are_not_finite_are_refused_with_their_place) {
  const System<double> system = mwir();
  const SampleGrid in{640, 600, 3.75, 3.75};
  Image scene = two_halves(in.width, in.height);
  const PlanOptions options = options_for(scene, Border::reflect, 1e-3);
  scene.at(500, 30) = std::numeric_limits<float>::quiet_NaN();
  scene.at(7, 31) = std::numeric_limits<float>::infinity();
  const TiledSensorPlan plan = compile_tiled(system, in, options, {.threads = 1, .side = 64});
  try {
    tiled(plan, scene, 0.0);
    FAIL();
  } catch (const RuntimeError& e) {
    EXPECT_TRUE(says(std::string(e.what()), "2 pixels")) << e.what();
    EXPECT_TRUE(says(std::string(e.what()), "NaN")) << e.what();
    EXPECT_TRUE(says(std::string(e.what()), "column 500, row 30")) << e.what();
  }
}

TEST(Survey, equals_the_statistics_of_the_image_in_memory) {
  for (const double offset : {0.0, 1e6})
    for (const Border border : kBorders) {
      const Image scene = random_image(301, 97, 4, offset, 2.0);
      const ImageView<const float> view = scene.view();
      const Survey s = survey(windows_of(std::span(&view, 1)), 0, {301, 97, 1.0, 1.0},
                              {.border = border, .border_value = 3.0, .band_rows = 10, .threads = 2});
      const Statistics expected = statistics(scene.view());
      EXPECT_NEAR(s.statistics.mean, expected.mean, 1e-12 * (1.0 + offset));
      EXPECT_NEAR(s.statistics.std, expected.std, 1e-12 * expected.std);
      EXPECT_EQ(s.statistics.min, expected.min);
      EXPECT_EQ(s.statistics.max, expected.max);
      const double norm = canvas_norm_of(row_moments(scene.view()), scene.width(), border, 3.0, expected.mean);
      EXPECT_NEAR(s.canvas_norm, norm, 1e-9 * norm);
    }
}

TEST(Survey, of_several_channels_is_that_of_each) {
  const Image a = random_image(301, 297, 5), b = random_image(301, 297, 6, 40.0, 3.0);
  const std::array<ImageView<const float>, 2> planes{a.view(), b.view()};
  const SampleGrid scene{301, 297, 1.0, 1.0};
  const std::vector<Survey> both =
      survey_channels(windows_of(planes), 0, 2, scene, {.every = 8, .band_rows = 40, .threads = 2});
  ASSERT_EQ(both.size(), 2U);
  for (std::size_t c = 0; c < 2; ++c) {
    const Survey one = survey(windows_of(planes), c, scene, {.every = 8, .band_rows = 512, .threads = 1});
    EXPECT_EQ(both[c].fingerprint, one.fingerprint);
    EXPECT_EQ(both[c].statistics.std, one.statistics.std);
    EXPECT_EQ(both[c].shift, one.shift);
    ASSERT_EQ(both[c].coarse.size(), one.coarse.size());
    for (std::int64_t i = 0; i < one.coarse.size(); ++i) ASSERT_EQ(both[c].coarse.data()[i], one.coarse.data()[i]);
  }
  EXPECT_NE(both[0].fingerprint, both[1].fingerprint);
}

}  // namespace
}  // namespace mtf::test
