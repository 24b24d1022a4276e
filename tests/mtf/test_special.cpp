// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mtf/math/special.h"
#include "tests/mtf/conformance.h"
#include "tests/mtf/reference_table.h"

namespace mtf::test {
namespace {

constexpr double kUlp = std::numeric_limits<double>::epsilon();
constexpr double kInf = std::numeric_limits<double>::infinity();

TEST(Special, sinc_against_the_table) {
  const auto check = reference_check("footprint", "sinc");
  EXPECT_TRUE(check.passed) << check.failure;
  EXPECT_EQ(check.count, 60);
  for (const Row& row : reference_table("sinc_extremes.csv")) {
    const double x = number(row, "x_hex");
    EXPECT_EQ(sinc(-x).value, sinc(x).value);
    EXPECT_EQ(sinc(-x).slope, -sinc(x).slope);
  }
}

TEST(Special, gaussian_against_the_table) {
  const auto check = reference_check("gaussian", "Gaussian");
  EXPECT_TRUE(check.passed) << check.failure;
  EXPECT_GT(check.count, 37);  // those that underflow twice
}

TEST(Special, against_the_dense_table) {
  for (const auto& [component, name] :
       {std::pair{"footprint", "sinc and slope"}, std::pair{"gaussian", "Gaussian and slope"},
        std::pair{"vibration", "J0 and slope, to 1e8"}, std::pair{"circular_footprint", "2 J1(x)/x and slope"}}) {
    const auto check = reference_check(component, name);
    EXPECT_TRUE(check.passed) << check.failure;
    EXPECT_GE(check.count, 400) << name;
  }
}

TEST(Special, slopes_equal_differences_across_the_switch_to_the_series) {
  for (const double x : {0.0, 1e-8, 1e-3, 0.0499, 0.04999999, 0.05, 0.0500001, 0.3, 0.999999, 1.0, 1.7, 2.0, 12.3}) {
    const double h = 1e-5;
    EXPECT_NEAR(sinc(x).slope, (sinc(x + h).value - sinc(x - h).value) / (2.0 * h), 1e-9) << x;
    EXPECT_NEAR(gaussian(x).slope, (gaussian(x + h).value - gaussian(x - h).value) / (2.0 * h), 1e-7) << x;
  }
  // Both sides of the switch belong to one curve.
  const double left = std::nextafter(0.05, 0.0);
  EXPECT_NEAR(sinc(left).value, sinc(0.05).value, 2.0 * kUlp);
  EXPECT_NEAR(sinc(left).slope, sinc(0.05).slope, 1e-14);
}

TEST(Special, limits) {
  for (const double x : {kInf, -kInf}) {
    EXPECT_EQ(sinc(x).value, 0.0);
    EXPECT_EQ(gaussian(x).value, 0.0);
    EXPECT_EQ(gaussian(x).slope, 0.0);
  }
  EXPECT_EQ(sinc(0.0).slope, 0.0);
  EXPECT_EQ(gaussian(0.0).value, 1.0);
}

TEST(Special, sin_pi_and_cos_pi_are_exact_at_quarter_turns) {
  for (const double n : {0.0, 1.0, 2.0, 3.0, 7.0, 1e6, 1e15, 4503599627370497.0}) {
    const double sign = std::fmod(n, 2.0) == 0.0 ? 1.0 : -1.0;
    EXPECT_EQ(sin_pi(n), 0.0) << n;
    EXPECT_EQ(cos_pi(n), sign) << n;
    if (n > 2e15) continue;
    EXPECT_EQ(sin_pi(n + 0.5), sign) << n;
    EXPECT_EQ(cos_pi(n + 0.5), 0.0) << n;
  }
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const double x = random.uniform(-4.0, 4.0);
    EXPECT_NEAR(sin_pi(x), std::sin(kPi * x), 3e-15);
    EXPECT_NEAR(cos_pi(x), std::cos(kPi * x), 3e-15);
    EXPECT_NEAR(sin_pi(x) * sin_pi(x) + cos_pi(x) * cos_pi(x), 1.0, 3e-16);
  }
}

TEST(Special, radius_and_phase) {
  EXPECT_EQ(radius(3.0, -4.0), 5.0);
  EXPECT_EQ(radius(0.0, 0.0), 0.0);
  EXPECT_EQ(radius(3e300, 4e300), 5e300);
  // exp(-i pi x): a quarter turn clockwise at 1/2.
  EXPECT_EQ(phase_of(0.5).re, 0.0);
  EXPECT_EQ(phase_of(0.5).im, -1.0);
  EXPECT_EQ(phase_of(1e15 + 1.0).re, -1.0);
}

TEST(Special, sine_and_cosine_of_pi_x_do_not_change_by_whole_turns) {
  // std::remainder is exact, so it is a second route to the argument within one turn, for any size.
  for (const double scale : {5e-324, 1e-300, 1e-3, 0.7, 12.0, 1e5, 0x1p49, 0x1p51, 0x1p52, 0x1p53, 1e17, 1e300})
    for (const double part : {0.25, 0.5, 0.75, 1.0, 1.25, 1.4999999999999998, 1.5, 1.7, 1.9999999999999998})
      for (const double x : {scale * part, -scale * part}) {
        const double within = std::remainder(x, 2.0);
        EXPECT_EQ(sin_cos_pi(x).sin, sin_pi(within)) << x;
        EXPECT_EQ(sin_cos_pi(x).cos, cos_pi(within)) << x;
        EXPECT_NEAR(sin_cos_pi(x).sin, std::sin(kPi * within), 4e-16) << x;
        EXPECT_NEAR(sin_cos_pi(x).cos, std::cos(kPi * within), 4e-16) << x;
      }
}

}  // namespace
}  // namespace mtf::test
