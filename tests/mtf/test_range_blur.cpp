// SPDX-License-Identifier: Apache-2.0
// Defocus by the range of each sample: images against the definition, the sum over all samples, each of which spreads
// by its own OTF, divided by the same sum of a scene of ones.
#include <map>
#include <random>

#include "mtf/components/defocus.h"
#include "mtf/field/sample_ranges.h"
#include "mtf/plan/plan_impl.h"
#include "mtf/plan/sensor_plan.h"
#include "tests/expect_error.h"
#include "tests/mtf/field_golden.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

constexpr float kSky = std::numeric_limits<float>::infinity();

/// F = 100 mm, F/2, 4 um: 78.125 waves for a reciprocal range of 1 a metre; in focus at 15 m.
System<double> by_range(double footprint_um = 15.0) {
  System<double> s = bare(15.0, 15.0);
  Defocus<double> defocus;
  defocus.focus_m = metres(15.0);
  s.add(Stage::presample, defocus);
  if (footprint_um > 0.0) s.add(Stage::presample, footprint(footprint_um));
  return s;
}

/// The range, along the axis, at which the defocus is so many waves.
double range_of(double waves) { return 1.0 / (1.0 / 15.0 + waves / 78.125); }

/// The definition; samples of one number spread alike and are taken together.
template <class OtfOf>
std::vector<double> spread(const Image& scene, const std::vector<double>& number, const SampleGrid& in,
                           const SampleGrid& out, Border border, const OtfOf& otf_of_number) {
  std::map<double, bool> numbers;
  for (const double c : number) numbers[c] = true;
  std::vector<double> sum(static_cast<std::size_t>(out.width * out.height)), weight(sum.size());
  for (const auto& [c, seen] : numbers) {
    const auto of = [&](std::int64_t x, std::int64_t y) {
      return number[static_cast<std::size_t>(y * in.width + x)] == c ? 1.0 : 0.0;
    };
    const Otf otf = otf_of_number(c);
    const auto value = [&](std::int64_t x, std::int64_t y) { return of(x, y) * static_cast<double>(scene.at(x, y)); };
    const std::vector<double> light = reference_image(value, in, out, otf, border),
                              share = reference_image(of, in, out, otf, border);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += light[i], weight[i] += share[i];
  }
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] /= weight[i];
  return sum;
}

std::vector<double> definition(const System<double>& s, const Image& scene, const Image& range_m, const SampleGrid& in,
                               const SampleGrid& out, Border border) {
  return spread(scene, sample_ranges(s, in, out, range_m.view()).per_m, in, out, border, [&](double per_m) {
    System<double> lens = with_distance(s, distance_at_um(s, per_m)), rest = s;
    lens.list(Stage::presample).erase(lens.list(Stage::presample).begin() + 1, lens.list(Stage::presample).end());
    lens.band_nodes = s.band ? 24 : 0;
    rest.list(Stage::presample).erase(rest.list(Stage::presample).begin());
    return Otf([lens, rest, known = std::map<double, double>()](double fx, double fy) mutable {
      const double r2 = fx * fx + fy * fy;
      const auto found = known.find(r2);
      const double h =
          found != known.end() ? found->second : (known[r2] = lens.otf(Stage::presample, {std::sqrt(r2), 0.0}).re);
      const Complex<double> other = rest.otf(Stage::presample, {fx, fy});
      return h * std::complex<double>(other.re, other.im);
    });
  });
}

PlanOptions options_with(const Image& scene, const Image& range_m, double tolerance, Border border = Border::reflect) {
  PlanOptions options = options_for(scene, border, tolerance);
  options.range_m = std::make_shared<const Image>(range_m.clone());
  return options;
}

/// A plan, for the tolerance that a refusal names where that asked for cannot be kept; and that tolerance.
std::pair<Plan, double> planned(const System<double>& s, const SampleGrid& in, const SampleGrid& out,
                                PlanOptions options) {
  try {
    return {compile(s, in, out, options), options.tolerance};
  } catch (const UnreachableTolerance& refused) {
    options.tolerance = refused.reachable();
  }
  return {compile(s, in, out, options), options.tolerance};
}

/// A ground that comes nearer from row to row, from `waves` behind the focus to as much before it, and two objects.
/// Ranges of a row are the same along the ray, so that every sample has its own along the axis.
Image ranges_about(double waves, std::int64_t width, std::int64_t height, bool steps) {
  return image_of(width, height, [=](auto x, auto y) {
    if (steps && x >= width / 4 && x < width / 2 && y >= height / 4 && y < 2 * height / 3) return range_of(0.3 * waves);
    if (steps && x >= 2 * width / 3 && y < height / 3) return range_of(-waves);
    return range_of(waves * (2.0 * (static_cast<double>(y) + 0.5) / static_cast<double>(height) - 1.0));
  });
}

TEST(RangeBlur, GoldenPixels) {
  const std::vector<Golden> rows = golden("range_blur");
  if (rows.empty()) GTEST_SKIP() << "the shared data are not there";
  System<double> s = bare(15.0, 15.0);
  s.add(Stage::presample, test::gaussian(0.525 * 15.0));
  const Image scene = image_of(6, 4, [](auto x, auto y) { return (7 * x + 3 * y + x * y) % 11 - 4; });
  const SampleGrid grid{6, 4, 15.0, 15.0};
  SamplesOtf otf{along_line(s, 0, "sigma", 0.3 * 15.0, 0.75 * 15.0)};
  std::vector<double> sigma;
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 6; ++x) {
      sigma.push_back((0.3 + 0.15 * ((x + 2 * y) % 4)) * 0.015);  // mm
      otf.place.push_back(((x + 2 * y) % 4 - 1.5) / 1.5);
    }
  const std::vector<double> slow = spread(scene, sigma, grid, grid, Border::reflect, [](double sigma_mm) {
    return Otf([=](double fx, double fy) {
      return std::complex<double>(std::exp(-2.0 * kPi * kPi * sigma_mm * sigma_mm * (fx * fx + fy * fy)));
    });
  });
  for (const Golden& row : rows) {
    const std::vector<double> at = numbers_in(row.where);
    EXPECT_NEAR(slow[static_cast<std::size_t>(at[1] * 6 + at[0])], row.value, 1e-13) << row.where;
  }
  for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-4}) {
    const PlanOptions options = options_for(scene, Border::reflect, tolerance);
    const Plan plan = compile_over_samples(otf, grid, grid, options);
    EXPECT_EQ(plan.report().method, "field_modes");
    EXPECT_LE(plan.report().predicted.total(), tolerance);
    EXPECT_LE(rms_distance(run(plan, scene), slow), plan.report().predicted.total() * options.scene->std);
  }
}

// The promise, and that few modes keep it.
TEST(RangeBlur, EachSampleSpreadsByItsOwnDefocus) {
  struct Case {
    double waves;
    bool steps;
    int ratio;
    std::size_t most_modes;  // at a tolerance of 1e-4
  };
  for (const Case& c : {Case{0.25, false, 1, 8},
                        {1.0, false, 1, 10},
                        {1.0, true, 1, 10},
                        {1.0, true, 2, 10},
                        {3.0, true, 1, 16},
                        {3.0, true, 2, 16}}) {
    SCOPED_TRACE(testing::Message() << c.waves << " waves, steps " << c.steps << ", ratio " << c.ratio);
    const System<double> s = by_range();
    const std::int64_t side = c.waves > 0.5 && c.steps && c.ratio == 1 ? 24 : 16;
    const Image scene = random_image(side, side, 5), range_m = ranges_about(c.waves, side, side, c.steps);
    const SampleGrid in = scene_grid(s, side, side, c.ratio, c.ratio), out{side / c.ratio, side / c.ratio, 15.0, 15.0};
    const std::vector<double> slow = definition(s, scene, range_m, in, out, Border::reflect);
    const double std = summarise(scene.view(), Border::reflect, 0.0)->std;
    double before = 1e300;
    for (const double tolerance : {1e-2, 1e-4}) {
      const auto [plan, asked] = planned(s, in, out, options_with(scene, range_m, tolerance));
      const double promised = plan.report().predicted.total(), realised = rms_distance(run(plan, scene), slow) / std;
      EXPECT_LE(promised, asked);
      EXPECT_LE(asked, std::max(tolerance, 1e-3));  // what float32 leaves
      EXPECT_LE(realised, promised);
      before = realised;
      if (tolerance == 1e-4) {
        EXPECT_LE(plan.report().field.modes, c.most_modes);
      }
    }
    EXPECT_LT(before, 1e-6);  // all there is, in single precision
  }
}

TEST(RangeBlur, UniformScenesAreExact) {
  const System<double> s = by_range();
  const Image range_m = ranges_about(3.0, 32, 24, true), scene = random_image(32, 24, 3);
  const SampleGrid in = scene_grid(s, 32, 24, 2, 2), out{16, 12, 15.0, 15.0};
  const Plan plan = compile(s, in, out, options_with(scene, range_m, 1e-2));
  ASSERT_GT(plan.report().field.modes, 0U);
  const Image image = run(plan, image_of(32, 24, [](auto, auto) { return 300.1; }));
  for (std::int64_t i = 0; i < image.size(); ++i) EXPECT_EQ(image.data()[i], 300.1F);
  // A part of a scene that is uniform is not the mean.
  const Image half = image_of(32, 24, [](auto x, auto) { return x < 24 ? 2.0 : 1.0; });
  const Image seen = run(compile(s, in, out, options_with(half, range_m, 1e-3)), half);
  for (std::int64_t y = 0; y < 12; ++y) EXPECT_NEAR(seen.at(1, y), 2.0, 1e-2);
}

TEST(RangeBlur, ThreadsDoNotCount) {
  const System<double> s = by_range();
  const Image range_m = ranges_about(1.0, 80, 64, true), scene = random_image(80, 64, 5);
  const SampleGrid in = scene_grid(s, 80, 64, 2, 2), out{40, 32, 15.0, 15.0};
  PlanOptions options = options_with(scene, range_m, 1e-3);
  const Plan one = compile(s, in, out, options);
  options.threads = 2;
  const Plan two = compile(s, in, out, options);
  ASSERT_GT(one.report().field.modes, 0U);
  EXPECT_TRUE(same_bits(run(one, scene, 0.0, 1), run(two, scene, 0.0, 2)));
  Image own = scene.clone();  // in the memory of the scene, as chains run
  one.run(own.view(), {own.data(), 40, 32, 40}, 0.0, 2);
  own.reshape(40, 32);
  EXPECT_TRUE(same_bits(own, run(one, scene)));
}

TEST(RangeBlur, SkyIsInfinitelyFar) {
  const System<double> s = by_range();
  const Image scene = random_image(16, 16, 8),
              range_m = image_of(16, 16, [](auto, auto y) { return y < 8 ? kSky : 100.0F - static_cast<float>(y); });
  const SampleGrid in = scene_grid(s, 16, 16, 1, 1), out{16, 16, 15.0, 15.0};
  const PlanOptions options = options_with(scene, range_m, 1e-3);
  const Plan plan = compile(s, in, out, options);
  EXPECT_EQ(plan.report().field.ranges->farthest_m, std::numeric_limits<double>::infinity());
  EXPECT_LE(rms_distance(run(plan, scene), definition(s, scene, range_m, in, out, Border::reflect)),
            plan.report().predicted.total() * options.scene->std);
  expect_says(plan.explain(), {"to inf m", "modes, from OTFs at"});
}

// Today's plan, bit for bit, where all samples have one range, and where the spread of ranges does not matter.
TEST(RangeBlur, OneDefocusIsThePlanOfOneDefocus) {
  System<double> s = by_range();
  const Image scene = random_image(16, 12, 8);
  const SampleGrid in = scene_grid(s, 16, 12, 2, 2), out{8, 6, 15.0, 15.0};
  const auto isoplanatic = [&](double distance_um, double tolerance) {
    System<double> same = s;
    Defocus<double> defocus;
    defocus.distance_um = micrometres(distance_um);
    same.list(Stage::presample)[0].component = defocus;
    return run(compile(same, in, out, options_for(scene, Border::reflect, tolerance)), scene);
  };
  const Plan sky = compile(s, in, out, options_with(scene, image_of(16, 12, [](auto, auto) { return kSky; }), 1e-4));
  EXPECT_EQ(sky.report().field.modes, 0U);
  EXPECT_TRUE(same_bits(run(sky, scene), isoplanatic(-1e4 / 15.0, 1e-4)));
  const Image near = image_of(16, 12, [](auto x, auto) { return 20.0 + 1e-5 * static_cast<double>(x); });
  const Plan plan = compile(s, in, out, options_with(scene, near, 1e-2));
  EXPECT_EQ(plan.report().field.modes, 0U);
  const double mean = sample_ranges(s, in, out, near.view()).mean;
  EXPECT_TRUE(same_bits(run(plan, scene), isoplanatic(1e4 * (mean - 1.0 / 15.0), 1e-2)));
  EXPECT_GT(plan.report().field.one_otf_error, 0.0);
  EXPECT_LE(rms_distance(run(plan, scene), definition(s, scene, near, in, out, Border::reflect)),
            plan.report().predicted.total());
  expect_says(plan.explain(), {"one defocus, that of the mean, serves all samples"});
  // A plan of a changed system keeps to the ranges.
  System<double> other = s;
  other.optics.f_number = 1.5;
  EXPECT_TRUE(
      same_bits(run(plan.with(other), scene), run(compile(other, in, out, options_with(scene, near, 1e-2)), scene)));
}

// Ranges from 1 m to 100 km in any order: the cause is the defocus, not the contrast of the scene.
TEST(RangeBlur, RangesAreNamedAsTheCause) {
  const System<double> s = by_range();
  std::mt19937 random(3);
  const Image point = image_of(32, 32, [](auto x, auto y) { return x == 20 && y == 11 ? 1001.0 : 1.0; }),
              any = image_of(32, 32,
                             [&](auto, auto) { return std::pow(10.0, static_cast<double>(random() % 5001) * 1e-3); });
  const SampleGrid in = scene_grid(s, 32, 32, 4, 4), out{8, 8, 15.0, 15.0};
  expect_says(
      message_of<UnreachableTolerance>([&] { static_cast<void>(compile(s, in, out, options_with(point, any, 1e-4))); }),
      {"from sample to sample"});
}

TEST(RangeBlur, OneSample) {
  const System<double> s = by_range();
  const SampleGrid in = scene_grid(s, 1, 1, 1, 1), out{1, 1, 15.0, 15.0};
  Image scene(1, 1), range_m(1, 1);
  scene.at(0, 0) = 7.25F, range_m.at(0, 0) = 20.0F;
  EXPECT_EQ(run(compile(s, in, out, options_with(scene, range_m, 1e-3)), scene).at(0, 0), 7.25F);
}

// Along the axis is Z times the cosine of the ray, which goes by the detector's middle and its optical axis.
TEST(RangeBlur, RangesAreAlongTheAxis) {
  System<double> s = by_range();
  s.frame = {0.1, 20.0, 10.0, 0.01, 6, 4};  // 0.1 mm: rays up to 31 degrees from the axis
  s.field.axis_x_px = 1.0;
  const SampleGrid in{12, 8, 10.0, 5.0}, out{6, 4, 20.0, 10.0};
  const SampleRanges ranges = sample_ranges(s, in, out, image_of(12, 8, [](auto, auto) { return 4.0; }).view());
  const double x = -75.0, y = -17.5;  // um, of the first sample from the axis at (80, 20)
  EXPECT_NEAR(ranges.per_m.front(), std::sqrt(1.0 + (x * x + y * y) / 1e4) / 4.0, 1e-15);
  EXPECT_NEAR(ranges.per_m[7 + 12 * 4], std::sqrt(1.0 + (25.0 + 6.25) / 1e4) / 4.0, 1e-15);
  EXPECT_EQ(ranges.most, ranges.per_m.front());
  // W020 = D^2 / (8 lambda) (1/range - 1/focus), in the component's own words distance / (8 N^2 lambda).
  s = by_range();
  EXPECT_NEAR(distance_at_um(s, 1.0 / range_of(2.5)) / (8.0 * 4.0 * 4.0), 2.5, 1e-12);
}

TEST(RangeBlur, WhatCannotBeIsRefused) {
  System<double> s = by_range();
  const Image scene = random_image(16, 16, 3), range_m = ranges_about(1.0, 16, 16, true);
  const SampleGrid in = scene_grid(s, 16, 16, 1, 1), out{16, 16, 15.0, 15.0};
  const auto refused = [&](const System<double>& system, const PlanOptions& options,
                           std::initializer_list<std::string_view> parts) {
    expect_says(message_of<UsageError>([&] { static_cast<void>(compile(system, in, out, options)); }), parts);
  };
  PlanOptions options = options_for(scene, Border::reflect, 1e-3);
  refused(s, options, {"presample[0].focus", "channel Z"});
  for (const float z : {0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN(), -kSky}) {
    Image wrong = range_m.clone();
    wrong.at(3, 5) = wrong.at(4, 5) = z;
    refused(s, options_with(scene, wrong, 1e-3), {"channel Z", "2 samples", "column 3, row 5"});
  }
  refused(s, options_with(scene, image_of(16, 15, [](auto, auto) { return 5.0; }), 1e-3), {"16x15", "16x16"});
  refused(s, options_with(scene, range_m, 1e-3, Border::constant), {"presample[0].focus", "constant border"});
  Image tiny = range_m.clone();
  tiny.at(0, 0) = 1e-9F;
  refused(s, options_with(scene, tiny, 1e-3), {"channel Z", "focal length of 0.1 m", "column 0, row 0"});
  tiny.at(0, 0) = 0.1F;  // at the focal point, whose image is at infinity
  refused(s, options_with(scene, tiny, 1e-3), {"channel Z", "focal length of 0.1 m", "column 0, row 0"});
  options = options_with(scene, range_m, 1e-3);
  options.method = Method::separable;
  refused(s, options, {"separable", "--method"});
  options.method = Method::field_tiles;
  refused(s, options, {"field_tiles", "--method"});
  expect_says(message_of<UsageError>([&] { refuse_range(s, "a fit"); }), {"a fit", "presample[0].focus"});
  expect_says(message_of<UsageError>(
                  [&] { static_cast<void>(compile_part(s, in, out, options_for(scene, Border::reflect, 1e-3), {})); }),
              {"--memory", "presample[0].focus"});
  System<double> two = s;
  two.add(Stage::presample, Component<double>::make("diffraction"));
  refused(two, options_with(scene, range_m, 1e-3), {"diffraction"});
  System<double> varied = s;
  varied.list(Stage::presample)[1].component = test::gaussian(6.0);
  varied.field.numbers.push_back({.entry = 1, .field = 0, .coefficient = {0.0, 0.0, 0.0, 2.0}});
  refused(varied, options_with(scene, range_m, 1e-3), {"defocus by range", "presample[1].sigma"});
  Defocus<double> both;
  both.focus_m = metres(5.0);
  both.waves = 1.0;
  s.list(Stage::presample)[0].component = both;
  refused(s, options_with(scene, range_m, 1e-3), {"exactly one of waves, distance, focus"});
}

/// Realised <= predicted <= tolerance, or a refusal whose tolerance is accepted.
void keeps_its_promise(unsigned seed) {
  SCOPED_TRACE(seed);
  std::mt19937 generator(seed);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(generator); };
  const auto below = [&](unsigned n) { return static_cast<int>(generator() % n); };
  System<double> s = by_range(below(2) == 0 ? 15.0 : 0.0);
  if (below(3) == 0) s.add(Stage::presample, rc(15.0, 0));  // its OTF has a phase
  const bool band = below(4) == 0;
  if (band) {
    s.band = Band{3.5, 4.5};
    s.optics.wavelength_um.reset();
  }
  // Of a band the definition takes its time.
  const int ratio = band ? 1 : 1 + below(2), columns = band ? 6 : 6 + below(4), rows = band ? 5 : 5 + below(4);
  const double waves = uniform(0.05, 2.5);
  const Border border = std::array{Border::reflect, Border::replicate, Border::periodic}[below(3)];
  const Image scene = random_image(columns * ratio, rows * ratio, seed, below(3) == 0 ? 100.0 : 0.0);
  Image range_m = ranges_about(waves, scene.width(), scene.height(), below(2) == 0);
  if (below(3) == 0)  // every sample for itself
    for (std::int64_t i = 0; i < range_m.size(); ++i)
      range_m.data()[i] = static_cast<float>(range_of(uniform(-waves, waves)));
  const SampleGrid in = scene_grid(s, scene.width(), scene.height(), ratio, ratio), out{columns, rows, 15.0, 15.0};
  const PlanOptions options = options_with(scene, range_m, std::pow(10.0, uniform(-4.5, -1.0)), border);
  const auto [plan, asked] = planned(s, in, out, options);
  const double promised = plan.report().predicted.total();
  EXPECT_LE(promised, asked);
  EXPECT_LE(rms_distance(run(plan, scene), definition(s, scene, range_m, in, out, border)) / options.scene->std,
            promised);
}

TEST(RangeBlur, RandomCasesKeepTheirPromise) {
  for (unsigned seed = 1; seed <= 12; ++seed) keeps_its_promise(seed);
}

TEST(RangeBlurLong, RandomCasesKeepTheirPromise) {
  for (unsigned seed = 13; seed <= 60; ++seed) keeps_its_promise(seed);
}

TEST(RangeBlur, FiltersAfterTheSamplingStayWhatTheyAre) {
  System<double> s = by_range();
  s.add(Stage::postsample, fir({{0.0, -0.25, 0.0}, {-0.25, 2.0, -0.25}, {0.0, -0.25, 0.0}}));
  const Image scene = random_image(16, 16, 11), range_m = ranges_about(1.0, 16, 16, true);
  const SampleGrid in = scene_grid(s, 16, 16, 1, 1), out{16, 16, 15.0, 15.0};
  const PlanOptions options = options_with(scene, range_m, 1e-3);
  const SensorPlan plan = compile_sensor(s, in, options);
  const Image image = plan.run(SceneView{scene.view(), pixels(1.0)}, 1);
  const std::vector<double> sampled = definition(s, scene, range_m, in, out, Border::reflect),
                            sharp = reference_image(
                                [&](std::int64_t x, std::int64_t y) {
                                  return sampled[static_cast<std::size_t>(y * 16 + x)];
                                },
                                out, out, otf_of(s, Stage::postsample), Border::reflect);
  EXPECT_LE(rms_distance(image, sharp), plan.predicted_error * options.scene->std);
}

}  // namespace
}  // namespace mtf::test
