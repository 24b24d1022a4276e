// SPDX-License-Identifier: Apache-2.0
// What holds for any system: 6 000 of them, the same in every run.
#include "tests/mtf/random_systems.h"

#include <algorithm>
#include <limits>
#include <set>

#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

constexpr int kSystems = 6'000, kParts = 10;

/// The slower properties, a part of the systems each; one goes with the suite, the others with the long tests.
constexpr int kCount = kSystems / kParts;
class RandomSystemsPart : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Each, RandomSystemsPart, testing::Values(0));
class RandomSystemsPartLong : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Each, RandomSystemsPartLong, testing::Range(1, kParts));

constexpr double kUlp = std::numeric_limits<double>::epsilon();

Freq<double> random_frequency(Random& random, double reach_x, double reach_y) {
  switch (random.below(6)) {
    case 0:
      return {0.0, random.uniform(-reach_y, reach_y)};
    case 1:
      return {random.decades(1e-9, 1.0) * reach_x, -random.decades(1e-9, 1.0) * reach_y};
    default:
      return {random.uniform(-reach_x, reach_x), random.uniform(-reach_y, reach_y)};
  }
}

std::string describe(int number, const System<double>& system) {
  std::string text = "system " + std::to_string(number) + ":";
  for (const auto& list : system.stages)
    for (const auto& entry : list) text += " " + entry.label;
  return text;
}

TEST(RandomSystems, use_every_kind_in_every_list) {
  std::set<std::pair<std::string, Stage>> seen;
  std::set<std::size_t> counts;
  for (int i = 0; i < kSystems; ++i) {
    const System<double> system = random_system(i, i % 2 == 1);
    std::size_t count = 0;
    for (const Stage stage : kStages)
      for (const auto& entry : system.list(stage)) seen.emplace(entry.component.kind(), stage), ++count;
    counts.insert(count);
  }
  for (const std::string_view kind : component_kinds())
    for (const Stage stage : kStages)
      if (Component<double>::make(kind).stages().allows(stage)) {
        EXPECT_TRUE(seen.contains({std::string(kind), stage})) << kind << " in " << stage_name(stage);
      }
  EXPECT_EQ(counts, (std::set<std::size_t>{1, 2, 3, 4, 5, 6, 7, 8}));
}

TEST(RandomSystems, otf_is_the_product_of_the_parts_and_hermitian) {
  for (int i = 0; i < kSystems; ++i) {
    const System<double> system = random_system(i, i % 2 == 1);
    Random random(static_cast<std::uint64_t>(i));
    for (int k = 0; k < 3; ++k) {
      const double reach = random.decades(0.1, 10.0);
      const Freq<double> f = random_frequency(random, reach * system.frame.nyquist_cy_mm(Axis::x),
                                              reach * system.frame.nyquist_cy_mm(Axis::y));
      const Complex<double> h = system.otf(f), mirrored = system.otf({-f.x, -f.y});
      const Product parts = product_of_parts(system, kStages, f);
      const auto rounding = static_cast<double>(parts.scale) * kUlp * (4.0 + 2.0 * parts.factors) + 1e-300;
      const std::string where = describe(i, system);
      ASSERT_TRUE(std::isfinite(h.re) && std::isfinite(h.im)) << where;
      EXPECT_NEAR(h.re, static_cast<double>(parts.value.real()), rounding) << where;
      EXPECT_NEAR(h.im, static_cast<double>(parts.value.imag()), rounding) << where;
      EXPECT_NEAR(h.re, mirrored.re, rounding) << where;
      EXPECT_NEAR(h.im, -mirrored.im, rounding) << where;
    }
  }
}

/// The presample plan, or that of `stages`; at the tolerance that a refusal names where 1e-2 is too tight.
std::optional<Plan> compiled(const System<double>& system, const SampleGrid& grid, const std::vector<Stage>& stages) {
  PlanOptions options;
  options.border = Border::periodic;
  options.tolerance = 1e-2;
  options.threads = 1;
  const auto once = [&] {
    return stages.empty() ? compile(system, grid, grid, options) : compile_post(system, grid, stages, options);
  };
  try {
    return once();
  } catch (const UnreachableTolerance& refusal) {
    if (!(refusal.reachable() < 1.0)) return std::nullopt;
    options.tolerance = refusal.reachable();
    return once();
  }
}

// The image of a point through both plans, on a small periodic canvas.
void expect_psf_to_sum_to_the_otf_at_zero(int first) {
  int refused = 0;
  for (int i = first; i < first + kCount; ++i) {
    // Over the field uniform scenes keep their light, a point does not.
    const System<double> system = random_system(i).at({});
    const SampleGrid grid{16, 12, system.frame.pitch_x_um, system.frame.pitch_y_um};
    const auto before = compiled(system, grid, {}), after = compiled(system, grid, {Stage::readout, Stage::postsample});
    if (!before || !after) {
      ++refused;  // a filter whose gain leaves float32 no digit
      continue;
    }
    const Image point = image_of(16, 12, [](auto x, auto y) { return x == 5 && y == 7 ? 1.0 : 0.0; });
    const Image image = run(*after, run(*before, point));
    double sum = 0.0;
    for (std::int64_t k = 0; k < image.size(); ++k) sum += image.data()[k];
    const Product parts = product_of_parts(system, kStages, {0.0, 0.0});
    const double gain = std::max(1.0, before->report().largest_gain) * std::max(1.0, after->report().largest_gain);
    EXPECT_NEAR(sum, static_cast<double>(parts.value.real()), 1e-5 * gain) << describe(i, system);
    EXPECT_EQ(parts.value.imag(), 0.0L);
  }
  EXPECT_LT(refused, kCount / 10);
}

// Rows as plans use them. A radial table of a hard case takes milliseconds: every 25th system has one, the others
// evaluate radial factors exactly.
void expect_grid_to_be_the_otf(int first) {
  double tightest = 0.0;
  for (int i = first; i < first + kCount; ++i) {
    System<double> system = random_system(i, i % 4 == 1);
    system.band_nodes = 256;
    Random random(static_cast<std::uint64_t>(i));
    const std::vector<Stage> stages =
        random.below(2) == 0 ? std::vector{Stage::presample} : std::vector{Stage::readout, Stage::postsample};
    const double reach = random.decades(0.2, 5.0), reach_x = reach * system.frame.nyquist_cy_mm(Axis::x),
                 reach_y = reach * system.frame.nyquist_cy_mm(Axis::y);
    const double budget = i % 3 == 0 ? 0.0 : random.decades(1e-7, 1e-2);
    const FactoredOtf sampler(system, stages, {},
                              {.fx_max = reach_x,
                               .fy_max = reach_y,
                               .drop_budget = budget,
                               .table_share = i % 25 == 0 ? 1e-5 : 0.0,
                               .samples = 16});
    std::vector<double> fx{0.0, reach_x}, fy{0.0, reach_y};
    for (int k = 0; k < 2; ++k) {
      fx.push_back(random.uniform(sampler.is_even_x() ? 0.0 : -reach_x, reach_x));
      fy.push_back(random.uniform(sampler.is_even_y() ? 0.0 : -reach_y, reach_y));
    }
    const FactoredOtf::Grid grid(sampler, fx, fy);
    for (std::size_t row = 0; row < fy.size(); ++row) {
      std::vector<Complex<float>> h(fx.size());
      if (sampler.is_real()) {
        std::vector<float> re(fx.size());
        grid.real_row(row, re);
        for (std::size_t k = 0; k < re.size(); ++k) h[k] = {re[k], 0.0F};
      } else {
        grid.complex_row(row, h);
      }
      for (std::size_t k = 0; k < fx.size(); ++k) {
        if (system.band && (k + row) % 4 != 0) continue;  // 256 wavelengths each
        const Product parts = product_of_parts(system, stages, {fx[k], fy[row]});
        const double off = std::hypot(static_cast<double>(h[k].re - parts.value.real()),
                                      static_cast<double>(h[k].im - parts.value.imag()));
        // float32: a rounding for each vector, the table, and each product of them.
        const double allowed = sampler.error() + 0x1p-24 * 8.0 * std::max(1.0, sampler.gain());
        EXPECT_LE(off, allowed) << describe(i, system) << "\n at " << fx[k] << ", " << fy[row] << " stated "
                                << sampler.error();
        tightest = std::max(tightest, off / allowed);
      }
    }
  }
  EXPECT_GT(tightest, 0.05) << "the stated error is far too loose";
}

TEST_P(RandomSystemsPart, psf_sums_to_the_otf_at_zero) { expect_psf_to_sum_to_the_otf_at_zero(kCount * GetParam()); }
TEST_P(RandomSystemsPart, grid_is_the_otf_pointwise_within_its_stated_error) {
  expect_grid_to_be_the_otf(kCount * GetParam());
}
TEST_P(RandomSystemsPartLong, psf_sums_to_the_otf_at_zero) {
  expect_psf_to_sum_to_the_otf_at_zero(kCount * GetParam());
}
TEST_P(RandomSystemsPartLong, grid_is_the_otf_pointwise_within_its_stated_error) {
  expect_grid_to_be_the_otf(kCount * GetParam());
}

}  // namespace
}  // namespace mtf::test
