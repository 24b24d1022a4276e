// SPDX-License-Identifier: Apache-2.0
// Every method, insisted on, against the exact definition of its result: realised rms error <= promised <= tolerance.
// And what a plan says when a method is impossible.

#include "mtf/engines/fft/scene_spectrum.h"
#include "mtf/plan/point_response.h"
#include "tests/expect_error.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

constexpr std::array kTaps{Method::separable, Method::low_rank, Method::direct_square, Method::direct_disc,
                           Method::direct_diamond};

struct Work {
  System<double> system;
  double ratio;
  double tolerance;
};

// Point spreads of a few samples: separable, radial (not separable), asymmetric.
std::vector<Work> works() {
  std::vector<Work> list;
  for (const double tolerance : {3e-2, 1e-3}) {
    list.push_back({with(bare(), {gaussian(9.0)}), 1.0, tolerance});
    list.push_back({with(bare(15.0, 15.0), {gaussian(12.0), footprint(15.0)}), 2.0, tolerance});
    System<double> optics = with(bare(15.0, 15.0), {Component<double>::make("diffraction"), gaussian(7.0)});
    optics.optics.f_number = 6.0;
    list.push_back({optics, 1.0, tolerance});
    list.push_back({optics, 3.0, tolerance});
    list.push_back({with(bare(15.0, 15.0), {gaussian(9.0), rc(30.0, 0)}), 1.0, tolerance});
    list.push_back({with(bare(15.0, 15.0), {gaussian(9.0), motion(20.0, 30.0)}), 2.0, tolerance});
  }
  return list;
}

class EveryMethod : public testing::TestWithParam<Border> {};

TEST_P(EveryMethod, keeps_its_promise) {
  const Border border = GetParam();
  int tried = 0;
  std::array<int, kMethodNames.size()> done{};
  for (const Work& work : works())
    for (const bool natural : {false, true}) {
      const SampleGrid in = scene_grid(work.system, 41, 36, work.ratio, work.ratio);
      const SampleGrid out = detector_grid(work.system, in);
      Image scene = random_image(in.width, in.height, 7, 20.0, 3.0);
      if (natural)
        scene = image_of(in.width, in.height, [](auto x, auto y) {
          return 5.0 + std::sin(0.11 * static_cast<double>(x)) + 0.7 * std::cos(0.07 * static_cast<double>(y)) +
                 (x > 30 ? 0.4 : 0.0);
        });
      PlanOptions options = options_for(scene, border, work.tolerance, 18.0);
      if (natural) options.spectrum = scene_spectrum(scene.view(), border);
      const auto expected = reference_image(scene, in, out, otf_of(work.system, Stage::presample), border, 18.0);
      const Plan chosen = compile(work.system, in, out, options);
      for (const Candidate& candidate : chosen.report().candidates) {
        ++tried;
        options.method = candidate.method;
        if (!candidate.possible) {
          EXPECT_THROW(compile(work.system, in, out, options), UsageError);
          continue;
        }
        const Plan plan = compile(work.system, in, out, options);
        EXPECT_EQ(plan.report().method, kMethodNames[static_cast<std::size_t>(candidate.method)]);
        const double rms = rms_distance(run(plan, scene, 18.0), expected) / options.scene->std;
        const double promised = plan.report().predicted.total();
        EXPECT_LE(rms, promised) << plan.explain();
        EXPECT_LE(promised, work.tolerance);
        ++done[static_cast<std::size_t>(candidate.method)];
      }
    }
  EXPECT_GT(tried, 50);
  for (const Method method : kTaps) EXPECT_GT(done[static_cast<std::size_t>(method)], 0) << static_cast<int>(method);
}

INSTANTIATE_TEST_SUITE_P(Borders, EveryMethod, testing::ValuesIn(kBorders), [](const auto& test) {
  return std::string(kBorderNames[static_cast<std::size_t>(test.param)]);
});

TEST(PlanMethods, same_bits_for_any_threads_and_tiles_that_are_flat) {
  const System<double> system = with(bare(15.0, 15.0), {gaussian(22.0), footprint(15.0)});
  const SampleGrid in = scene_grid(system, 700, 600, 1.0, 1.0);
  // A flat left half: tiles there are filled, and equal the value exactly.
  const Image scene = image_of(
      in.width, in.height, [](auto x, auto y) { return x < 400 ? 7.25 : 7.25 + std::sin(static_cast<double>(x * y)); });
  PlanOptions options = options_for(scene, Border::reflect, 1e-2);
  for (const Method method : {Method::separable, Method::direct_square, Method::direct_disc}) {
    options.method = method;
    const Plan plan = compile(system, in, detector_grid(system, in), options);
    const Image one = run(plan, scene, 0.0, 1);
    EXPECT_TRUE(same_bits(one, run(plan, scene, 0.0, 3)));
    for (std::int64_t y = 0; y < one.height(); y += 7)
      for (std::int64_t x = 0; x < 256; x += 5) EXPECT_EQ(one.at(x, y), 7.25F);
  }
}

TEST(PlanMethods, a_method_that_cannot_says_why) {
  const System<double> system = with(bare(15.0, 15.0), {gaussian(22.0)});
  PlanOptions options;
  options.tolerance = 3e-3;
  const auto message = [&](Method method, double ratio) {
    options.method = method;
    const SampleGrid in = scene_grid(system, 64, 64, ratio, ratio);
    try {
      compile(system, in, detector_grid(system, in), options);
    } catch (const UsageError& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  expect_says(message(Method::separable, 1.7), {"whole samples"});
  expect_says(message(Method::low_rank, 1.0), {"factors exactly"});
  expect_says(message(Method::identity, 1.0), {"identity"});
  EXPECT_EQ(message(Method::separable, 1.0), "accepted");
}

TEST(SceneSpectrum, rms_of_an_error_is_that_of_the_filtered_scene) {
  // A single cosine of the mirror: all power in one cell, so that the error is |D| there.
  const std::int64_t w = 96, h = 80;
  const Image scene = image_of(w, h, [&](auto x, auto y) {
    return 3.0 + std::cos(M_PI * 30.0 * (static_cast<double>(x) + 0.5) / static_cast<double>(w)) *
                     std::cos(M_PI * 10.0 * (static_cast<double>(y) + 0.5) / static_cast<double>(h));
  });
  const auto spectrum = scene_spectrum(scene.view(), Border::reflect);
  ASSERT_TRUE(spectrum);
  constexpr int kCells = SceneSpectrum::kCells, kColumns = SceneSpectrum::kColumns, kRows = SceneSpectrum::kRows;
  std::vector<double> error(static_cast<std::size_t>(kColumns * kRows));
  const auto value = [](double fx, double fy) { return 0.3 * fx * fx + 0.1 * fy * fy; };
  for (int j = 0; j < kRows; ++j)
    for (int i = 0; i < kColumns; ++i)
      error[static_cast<std::size_t>(j * kColumns + i)] =
          value(static_cast<double>(i) / kCells, static_cast<double>(j - kCells) / kCells);
  const double exact = value(30.0 / static_cast<double>(w), 10.0 / static_cast<double>(h));
  const double bound = spectrum->rms_error(error, 1.0, 1.0);
  EXPECT_GE(bound, exact);
  EXPECT_LE(bound, 1.35 * exact);  // the largest corner of the cell, and the margin between corners
  EXPECT_GE(SceneSpectrum::worst_error(error, 1.0, 1.0), 0.4);
}

TEST(SceneSpectrum, power_sums_to_the_variance) {
  for (const Border border : {Border::reflect, Border::periodic})
    for (const auto& [w, h] : {std::pair<std::int64_t, std::int64_t>{64, 48}, {61, 47}, {1, 30}, {17, 1}}) {
      const Image scene = random_image(w, h, 3, 100.0, 5.0);
      const auto spectrum = scene_spectrum(scene.view(), border);
      ASSERT_TRUE(spectrum);
      const std::vector<double> ones(static_cast<std::size_t>(SceneSpectrum::kColumns * SceneSpectrum::kRows), 1.0);
      EXPECT_NEAR(spectrum->rms_error(ones, 1.0, 1.0), 1.1, 1e-4) << w << "x" << h;  // the margin between corners
    }
  EXPECT_FALSE(scene_spectrum(random_image(8, 8, 1).view(), Border::constant));
  EXPECT_FALSE(scene_spectrum(image_of(8, 8, [](auto, auto) { return 2.0; }).view(), Border::reflect));
}

// Of kernels taller than wide and wider than tall: all terms together are the kernel, none is left over, and the terms
// of a kernel that equals its mirror images do so too.
TEST(SeparableTerms, add_up_to_kernels_that_are_not_square) {
  for (const auto& [rows, columns] : {std::pair<std::int64_t, std::int64_t>{7, 3}, {4, 6}, {5, 5}, {1, 4}}) {
    TapBox kernel{rows, columns, {}};
    for (std::int64_t r = 0; r < rows; ++r)
      for (std::int64_t c = 0; c < columns; ++c) {
        const double y = static_cast<double>(2 * r - rows + 1), x = static_cast<double>(2 * c - columns + 1);
        kernel.value.push_back(1.0 / (1.0 + x * x + 0.3 * y * y));
      }
    const SeparableTerms terms = separable_terms(kernel, 9);
    ASSERT_EQ(terms.along_x.size(), static_cast<std::size_t>(std::min(rows, columns)));
    const TapBox sum = product_of(terms, terms.along_x.size());
    for (std::size_t i = 0; i < kernel.value.size(); ++i) EXPECT_NEAR(sum.value[i], kernel.value[i], 1e-14);
    for (const auto& taps : {terms.along_x.front(), terms.along_y.front()})
      EXPECT_EQ(taps, std::vector<double>(taps.rbegin(), taps.rend()));
    EXPECT_GT(std::abs(product_of(terms, 1).value[0] - kernel.value[0]), rows > 1 ? 1e-3 : -1.0);
  }
}

}  // namespace
}  // namespace mtf::test
