// SPDX-License-Identifier: Apache-2.0
// OTFs over the field of view: field points and OTFs against golden values, images against the definition, pixel by
// pixel: each sees what the isoplanatic sensor with that pixel's OTF would see.
#include <map>
#include <random>
#include <set>

#include "mtf/components/field_access.h"
#include "mtf/components/linear_motion.h"
#include "mtf/components/pupil/cut_pupil.h"
#include "mtf/engines/fft/scene_spectrum.h"
#include "mtf/field/field_map.h"
#include "mtf/field/field_modes.h"
#include "mtf/field/throughput.h"
#include "mtf/plan/sensor_plan.h"
#include "mtf/tiles/tiles.h"
#include "tests/expect_error.h"
#include "tests/mtf/field_golden.h"
#include "tests/mtf/field_systems.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

/// The definition at a pixel.
double reference_at(const System<double>& system, const Image& scene, const SampleGrid& in, const SampleGrid& out,
                    Border border, double border_value, std::int64_t i, std::int64_t j) {
  System<double> sized = system;
  sized.frame.columns = static_cast<int>(out.width);
  sized.frame.rows = static_cast<int>(out.height);
  const System<double> here = sized.at(sized.field_point(static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5));
  // The grid of that pixel alone begins at its own corner: a shift of the scene in the phase.
  const double dx = static_cast<double>(i) * out.step_x_um * 1e-3, dy = static_cast<double>(j) * out.step_y_um * 1e-3;
  const Otf moved = [&](double fx, double fy) {
    const Complex<double> h = here.otf(Stage::presample, {fx, fy});
    return std::complex<double>(h.re, h.im) * std::polar(1.0, 2.0 * kPi * (fx * dx + fy * dy));
  };
  return reference_image(scene, in, {1, 1, out.step_x_um, out.step_y_um}, moved, border, border_value).front();
}

std::vector<double> reference_over_field(const System<double>& system, const Image& scene, const SampleGrid& in,
                                         const SampleGrid& out, Border border, double border_value) {
  std::vector<double> image;
  for (std::int64_t j = 0; j < out.height; ++j)
    for (std::int64_t i = 0; i < out.width; ++i)
      image.push_back(reference_at(system, scene, in, out, border, border_value, i, j));
  return image;
}

TEST(Field, PointsAreThoseOfTheDetector) {
  const std::vector<Golden> rows = golden("coordinate");
  if (rows.empty()) GTEST_SKIP() << "the shared data are not there";
  for (const Golden& row : rows) {
    System<double> s = bare(15.0, 15.0);
    const std::vector<double> size = numbers_in(row.parameters), at = numbers_in(row.where);
    s.frame.columns = static_cast<int>(size[0]), s.frame.rows = static_cast<int>(size[1]);
    const FieldPoint<double> q = s.field_point(at[0], at[1]);
    EXPECT_NEAR(row.quantity == "q_x" ? q.x : q.y, row.value, 1e-15) << row.where;
  }
}

TEST(Field, SeidelAberrationsAtFieldPoints) {
  const std::vector<Golden> rows = golden("seidel_otf");
  if (rows.empty()) GTEST_SKIP() << "the shared data are not there";
  const System<double> s = seidel(0.25, 0.7, 1.0, 0.5, -0.3);
  for (const Golden& row : rows) {
    const std::vector<double> at = numbers_in(row.where);
    const double cutoff = 1e3 / (2.0 * 4.0);
    const Complex<double> h = s.at({at[0], at[1]}).otf(Stage::presample, {at[2] * cutoff, at[3] * cutoff});
    EXPECT_NEAR(row.quantity == "re" ? h.re : h.im, row.value, 1e-11) << row.where;
  }
}

TEST(Field, RollOfTheLineOfSight) {
  const std::vector<Golden> rows = golden("roll_otf");
  if (rows.empty()) GTEST_SKIP() << "the shared data are not there";
  for (const Golden& row : rows) {
    const std::vector<double> at = numbers_in(row.where);
    const System<double> s = rolling(1.5, 0.2, 640, 512);
    EXPECT_FALSE(s.is_isoplanatic());
    const System<double> here = s.at({at[0], at[1]});
    EXPECT_TRUE(here.is_isoplanatic());
    const Complex<double> h = here.otf(Stage::presample, {at[2] / 0.015, at[3] / 0.015});
    EXPECT_NEAR(h.re, row.value, 1e-12) << row.where;
    EXPECT_EQ(h.im, 0.0);
  }
}

TEST(Field, LightThroughCutPupils) {
  const std::vector<Golden> areas = golden("vignetting"), flats = golden("flat");
  if (areas.empty()) GTEST_SKIP() << "the shared data are not there";
  for (const Golden& row : areas) {
    const std::vector<double> rim = numbers_in(row.parameters);
    EXPECT_NEAR(pupil_share({rim[1], rim[0] * numbers_in(row.where)[0]}, 0.0), row.value, 1e-15) << row.where;
  }
  System<double> s = seidel(0.1, 0.0, 0.0, 0.0, 0.0);
  s.frame.columns = 6, s.frame.rows = 4;
  auto& lens = s.list(Stage::presample)[0].component;
  set(lens, "vignetting_rim", 1.05);
  set(lens, "vignetting_shift", 0.0);
  let_vary(s, 0, "vignetting_shift", "r", 0.5);
  const Image shares = throughput_image(s);
  for (const Golden& row : flats) {
    const std::vector<double> at = numbers_in(row.where);
    EXPECT_NEAR(3.25 * shares.at(static_cast<std::int64_t>(at[0]), static_cast<std::int64_t>(at[1])), row.value, 3e-7);
  }
  s.frame.columns = 0;
  expect_refused({"frame.format"}, [&] { throughput_image(s); });
  expect_refused({"vignetting_rim"}, [] { throughput_image(seidel(0.1, 0.0, 0.0, 0.0, 0.0)); });
}

TEST(Field, ImagesOfTheDefinition) {
  int seen = 0;
  std::set<std::string> planned;
  const std::vector<Golden> rows = golden("image");
  if (rows.empty()) GTEST_SKIP() << "the shared data are not there";
  for (const Golden& row : rows) {
    const bool gauss = row.parameters.starts_with("field=gauss"), roll = row.parameters.starts_with("field=roll"),
               flow = row.parameters.starts_with("field=flow");
    if (!gauss && !roll && !flow) continue;  // a shift is no component
    // There the last frequency of a periodic canvas counts by one sign, here by half of each; reflected ones have none.
    if (row.parameters.find("periodic") != std::string::npos) continue;
    const double ratio = row.parameters.find("ratio=2") != std::string::npos ? 2.0 : 1.0;
    const Border border = Border::reflect;
    System<double> s = roll ? rolling(1.5, 0.2, 6, 4) : bare(15.0, 15.0);
    if (flow) {
      s.frame.columns = 6, s.frame.rows = 4;
      s.add(Stage::presample, Component<double>::make("flow"));
      set(s.list(Stage::presample)[0].component, "zoom", 2.0 * 15.0 / s.field_radius_um());
    }
    if (roll || flow) s.add(Stage::presample, footprint(15.0));
    if (gauss) {
      s.frame.columns = 6, s.frame.rows = 4;
      s.add(Stage::presample, test::gaussian(0.4 * 15.0));
      let_vary(s, 0, "sigma", "x", 0.5 * 15.0);
      let_vary(s, 0, "sigma", "r2", 0.3 * 15.0);
    }
    const Image scene = image_of(static_cast<std::int64_t>(6 * ratio), static_cast<std::int64_t>(4 * ratio),
                                 [](auto x, auto y) { return (7 * x + 3 * y + x * y) % 11 - 4; });
    const SampleGrid in = scene_grid(s, scene.width(), scene.height(), ratio, ratio), out{6, 4, 15.0, 15.0};
    const std::vector<double> at = numbers_in(row.where);
    const auto pixel = static_cast<std::size_t>(at[1] * 6 + at[0]);
    const std::vector<double> slow = reference_over_field(s, scene, in, out, border, 0.0);
    EXPECT_NEAR(slow[pixel], row.value, 1e-12) << row.where << " " << row.parameters;
    ++seen;
    if (!planned.insert(row.parameters).second) continue;
    const PlanOptions options = options_for(scene, border, gauss ? 1e-3 : 2e-2);
    const Plan plan = compile(s, in, out, options);
    EXPECT_EQ(plan.report().method, "field_modes");
    EXPECT_LE(rms_distance(run(plan, scene), slow), plan.report().predicted.total() * options.scene->std);
  }
  EXPECT_EQ(seen, 17);
}

TEST(Field, UniformScenesAreExact) {
  for (const System<double>& s : {seidel(0.05, 0.2, 0.2, 0.1, 0.0), rolling(0.4, 0.2, 16, 16)}) {
    const SampleGrid in = scene_grid(s, 32, 32, 2, 2), out{16, 16, 15.0, 15.0};
    const Plan plan = compile(s, in, out, {.tolerance = 3e-2, .threads = 1});
    ASSERT_EQ(plan.report().method, "field_modes");
    const Image image = run(plan, image_of(32, 32, [](auto, auto) { return 3.25; }));
    for (std::int64_t i = 0; i < image.size(); ++i) EXPECT_EQ(image.data()[i], 3.25F);
  }
}

TEST(Field, OnePixel) {
  const System<double> s = seidel(0.1, 0.3, 0.4, 0.2, 0.1);
  const Image scene = random_image(8, 8, 2);
  const SampleGrid in = scene_grid(s, 8, 8, 8, 8), out{1, 1, 15.0, 15.0};
  const Plan plan = compile(s, in, out, options_for(scene, Border::reflect, 1e-2));
  const std::vector<double> slow = reference_over_field(s, scene, in, out, Border::reflect, 0.0);
  EXPECT_NEAR(run(plan, scene).at(0, 0), slow.front(), 1e-2);
}

TEST(Field, ThreadsDoNotCount) {
  const System<double> s = seidel(0.1, 0.3, 0.4, 0.2, 0.0);
  const Image scene = random_image(80, 64, 5);
  const SampleGrid in = scene_grid(s, 80, 64, 2, 2), out{40, 32, 15.0, 15.0};
  PlanOptions options = options_for(scene, Border::reflect, 2e-2);
  const Plan one = compile(s, in, out, options);
  options.threads = 2;
  const Plan two = compile(s, in, out, options);
  EXPECT_TRUE(same_bits(run(one, scene, 0.0, 1), run(two, scene, 0.0, 2)));
}

TEST(Field, WhatDoesNotMatterIsTheSamePlan) {
  System<double> s = seidel(0.1, 1e-5, 1e-5, 0.0, 0.1), axis = s.at({});
  s.add(Stage::presample, footprint(15.0));
  axis.add(Stage::presample, footprint(15.0));
  const Image scene = random_image(96, 96, 7);
  const SampleGrid in = scene_grid(s, 96, 96, 2, 2), out{48, 48, 15.0, 15.0};
  const PlanOptions options = options_for(scene, Border::reflect, 1e-3);
  const Plan plan = compile(s, in, out, options);
  EXPECT_EQ(plan.report().field.modes, 0U);
  EXPECT_GT(plan.report().field.points, 0U);
  EXPECT_TRUE(same_bits(run(plan, scene), run(compile(axis, in, out, options), scene)));
  EXPECT_NE(plan.explain().find("one OTF serves all pixels"), std::string::npos);
}

TEST(Field, AKeptSceneAndItsOwnMemoryGiveTheSame) {
  const System<double> s = seidel(0.1, 0.3, 0.4, 0.2, 0.0);
  const Image scene = random_image(48, 48, 9);
  const SampleGrid in = scene_grid(s, 48, 48, 1, 1), out{48, 48, 15.0, 15.0};
  const Plan plan = compile(s, in, out, options_for(scene, Border::reflect, 1e-2));
  ASSERT_EQ(plan.report().method, "field_modes");
  const Image plain = run(plan, scene);
  auto planes = std::make_shared<std::vector<Image>>();
  planes->push_back(scene.clone());
  KeptScene kept(planes);
  Image again(48, 48);
  for (int i = 0; i < 2; ++i) {
    const ImageView<float> view = again.view();
    plan.run(kept, std::span(&view, 1), 0.0, 1);
    EXPECT_TRUE(same_bits(again, plain));
  }
  Image own = scene.clone();
  plan.run(own.view(), own.view(), 0.0, 1);
  EXPECT_TRUE(same_bits(own, plain));
}

// Rows or columns that are uniform take no transform; a plan that knows nothing of the scene transforms all.
// A region of an image, and a limit of memory: the scene is filtered at once, field points are those of the detector.
TEST(Field, ARegionIsThatOfTheWholeImage) {
  System<double> system = seidel(0.05, 0.3, 0.2, 0.1, 0.1);
  system.frame.columns = 48, system.frame.rows = 40;
  const Image scene = random_image(48, 40, 5, 3.0, 1.0);
  const SampleGrid in = scene_grid(system, 48, 40, 1.0, 1.0);
  PlanOptions options;
  options.tolerance = 1e-2;
  options.scene = summarise(scene.view(), options.border, 0.0);
  const ImageView<const float> view = scene.view();
  const Image whole = std::move(compile_sensor(system, in, options).run(std::span(&view, 1), 0.0, 1).front());
  const TiledSensorPlan plan = compile_tiled(system, in, options, {.threads = 1, .region = Region{7, 30, 20, 9}});
  EXPECT_TRUE(plan.report().whole);
  const Image part = std::move(plan.run(std::span(&view, 1)).front());
  for (std::int64_t y = 0; y < 9; ++y)
    for (std::int64_t x = 0; x < 20; ++x) ASSERT_EQ(part.at(x, y), whole.at(7 + x, 30 + y));
  expect_refused({"changes over the field by presample[0].w131", "at once", "limit is 1MiB"},
                 [&] { compile_tiled(system, in, options, {.memory = 1 << 20}); });
}

TEST(Field, UniformLinesAreLeftOut) {
  const System<double> s = seidel(0.1, 0.3, 0.4, 0.2, 0.0);
  constexpr std::int64_t kSide = 192;
  for (const bool rows : {true, false}) {
    Image scene = random_image(kSide, kSide, 9);
    for (std::int64_t y = 0; y < kSide; ++y)
      for (std::int64_t x = 0; x < kSide; ++x)
        if ((rows ? y : x) >= 64) scene.at(x, y) = 0.5F;
    const SampleGrid in = scene_grid(s, kSide, kSide, 1, 1), out{kSide, kSide, 15.0, 15.0};
    PlanOptions options = options_for(scene, Border::reflect, 1e-2);
    const Plan plan = compile(s, in, out, options);
    EXPECT_GT(plan.report().predicted.flat, 0.0);
    options.scene->flat_rows = options.scene->flat_columns = 0.0;
    const Image some = run(plan, scene), all_lines = run(compile(s, in, out, options), scene);
    const std::vector<double> all(all_lines.data(), all_lines.data() + all_lines.size());
    EXPECT_LT(rms_distance(some, all), plan.report().predicted.total() * options.scene->std);
    EXPECT_GT(rms_distance(some, all), 0.0);
    EXPECT_TRUE(same_bits(some, run(plan, scene, 0.0, 2)));
  }
}

TEST(Field, WhatCannotBeIsRefused) {
  System<double> s = bare(15.0, 15.0);
  s.add(Stage::presample, test::gaussian(6.0));
  let_vary(s, 0, "sigma", "x", -20.0);
  expect_says(message_of<UsageError>([&] { require_valid(s); }), {"sigma"});
  const System<double> tilted = [&] {
    System<double> t = bare(15.0, 15.0);
    t.add(Stage::presample, test::gaussian(6.0));
    let_vary(t, 0, "sigma", "x", 2.0);
    return t;
  }();
  EXPECT_NO_THROW(require_valid(tilted));
  expect_says(message_of<UsageError>([&] { require_isoplanatic(tilted, "a fit"); }), {"a fit", "presample[0].sigma"});
}

TEST(Field, FiltersAfterTheSamplingStayWhatTheyAre) {
  System<double> s = seidel(0.1, 0.3, 0.4, 0.2, 0.0);
  const Image scene = random_image(32, 32, 11);
  const SampleGrid in = scene_grid(s, 32, 32, 1, 1);
  s.add(Stage::postsample, fir({{0.0, -0.25, 0.0}, {-0.25, 2.0, -0.25}, {0.0, -0.25, 0.0}}));
  System<double> other = s;
  other.list(Stage::postsample)[0].component = fir({{0.0, -0.1, 0.0}, {-0.1, 1.4, -0.1}, {0.0, -0.1, 0.0}});
  const PlanOptions options = options_for(scene, Border::reflect, 5e-2);
  const SensorPlan first = compile_sensor(s, in, options);
  const Image changed = first.with(other).run(SceneView{scene.view(), pixels(1.0)}, 1),
              anew = compile_sensor(other, in, options).run(SceneView{scene.view(), pixels(1.0)}, 1);
  double squares = 0.0;
  for (std::int64_t i = 0; i < anew.size(); ++i) squares += std::pow(changed.data()[i] - anew.data()[i], 2);
  EXPECT_LE(std::sqrt(squares / static_cast<double>(anew.size())), 1e-1 * options.scene->std);
}

TEST(Field, WideBlurIsSeen) {
  // Narrower in frequency than a cell of a scene's spectrum.
  System<double> s = bare(15.0, 15.0);
  s.add(Stage::presample, test::gaussian(15.0 * 12.0));
  let_vary(s, 0, "sigma", "r2", 15.0 * 4.0);
  const SampleGrid in = scene_grid(s, 128, 128, 8, 8), out{16, 16, 15.0, 15.0};
  const FieldModes modes(with_field_radius(s, out), in, out, {.table_error = 1e-4, .enough = 1.0, .threads = 1});
  EXPECT_GT(modes.error_of_axis(), 0.05);
}

TEST(Field, TheToleranceOfARefusalIsAccepted) {
  System<double> s = bare(15.0, 15.0);
  s.add(Stage::presample, motion(3.0, 0.0));
  turn_with_field(s, 0, "direction");  // a step on the axis
  const SampleGrid in = scene_grid(s, 24, 24, 2, 2), out{12, 12, 15.0, 15.0};
  const Image scene = random_image(24, 24, 3);
  PlanOptions options = options_for(scene, Border::reflect, 1e-3);
  try {
    static_cast<void>(compile(s, in, out, options));
    FAIL() << "a step over the field keeps no such tolerance";
  } catch (const UnreachableTolerance& refused) {
    expect_says(refused.what(), {"over the field"});
    if (refused.reachable() >= 1.0) return;
    options.tolerance = refused.reachable();
    EXPECT_NO_THROW(static_cast<void>(compile(s, in, out, options)));
  }
}

/// A flow by an image of the displacement along x and y at each pixel.
System<double> flowing(int columns, int rows, const std::function<std::array<double, 2>(int x, int y)>& displacement) {
  System<double> s = bare(15.0, 15.0);
  s.frame.columns = columns, s.frame.rows = rows;
  Flow<double> flow;
  flow.shift = {{0.0, find_unit("px")}, {0.0, find_unit("px")}, true};
  s.add(Stage::presample, flow);
  s.add(Stage::presample, footprint(15.0));
  FieldMap image;
  image.columns = columns, image.rows = rows, image.column.resize(2);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x)
      for (std::size_t i = 0; i < 2; ++i) image.column[i].value.push_back(displacement(x, y)[i]);
  const auto map = make_field_image(std::move(image));
  for (std::size_t i = 0; i < 2; ++i) {
    s.field.numbers.push_back({0, 2, i, {}, map, i});
    *detail::number_of(s.list(Stage::presample)[0].component.fields()[2], i) = s.mapped(s.field.numbers.back(), {});
  }
  return s;
}

TEST(Field, DisplacementsByAnImage) {
  const System<double> s = flowing(14, 10, [](int x, int y) {
    return std::array{1.2 * std::cos(0.25 * x) + 0.05 * y, 0.8 * std::sin(0.3 * y + 0.1 * x)};
  });
  EXPECT_EQ(s.at(s.field_point(3.5, 7.5)).list(Stage::presample)[0].component.get_if<Flow<double>>()->shift.y.value,
            0.8 * std::sin(0.3 * 7 + 0.1 * 3));
  const Image scene = random_image(28, 20, 6);
  const SampleGrid in = scene_grid(s, 28, 20, 2, 2), out{14, 10, 15.0, 15.0};
  for (const double tolerance : {3e-2, 5e-3}) {
    const PlanOptions options = options_for(scene, Border::reflect, tolerance);
    const Plan plan = compile(s, in, out, options);
    EXPECT_EQ(plan.report().method, "field_modes");
    const double realised =
        rms_distance(run(plan, scene), reference_over_field(s, scene, in, out, Border::reflect, 0.0));
    EXPECT_LE(realised, plan.report().predicted.total() * options.scene->std);
    EXPECT_GT(realised, 0.0);
  }
}

// A parabola along both axes, between samples, between the first two and the last two, and out to the border.
TEST(Field, ImagesMeetParabolasAndEndWithTheDetector) {
  const auto parabola = [](double x, double y) { return 0.03 * x * x - 0.02 * x * y + 0.05 * y * y; };
  const System<double> s = flowing(14, 3, [&](int x, int y) { return std::array{parabola(x, y), 0.0}; });
  const auto shift_at = [&](double x, double y) {
    return s.at(s.field_point(x, y)).list(Stage::presample)[0].component.get_if<Flow<double>>()->shift.x.value;
  };
  for (const double x : {0.0, 0.3, 0.75, 1.2, 6.9, 12.75, 13.5, 14.0})
    for (const double y : {0.0, 0.8, 1.9, 3.0})
      EXPECT_NEAR(shift_at(x, y), parabola(x - 0.5, y - 0.5), 1e-12) << x << " " << y;  // rounding
  EXPECT_NO_THROW(shift_at(14.1, 3.0));
  for (const auto& [x, y] : {std::pair{14.2, 1.0}, {-0.2, 1.0}, {3.0, 3.1}, {3.0, -40.0}})
    expect_refused({"covers the detector with 14x3 samples", "ask for places on the detector"},
                   [&] { shift_at(x, y); });
}

// One pixel that moves on its own, where no place between the points is looked at: no polynomial follows it.
TEST(Field, JumpsOfDisplacementsAreSeen) {
  for (const bool alone : {false, true}) {
    const System<double> s = flowing(64, 48, [&](int x, int y) {
      return std::array{1.0 + 0.01 * x + (alone && x == 37 && y == 22 ? 1.5 : 0.0), 0.5};
    });
    const Image scene = random_image(64, 48, 3);
    const SampleGrid in = scene_grid(s, 64, 48, 1, 1), out{64, 48, 15.0, 15.0};
    const PlanOptions options = options_for(scene, Border::reflect, 1e-2);
    const auto planned = [&] { static_cast<void>(compile(s, in, out, options)); };
    if (alone)
      expect_refused<UnreachableTolerance>({"over the field"}, planned);
    else
      EXPECT_NO_THROW(planned());
  }
}

// Of two jumps the lesser is looked at too, as an OTF may change more by it; samples twice as fine as pixels, or each
// for two pixels, are looked at where pixels are.
TEST(Field, EveryJumpOfAnImageIsLookedAt) {
  for (const double finer : {1.0, 2.0, 0.5}) {
    FieldMap image;
    image.columns = static_cast<int>(64 * finer), image.rows = static_cast<int>(48 * finer);
    image.column.resize(1);
    const auto columns = static_cast<std::size_t>(image.columns);
    image.column[0].value.assign(columns * static_cast<std::size_t>(image.rows), 0.2);
    for (const auto& [x, y, by] : {std::tuple{37.5, 22.5, 1.5}, {15.5, 34.5, 0.4}})
      image.column[0].value[static_cast<std::size_t>(y * finer) * columns + static_cast<std::size_t>(x * finer)] += by;
    const auto map = make_field_image(std::move(image));
    for (const std::size_t n : {3U, 5U}) {  // whose points are not next to the jumps
      const auto found = hardest_pixels(*map, 0, n, {0.5 * finer, 0.5 * finer}, {63.5 * finer, 47.5 * finer}, {64, 48});
      for (const auto& [x, y] : {std::array{37, 22}, std::array{15, 34}})
        EXPECT_TRUE(std::ranges::any_of(found,
                                        [&](const auto& at) {
                                          return std::abs(at[0] - x) <= 1 &&
                                                 std::abs(at[1] - y) <= 1;  // a sample between two pixels
                                        }))
            << finer << " " << n << " " << x;
      EXPECT_LE(found.size(), 9u);
    }
  }
}

TEST(Field, ValuesAreCheckedWhereThePixelsAre) {
  System<double> s = bare(15.0, 15.0);
  s.add(Stage::presample, footprint(10.0));
  let_vary(s, 0, "width", "x", -13.0);
  // Without a format a square is looked at, where |x| is at most 0.71; a strip reaches farther.
  const SampleGrid in = scene_grid(s, 200, 10, 1, 1), out{200, 10, 15.0, 15.0};
  expect_says(message_of<UsageError>([&] { static_cast<void>(compile(s, in, out, {.tolerance = 1e-2})); }),
              {"width", "field point"});
  s.field.numbers.clear();
  let_vary(s, 0, "width", "r2", 1.0);
  expect_says(message_of<UsageError>(
                  [&] { static_cast<void>(compile(s, in, out, {.tolerance = 1e-2, .method = Method::separable})); }),
              {"separable", "--method"});
}

/// Realised <= predicted <= tolerance, or a refusal that names a tolerance; with tiles also one that says why not.
void keeps_its_promise(unsigned seed, bool in_tiles = false) {
  std::mt19937 generator(seed);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(generator); };
  const auto below = [&](unsigned n) { return static_cast<int>(generator() % n); };
  System<double> s = bare(15.0, below(3) == 0 ? 12.0 : 15.0);
  const int columns = 8 + below(6), rows = 6 + below(6), ratio = 1 + below(2);
  switch (below(5)) {
    case 0:
      s = seidel(uniform(0.0, 0.3), uniform(0.0, 0.7), uniform(0.0, 1.0), uniform(0.0, 0.5), uniform(-0.3, 0.3));
      break;
    case 1:
      s.add(Stage::presample, Component<double>::make("diffraction"));
      s.frame.columns = columns, s.frame.rows = rows;
      s.add(Stage::presample,
            rolling(uniform(0.1, 1.5), uniform(0.0, 0.5), columns, rows).list(Stage::presample)[0].component);
      break;
    case 2:
      s.add(Stage::presample, test::gaussian(uniform(4.0, 8.0)));
      let_vary(s, 0, "sigma", "x", uniform(-3.0, 3.0));
      let_vary(s, 0, "sigma", "r2", uniform(0.0, 4.0));
      break;
    case 3:
      s.add(Stage::presample, motion(2.0, 0.0));
      let_vary(s, 0, "travel", "r2", uniform(5.0, 40.0));
      turn_with_field(s, 0, "direction");
      break;
    default:
      s.add(Stage::presample, Component<double>::make("diffraction"));
      s.band = Band{3.5, 4.5};
      s.optics.wavelength_um.reset();
      let_vary(s, 0, "f_number", "r2", 0.0);
      s.list(Stage::presample)[0].component = [] {
        auto c = Component<double>::make("diffraction");
        set(c, "f_number", 2.0);
        return c;
      }();
      let_vary(s, 0, "f_number", "r2", uniform(0.0, 0.3));
  }
  if (below(2) == 0) s.add(Stage::presample, footprint(15.0));
  if (below(4) == 0) s.add(Stage::presample, rc(15.0, below(2)));  // parts of the modes mix
  const Border border = kBorders[static_cast<std::size_t>(below(4))];
  const double mean = below(3) == 0 ? 100.0 : 0.0, border_value = border == Border::constant ? mean + 1.0 : 0.0;
  const Image scene = random_image(columns * ratio, rows * ratio, seed, mean);
  const SampleGrid in = scene_grid(s, scene.width(), scene.height(), ratio, ratio),
                   out{columns, rows, s.frame.pitch_x_um, s.frame.pitch_y_um};
  PlanOptions options = options_for(scene, border, std::pow(10.0, uniform(-4.0, -1.0)), border_value);
  if (below(2) == 0) options.spectrum = scene_spectrum(scene.view(), border, 1);
  if (in_tiles) options.method = Method::field_tiles;
  std::optional<Plan> plan;
  try {
    plan = compile(s, in, out, options);
  } catch (const UnreachableTolerance& refused) {
    EXPECT_GT(refused.reachable(), options.tolerance);
    return;
  } catch (const UsageError& refused) {
    if (!in_tiles) throw;
    const std::string why = refused.what();  // they also take the OTFs beyond the scene's frequencies
    EXPECT_TRUE(why.find("field_tiles") != std::string::npos || why.find("GB") != std::string::npos) << why;
    std::printf("seed %u, tolerance %.1e, %s\n", seed, options.tolerance, refused.what());
    return;
  }
  const PredictedError& predicted = plan->report().predicted;
  EXPECT_LE(predicted.total(), options.tolerance * (1.0 + 1e-12));
  const Image image = run(*plan, scene, border_value);
  const double realised =
      rms_distance(image, reference_over_field(s, scene, in, out, border, border_value)) / options.scene->std;
  EXPECT_LE(realised, predicted.total()) << "seed " << seed << "\n" << plan->explain();
  std::printf("seed %u, %s: %s, %zu modes, tolerance %.1e, predicted %.1e (modes %.1e), realised %.1e\n", seed,
              options.spectrum ? "this scene" : "any scene", plan->report().method.c_str(), plan->report().field.modes,
              options.tolerance, predicted.total(), predicted.modes, realised);
}

TEST(Field, PromiseAtRandom) {
  for (unsigned seed = 1; seed <= 10; ++seed) keeps_its_promise(seed);
  for (unsigned seed = 4; seed <= 10; ++seed) keeps_its_promise(seed, true);
}

// Where the cut begins, and where it narrows the pupil, OTFs have kinks over the field.
void cut_pupils_keep_the_promise(int columns, int rows, double tolerance, std::int64_t every, double obscuration) {
  System<double> s = seidel(0.05, 0.2, 0.1, 0.1, 0.0);
  s.add(Stage::presample, footprint(15.0));
  Component<double>& lens = s.list(Stage::presample)[0].component;
  set(lens, "vignetting_rim", 1.05);
  set(lens, "vignetting_shift", 0.0);
  if (obscuration > 0.0) set(lens, "obscuration", obscuration);
  let_vary(s, 0, "vignetting_shift", "r", 0.5);
  const Image scene = random_image(columns, rows, 5);
  const SampleGrid in = scene_grid(s, columns, rows, 1, 1), out{columns, rows, 15.0, 15.0};
  PlanOptions options = options_for(scene, Border::reflect, tolerance);
  options.spectrum = scene_spectrum(scene.view(), Border::reflect, 1);
  const Plan plan = compile(s, in, out, options);
  EXPECT_EQ(plan.report().method, "field_modes");
  const double promised = plan.report().predicted.total();
  EXPECT_LE(promised, tolerance);
  const Image image = run(plan, scene);
  double squares = 0.0;
  std::int64_t count = 0;
  for (std::int64_t k = 0; k < image.size(); k += every, ++count) {
    const double error =
        image.data()[k] - reference_at(s, scene, in, out, Border::reflect, 0.0, k % columns, k / columns);
    squares += error * error;
  }
  const double realised = std::sqrt(squares / static_cast<double>(count)) / options.scene->std;
  std::printf("%d x %d, tolerance %g: %zu modes, promised %.1e, realised %.1e at %d pixels\n", columns, rows, tolerance,
              plan.report().field.modes, promised, realised, static_cast<int>(count));
  EXPECT_LE(realised, promised);
  EXPECT_GT(realised, 0.0);
}

TEST(FieldLong, CutPupilsKeepThePromise) {
  cut_pupils_keep_the_promise(12, 9, 3e-2, 1, 0.0);
  cut_pupils_keep_the_promise(64, 48, 1e-3, 211, 0.0);  // the pixels lie in all parts of the image
  cut_pupils_keep_the_promise(24, 18, 2e-2, 17, 0.3);
}

/// Of so many seeds, modes of the image and modes of tiles.
constexpr unsigned kSeedsOfACase = 25;
class FieldPromiseLong : public testing::TestWithParam<unsigned> {};
TEST_P(FieldPromiseLong, AtRandom) {
  for (unsigned seed = GetParam(); seed < GetParam() + kSeedsOfACase; ++seed)
    for (const bool in_tiles : {false, true}) keeps_its_promise(seed, in_tiles);
}
// 54 x 25 seeds, of the image and of tiles: these alone are 2,700 random cases.
INSTANTIATE_TEST_SUITE_P(Seeds, FieldPromiseLong, testing::Range(11U, 11U + 54 * kSeedsOfACase, kSeedsOfACase));

}  // namespace
}  // namespace mtf::test
