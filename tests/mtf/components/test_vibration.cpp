// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "mtf/components/bessel.h"
#include "tests/mtf/components/one_component.h"
#include "tests/mtf/reference_table.h"

namespace mtf::test {
namespace {

constexpr double kUlp = std::numeric_limits<double>::epsilon();

Component<double> vibration(double amplitude_um, double direction_deg = 0.0) {
  auto c = Component<double>::make("vibration");
  set(c, "amplitude", amplitude_um, "um");
  set(c, "direction", direction_deg);
  return c;
}

TEST(Bessel, against_the_table) {
  for (const auto& [component, name] : {std::pair{"vibration", "J0"}, {"circular_footprint", "2 J1(x)/x"}}) {
    const auto check = reference_check(component, name);
    EXPECT_TRUE(check.passed) << check.failure;
    EXPECT_EQ(check.count, 54);
  }
}

TEST(Bessel, slopes_equal_differences_across_the_switch_to_the_series) {
  for (const double x : {0.0, 1e-6, 0.03, 0.0999, std::nextafter(0.1, 0.0), 0.1, 0.1001, 0.7, 3.0, 5.136, 40.0}) {
    const double h = 1e-5;
    EXPECT_NEAR(bessel_j0(x).slope, (bessel_j0(x + h).value - bessel_j0(x - h).value) / (2.0 * h), 1e-10) << x;
    EXPECT_NEAR(jinc(x).slope, (jinc(x + h).value - jinc(x - h).value) / (2.0 * h), 1e-10) << x;
  }
  const double left = std::nextafter(0.1, 0.0);
  EXPECT_NEAR(jinc(left).value, jinc(0.1).value, 2.0 * kUlp);
  EXPECT_NEAR(jinc(left).slope, jinc(0.1).slope, 1e-14);
}

TEST(Vibration, ten_digits) {
  const std::array values{.9938410033, .9754777741, .9037126421, .7976799381};
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(otf_at(vibration(5.0), kGoldenFrequencies[i], 0.0).re, values[i], kTenDigits) << i;
}

// Its definition, the mean phase over one cycle; the negative lobe included.
TEST(Vibration, is_the_mean_over_a_cycle) {
  for (const double f : {3.0, 60.0, 122.0, 190.0}) {
    double mean = 0.0;
    for (int k = 0; k < 256; ++k) mean += cos_pi(2.0 * f * 0.005 * sin_pi((k + 0.5) / 128.0)) / 256.0;
    EXPECT_NEAR(otf_at(vibration(5.0), f, 9.0).re, mean, 1e-14) << f;
    EXPECT_NEAR(otf_at(vibration(5.0, 90.0), 9.0, f).re, mean, 1e-14) << f;
    EXPECT_NEAR(otf_at(vibration(5.0, 30.0), f * std::cos(kPi / 6.0), f * std::sin(kPi / 6.0)).re, mean, 1e-14) << f;
  }
  EXPECT_LT(otf_at(vibration(5.0), 122.0, 0.0).re, -0.4);
}

TEST(Vibration, two_amplitudes_are_refused) {
  auto c = vibration(1.0);
  set_xy(c, "amplitude", 1.0, 2.0, "um");
  EXPECT_TRUE(refused(c, "amplitude"));
}

}  // namespace
}  // namespace mtf::test
