// SPDX-License-Identifier: Apache-2.0
// Scenes that are flat in parts: what plans leave out there keeps the promise, for every possible method, every border,
// on plans for this scene and on scenes that a plan was not made for.
#include <limits>

#include "apps/check/reference_fft.h"
#include "mtf/engines/fft/line_groups.h"
#include "mtf/engines/fft/scene_spectrum.h"
#include "mtf/engines/mean_and_deviation.h"
#include "mtf/engines/uniform_runs.h"
#include "tests/expect_error.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

constexpr std::int64_t kWidth = 149, kHeight = 118;

struct Part {
  const char* name;
  Region busy;
};
// Touching each side, none, a pixel, all.
const std::vector<Part> kParts{
    {"right half", {75, 0, 74, 118}}, {"left half", {0, 0, 74, 118}},   {"bottom", {0, 60, 149, 58}},
    {"top", {0, 0, 149, 58}},         {"target", {60, 40, 30, 20}},     {"corner", {0, 90, 40, 28}},
    {"pixel", {101, 17, 1, 1}},       {"last pixel", {148, 117, 1, 1}}, {"all", {0, 0, 149, 118}}};

// `contrast` times noise within the part, `value` elsewhere.
Image scene_of(const Region& busy, double value, double contrast, unsigned seed = 5) {
  const Image noise = random_image(kWidth, kHeight, seed, 0.0, contrast);
  return image_of(kWidth, kHeight, [&](std::int64_t x, std::int64_t y) {
    const bool in = x >= busy.x && x < busy.x + busy.width && y >= busy.y && y < busy.y + busy.height;
    return value + (in ? static_cast<double>(noise.at(x, y)) + 3.0 * contrast : 0.0);
  });
}

std::vector<double> reference(const System<double>& system, const Image& scene, const SampleGrid& in,
                              const SampleGrid& out, Border border, double border_value) {
  return apps::check::reference_image_fft(scene.view(), in, out,
                                          apps::check::exact_otf(system, {Stage::presample}, SceneAperture{}, in),
                                          border, border_value, 1);
}

// Not separable: motion at an angle.
System<double> blur() { return with(bare(15.0, 15.0), {gaussian(27.0), motion(20.0, 30.0)}); }
System<double> separable_blur() { return with(bare(15.0, 15.0), {gaussian(27.0), footprint(12.0)}); }

// Every method that promises to keep the tolerance for this scene keeps it when it runs; `needed` is among them.
void check_all_methods(const System<double>& system, const Image& scene, double ratio, Border border,
                       double border_value, double tolerance, Method needed) {
  const SampleGrid in = scene_grid(system, kWidth, kHeight, ratio, ratio), out = detector_grid(system, in);
  PlanOptions options = options_for(scene, border, tolerance, border_value);
  ASSERT_TRUE(options.scene.has_value());
  options.spectrum = scene_spectrum(scene.view(), border, 1);
  const std::vector<double> expected = reference(system, scene, in, out, border, border_value);
  const Plan best = compile(system, in, out, options);
  bool found = false;
  for (const Candidate& candidate : best.report().candidates) {
    if (!candidate.possible) continue;
    options.method = candidate.method;
    found = found || candidate.method == needed;
    const Plan plan = compile(system, in, out, options);
    const Image image = run(plan, scene, border_value);
    EXPECT_LE(rms_distance(image, expected), plan.report().predicted.total() * options.scene->std)
        << kBorderNames[static_cast<std::size_t>(border)] << ", ratio " << ratio << "\n"
        << plan.explain();
    EXPECT_TRUE(same_bits(image, run(plan, scene, border_value, 2)));
  }
  EXPECT_TRUE(found) << best.explain();
}

// Both ratios with every border, and with every part, but not in all combinations.
TEST(PlanFlatParts, every_method_keeps_the_promise) {
  for (std::size_t p = 0; p < kParts.size(); ++p)
    for (const Border border : kBorders) {
      SCOPED_TRACE(kParts[p].name);
      const double ratio = (p + static_cast<std::size_t>(border)) % 2 == 0 ? 1.0 : 2.0;
      const Image scene = scene_of(kParts[p].busy, 300.0, 20.0);
      for (const double beyond : {300.0, 250.0}) {
        check_all_methods(blur(), scene, ratio, border, beyond, 1e-3, Method::fft_float);
        check_all_methods(separable_blur(), scene, ratio, border, beyond, 1e-3, Method::separable);
        if (border != Border::constant) break;
      }
    }
}

TEST(PlanFlatParts, little_contrast_on_a_large_mean) {
  for (const Part& part : kParts)
    for (const Border border : {Border::reflect, Border::replicate})
      check_all_methods(separable_blur(), scene_of(part.busy, 1e5, 20.0), 1.0, border, 1e5, 5e-2, Method::separable);
}

// Several values, none of them the mean; blocks that are smaller than a tile.
TEST(PlanFlatParts, uniform_parts_of_several_values) {
  const Image noise = random_image(kWidth, kHeight, 3);
  const Image scene = image_of(kWidth, kHeight, [&](std::int64_t x, std::int64_t y) {
    const std::int64_t block = (x / 37 + y / 29) % 3;
    return block == 0 ? -4.0 : block == 1 ? 7.0 : static_cast<double>(noise.at(x, y));
  });
  for (const Border border : kBorders)
    check_all_methods(separable_blur(), scene, 1.0, border, 7.0, 1e-3, Method::separable);
}

TEST(PlanFlatParts, outputs_whose_taps_read_one_value_are_exact) {
  const Image scene = scene_of({75, 0, 74, 118}, 300.0, 20.0);
  for (const Border border : {Border::reflect, Border::replicate}) {
    PlanOptions options = options_for(scene, border, 1e-3);
    options.method = Method::separable;
    const System<double> system = separable_blur();
    const SampleGrid in = scene_grid(system, kWidth, kHeight, 1.0, 1.0);
    const Image image = run(compile(system, in, in, options), scene);
    for (std::int64_t y = 0; y < kHeight; ++y)
      for (std::int64_t x = 0; x < 32; ++x) ASSERT_EQ(image.at(x, y), 300.0F);
  }
}

// The rows that are left out are chosen on the scene that runs, whatever scene the plan was made for.
TEST(PlanFlatParts, plan_for_one_scene_keeps_the_promise_for_others) {
  const System<double> system = with(blur(), {Component<double>::make("diffraction")});
  const SampleGrid in = scene_grid(system, kWidth, kHeight, 1.0, 1.0);
  const Image scene = scene_of({0, 80, 149, 38}, 300.0, 20.0);
  for (const Border border : kBorders) {
    PlanOptions options = options_for(scene, border, 1e-3, 300.0);
    options.method = Method::fft_float;
    const Plan plan = compile(system, in, in, options);
    EXPECT_GT(plan.report().predicted.flat, 0.0) << plan.explain();
    expect_says(plan.explain(), {"rows that are of"});
    for (const Image& other : {scene_of({0, 80, 149, 38}, 300.0, 20.0, 8), scene_of({0, 0, 149, 30}, -5.0, 0.5),
                               scene_of({40, 50, 9, 9}, 0.0, 1.0), scene_of({0, 0, 149, 118}, 300.0, 20.0)}) {
      const Image image = run(plan, other, 300.0);
      const PlanOptions its_own = options_for(other, border, 1e-3, 300.0);
      const double harder =
          its_own.scene->canvas_norm / its_own.scene->std / (options.scene->canvas_norm / options.scene->std);
      EXPECT_LE(rms_distance(image, reference(system, other, in, in, border, 300.0)),
                1e-3 * std::max(1.0, harder) * its_own.scene->std)
          << kBorderNames[static_cast<std::size_t>(border)];
      EXPECT_TRUE(same_bits(image, run(plan, other, 300.0, 2)));
    }
    // A scene without flat parts gets all that it would get from a plan that knows of none.
    options.scene->flat_rows = 0.0;
    const Image noise = random_image(kWidth, kHeight, 2);
    EXPECT_TRUE(same_bits(run(plan, noise, 300.0), run(compile(system, in, in, options), noise, 300.0)));
  }
}

// Where more columns than rows are flat, columns are transformed first: the same image within the promise, at whole
// ratios and others, in float and in double, for other scenes and systems too, whatever the OTF's parts and the border.
TEST(PlanFlatParts, columns_are_lines_where_more_of_them_are_flat) {
  const auto system_of = [](std::initializer_list<Component<double>> more) {
    return with(with(bare(15.0, 15.0), {Component<double>::make("diffraction"), footprint(12.0)}), more);
  };
  const std::vector<System<double>> systems{system_of({}), system_of({motion(20.0, 30.0)}), system_of({rc(40.0, 0)}),
                                            system_of({rc(40.0, 1)}), system_of({rc(40.0, 0), rc(60.0, 1)})};
  const System<double> blurred = system_of({gaussian(9.0)});
  const Image scene = scene_of({120, 0, 29, 118}, 300.0, 20.0), whole = scene_of({0, 0, 149, 118}, 300.0, 20.0);
  for (std::size_t s = 0; s < systems.size(); ++s)
    for (const Border border : kBorders)
      for (const double ratio : {1.0, 2.0, 1.7})
        for (const Method method : {Method::fft_float, Method::fft_double}) {
          if ((s > 0 && ratio == 2.0) || (border != Border::reflect && method == Method::fft_double)) continue;
          SCOPED_TRACE(testing::Message() << "system " << s << ", " << kBorderNames[static_cast<std::size_t>(border)]
                                          << ", ratio " << ratio << (method == Method::fft_double ? ", double" : ""));
          const SampleGrid in = scene_grid(systems[s], kWidth, kHeight, ratio, ratio),
                           out = detector_grid(systems[s], in);
          PlanOptions options = options_for(scene, border, 1e-3, 300.0);
          options.method = method;
          const Plan plan = compile(systems[s], in, out, options);
          const auto check = [&](const Plan& one, const System<double>& its, const Image& image) {
            EXPECT_LE(rms_distance(run(one, image, 300.0), reference(its, image, in, out, border, 300.0)),
                      1e-3 * options_for(image, border, 1e-3, 300.0).scene->std)
                << one.explain();
            EXPECT_TRUE(same_bits(run(one, image, 300.0), run(one, image, 300.0, 2)));
          };
          check(plan, systems[s], scene);
          if (border == Border::reflect) check(plan, systems[s], whole);
          if (s == 0) check(plan.with(blurred), blurred, scene);
          if (ratio == 1.0) {
            expect_says(plan.explain(), {"columns that are of"});
          }
        }
}

// Where columns first would take more than leaving out the flat ones saves, rows come first.
TEST(PlanFlatParts, columns_are_lines_only_where_that_is_cheaper) {
  const System<double> phase_along_y = with(bare(15.0, 15.0), {Component<double>::make("diffraction"), rc(40.0, 1)});
  const SampleGrid in{1024, 1024, 15.0, 15.0};
  const auto lines_of = [&](double flat_columns) {
    PlanOptions options;
    options.scene = SceneSummary{.flat_columns = flat_columns};
    options.method = Method::fft_float;
    const Plan plan = compile(phase_along_y, in, in, options);
    const std::string text = plan.explain();
    const bool columns = says(text, "columns that are of");
    EXPECT_EQ(columns, plan.report().predicted.flat > 0.0);
    return columns ? Lines::columns : Lines::rows;
  };
  EXPECT_EQ(lines_of(0.06), Lines::rows);
  EXPECT_EQ(lines_of(0.15), Lines::rows);
  EXPECT_EQ(lines_of(0.6), Lines::columns);
}

// Columns that are flat one by one, beside others, are no lines to leave out.
TEST(PlanFlatParts, single_columns_do_not_count) {
  const auto summary = [](std::int64_t period) {
    return *summarise(image_of(64, 48, [&](auto x, auto) { return x / period % 2 == 0 ? 1.0 : 2.0; }).view(),
                      Border::reflect, 0.0);
  };
  EXPECT_EQ(summary(1).flat_columns, 0.0);
  EXPECT_EQ(summary(16).flat_columns, 1.0);
  EXPECT_EQ(summary(16).flat_rows, 0.0);
}

// Samples at the 64 places alone count, whatever the others are.
TEST(SampledMean, is_of_its_places) {
  Image scene = image_of(kWidth, kHeight, [](auto, auto) { return 5.0; });
  for (const float corner :
       {1000.0F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    scene.at(0, 0) = corner;
    EXPECT_FALSE(sampled_mean_and_deviation(scene.view()).has_value()) << corner;
  }
  const auto sampled = sampled_mean_and_deviation(random_image(kWidth, kHeight, 1, 300.0, 20.0).view());
  ASSERT_TRUE(sampled.has_value());
  EXPECT_NEAR(sampled->mean, 300.0, 5.0);
  EXPECT_GT(sampled->deviation, 40.0);
}

// The FFT engine estimates the mean from samples at a few places, and uses all samples where the estimate is poor.
TEST(PlanFlatParts, few_samples_that_mislead_do_no_harm) {
  const System<double> system = blur();
  const SampleGrid in = scene_grid(system, kWidth, kHeight, 1.0, 1.0);
  const Image noise = random_image(kWidth, kHeight, 9);
  const auto seen = [](std::int64_t x,
                       std::int64_t y) {  // by sampled_mean_and_deviation: 16 samples at each of 8 x 8 places
    const auto at = [](std::int64_t i, std::int64_t n, std::int64_t k) { return (2 * k + 1) * n / 16 <= i; };
    for (std::int64_t j = 0; j < 8; ++j)
      for (std::int64_t i = 0; i < 8; ++i)
        if (y == (2 * j + 1) * kHeight / 16 && at(x, kWidth - 16, i) && x < (2 * i + 1) * (kWidth - 16) / 16 + 16)
          return true;
    return false;
  };
  struct Misleading {
    const char* what;
    double seen, seen_contrast, mean, contrast;
  };
  for (const auto& [what, mean_seen, contrast_seen, mean, contrast] :
       {Misleading{"far from the mean", 1e4, 1.0, 10.0, 1.0}, Misleading{"flat", 7.0, 0.0, 10.0, 1.0},
        Misleading{"almost flat", 0.0, 1e-30, 0.0, 1e5}, Misleading{"flat, and all but uniform", 7.0, 0.0, 8.0, 0.0}}) {
    SCOPED_TRACE(what);
    const Image scene =
        image_of(kWidth, kHeight,
                 [&, ms = mean_seen, cs = contrast_seen, m = mean, c = contrast](std::int64_t x, std::int64_t y) {
                   return seen(x, y) ? ms + cs * static_cast<double>(noise.at(x, y))
                                     : m + c * static_cast<double>(noise.at(x, y));
                 });
    for (const Border border : kBorders)
      for (const Method method : {Method::fft_float, Method::fft_double}) {
        PlanOptions options = options_for(scene, border, 1e-5, mean);
        options.method = method;
        const Plan plan = compile(system, in, in, options);
        EXPECT_LE(rms_distance(run(plan, scene, mean), reference(system, scene, in, in, border, mean)),
                  plan.report().predicted.total() * options.scene->std)
            << plan.explain();
      }
  }
}

// Where all sampled places are faint, uniform lines elsewhere exceed the scale that the samples give.
TEST(PlanFlatParts, uniform_lines_far_beyond_the_samples) {
  const System<double> system = blur();
  const SampleGrid in = scene_grid(system, 128, 512, 1.0, 1.0);
  const Image noise = random_image(128, 512, 4);
  for (const double faint : {1e-20, 1e-30, 1e-37}) {
    const Image scene = image_of(128, 512, [&](auto x, auto y) {
      const std::int64_t group = y / 32;
      if (group == 0 || group % 2 == 1) return faint * static_cast<double>(noise.at(x, y));
      return group % 4 == 0 ? 2e8 : -2e8;
    });
    PlanOptions options = options_for(scene, Border::reflect, 1e-3);
    options.method = Method::fft_float;
    const Plan plan = compile(system, in, in, options);
    EXPECT_LE(rms_distance(run(plan, scene), reference(system, scene, in, in, Border::reflect, 0.0)),
              plan.report().predicted.total() * options.scene->std)
        << plan.explain();
  }
}

// Lines that are NaN or infinite throughout are not uniform.
TEST(PlanFlatParts, lines_that_are_not_finite_are_refused) {
  const System<double> system = blur();
  const SampleGrid in = scene_grid(system, kWidth, kHeight, 1.0, 1.0);
  for (const Region& busy : {Region{0, 60, 149, 58}, Region{75, 0, 74, 118}})
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
      Image scene = scene_of(busy, 300.0, 20.0);
      PlanOptions options = options_for(scene, Border::reflect, 1e-3);
      options.method = Method::fft_float;
      const Plan plan = compile(system, in, in, options);
      for (std::int64_t y = 0; y < kHeight; ++y)
        for (std::int64_t x = 0; x < kWidth; ++x)
          if (busy.y > 0 ? y == 3 : x == 3) scene.at(x, y) = bad;
      Image image(kWidth, kHeight);
      EXPECT_THROW(plan.run(scene.view(), image.view()), RuntimeError);
    }
}

// The axes of a plane of kWidth x kHeight samples whose lines are rows or columns.
std::pair<AxisTransform, AxisTransform> axes_of(Lines lines, Border border) {
  AxisTransform x, y;
  x.border = y.border = border;
  x.samples = lines == Lines::rows ? kWidth : kHeight;
  y.samples = lines == Lines::rows ? kHeight : kWidth;
  y.outputs = y.samples;
  y.pitch_um = y.frequency.step_um = 15.0;
  return {x, y};
}

TEST(LineGroups, input_is_uniform_where_a_whole_group_is_and_the_border_continues_it) {
  using Groups = std::vector<std::int64_t>;
  const Image bottom = scene_of({0, 70, 149, 48}, 300.0, 20.0), right = scene_of({75, 0, 74, 118}, 300.0, 20.0);
  for (const Border border : kBorders)
    for (const double beyond : {300.0, 250.0}) {
      const bool continued = border != Border::constant || beyond == 300.0;
      const auto groups = [&, border, beyond](const Image& scene, Lines lines) {
        const auto [x, y] = axes_of(lines, border);
        const LineGroups found = input_groups({.in = scene.view(), .out = {}, .border_value = beyond}, lines, x, y, 2);
        EXPECT_EQ(groups_over_uniform(found, x, y), found.uniform);  // one output a sample
        EXPECT_EQ(found.uniform.size() + found.transformed.size(), static_cast<std::size_t>((y.samples + 31) / 32));
        return found.uniform;
      };
      EXPECT_EQ(groups(bottom, Lines::rows), continued ? Groups({0, 1}) : Groups{});
      EXPECT_EQ(groups(right, Lines::columns), continued ? Groups({0, 1}) : Groups{});
      EXPECT_EQ(groups(right, Lines::rows), Groups{});
      EXPECT_EQ(groups(bottom, Lines::columns), Groups{});
    }
}

// Three groups, 96 lines: an rms of 1 over the output has room for energies of 96 / 2.
TEST(LineGroups, output_is_negligible_from_the_least_energy_on_while_the_allowance_lasts) {
  AxisTransform x, y;
  x.frequency.basis = Basis::fourier;
  x.out_length = x.outputs = 100;
  x.keep = 50;
  y.outputs = 96;
  const std::vector<std::int64_t> over{0, 1, 2};
  const auto uniform = [&](const std::vector<double>& energies, double allowance) {
    return output_groups(over, energies, allowance, x, y).uniform;
  };
  using Groups = std::vector<std::int64_t>;
  EXPECT_EQ(uniform({40.0, 10.0, 30.0}, 1.0), Groups({1, 2}));
  EXPECT_EQ(uniform({40.0, 10.0, 30.0}, 0.4), Groups{});
  EXPECT_EQ(uniform({40.0, 10.0, 30.0}, 2.0), Groups({0, 1, 2}));
  EXPECT_EQ(output_groups({}, {}, 1.0, x, y).transformed, Groups({0, 1, 2}));
}

TEST(UniformRuns, tells_uniform_groups_from_others) {
  const Image scene = scene_of({75, 0, 74, 118}, 300.0, 20.0);
  UniformRuns map(scene.view());
  ASSERT_TRUE(map.any());
  ASSERT_EQ(map.groups(), 10);
  const UniformRuns::Kind* kinds = map.classify_row(50);
  for (std::int64_t g = 0; g < 10; ++g) EXPECT_EQ(kinds[g] != 0, g < 4) << g;
  EXPECT_EQ(map.value(kinds[0]), 300.0F);
  EXPECT_EQ(map.kind_of(300.0F), kinds[0]);
  EXPECT_EQ(map.kind_of(301.0F), 0);
  EXPECT_FALSE(UniformRuns(random_image(kWidth, kHeight, 1).view()).any());
  EXPECT_FALSE(UniformRuns(Image(1, 1).view()).any());
}

}  // namespace
}  // namespace mtf::test
