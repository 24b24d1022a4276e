// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "radiometry/light/adaptive_integral.h"
#include "radiometry/performance/implicit_root.h"

namespace radiometry {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

TEST(AdaptiveIntegral, error_is_stated_and_kept) {
  const auto bell = [](double x) { return std::exp(-x * x); };
  const Integral<double> smooth = integrate<double>(bell, -8.0, 8.0);
  EXPECT_NEAR(smooth.value, std::sqrt(mtf::kPi), 1e-14);
  EXPECT_LE(smooth.error, 1e-10);
  // A kink and a step: the order of a rule does not help, halving does.
  const Integral<double> kink = integrate<double>([](double x) { return std::abs(x - 0.3); }, 0.0, 1.0);
  EXPECT_NEAR(kink.value, 0.5 * (0.09 + 0.49), kink.error + 1e-15);
  EXPECT_LE(kink.error, 1e-10);
  const Integral<double> step = integrate<double>([](double x) { return x < 0.3 ? 1.0 : 0.0; }, 0.0, 1.0);
  EXPECT_NEAR(step.value, 0.3, step.error + 1e-15);
  EXPECT_LE(step.error, 1e-10);
}

// A peak that the first panels miss sets the scale as soon as it is found, so that the tolerance refers to all of it.
TEST(AdaptiveIntegral, narrow_peak_is_cheap) {
  int calls = 0;
  const auto peak = [&](double x) {
    ++calls;
    return 1.0 / (1e-8 + (x - 0.51) * (x - 0.51));
  };
  const Integral<double> found = integrate<double>(peak, 0.0, 1.0);
  const double exact = 1e4 * (std::atan(0.49e4) + std::atan(0.51e4));
  EXPECT_NEAR(found.value, exact, 1e-11 * exact);
  EXPECT_LT(calls, 5000);
}

TEST(AdaptiveIntegral, ends_whatever_comes) {
  EXPECT_EQ(integrate<double>([](double) { return 1.0; }, 2.0, 2.0).value, 0.0);
  EXPECT_TRUE(std::isnan(integrate<double>([](double) { return std::nan(""); }, 0.0, 1.0).value));
  // Two rules never agree on noise: the integral stops at the largest number of panels and states its error.
  std::uint64_t state = 1;
  const auto noise = [&](double) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11) * 0x1p-53;
  };
  const Integral<double> rough = integrate<double>(noise, 0.0, 1.0);
  EXPECT_NEAR(rough.value, 0.5, 0.05);
  EXPECT_GT(rough.error, 1e-6);
}

TEST(Root, to_the_digits_of_a_double) {
  const auto root_of = [](auto g, double lo, double hi) { return find_root(g, lo, hi, g(lo), g(hi)); };
  EXPECT_NEAR(root_of([](double x) { return x * x - 2.0; }, 0.0, 2.0), std::sqrt(2.0), 4e-16);
  EXPECT_NEAR(root_of([](double x) { return 2.0 - std::exp(x); }, -700.0, 700.0), std::log(2.0), 4e-16);
  EXPECT_NEAR(root_of([](double x) { return x * x * x * x * x; }, -1.0, 3.0), 0.0, 1e-60);
  EXPECT_EQ(root_of([](double x) { return x - 1.0; }, 1.0, 3.0), 1.0);
  EXPECT_EQ(root_of([](double x) { return x - 3.0; }, 1.0, 3.0), 3.0);
  EXPECT_NEAR(root_of([](double x) { return x < 0.7 ? -1.0 : kInfinite; }, 0.0, 1.0), 0.7, 1e-15);
}

TEST(Root, slope_by_five_points) {
  EXPECT_NEAR(slope_at([](double x) { return std::exp(x); }, 1.0, 1e-3), std::exp(1.0), 1e-11);
  EXPECT_EQ(implicit_root(2.0, 0.5, 0.0), 2.0);
}

}  // namespace
}  // namespace radiometry
