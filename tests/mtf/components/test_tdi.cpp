// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> tdi(int stages, double slip_um, int phases = 0, int axis = 0) {
  auto c = Component<double>::make("tdi");
  set(c, "stages", stages);
  set(c, "slip", slip_um, "um");
  set(c, "clock_phases", phases);
  choose(c, "axis", axis);
  return c;
}

TEST(Tdi, ten_digits) {
  const std::array values{.9951438828, .9806602688, .9239828522, .8400066871};
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(otf_at(tdi(32, 0.34), kGoldenFrequencies[i], 0.0).re, values[i], kTenDigits) << i;
}

TEST(Tdi, one_stage_or_no_slip_is_one) {
  for (const double f : {0.0, 11.0, 500.0, 1e9}) {
    EXPECT_EQ(otf_at(tdi(1, 3.0), f, 0.0).re, 1.0);
    EXPECT_EQ(otf_at(tdi(64, 0.0), f, 0.0).re, 1.0);
    EXPECT_EQ(otf_at(tdi(64, 2.0), 0.0, f).re, 1.0);
  }
}

// Its definition, the mean phase of the stages about their middle, and the clock's steps.
TEST(Tdi, is_the_mean_over_the_stages) {
  for (const int n : {2, 3, 32})
    for (const double f : {0.3, 70.0, 249.0, 250.0, 251.0, 499.9, 500.0, 750.0, 1000.0}) {
      double mean = 0.0;
      for (int k = 0; k < n; ++k) mean += cos_pi(2.0 * f * 0.002 * (k - 0.5 * (n - 1))) / n;
      EXPECT_NEAR(otf_at(tdi(n, 2.0), f, 0.0).re, mean, 1e-12) << n << " " << f;
      EXPECT_NEAR(otf_at(tdi(n, 2.0, 4, 1), 0.0, f).re, mean * sinc(f * 0.017 / 4.0).value, 1e-12) << n << " " << f;
    }
}

TEST(Tdi, no_step_where_its_denominator_vanishes) {
  for (const int n : {2, 7, 1000}) {
    const double x = otf_at(tdi(n, 2.0), 500.0, 0.0).re;
    EXPECT_NEAR(std::abs(x), 1.0, 1e-15) << n;
    EXPECT_EQ(x < 0.0, n % 2 == 0) << n;
    for (const double side : {0.0, 1000.0})
      EXPECT_NEAR(otf_at(tdi(n, 2.0), std::nextafter(500.0, side), 0.0).re, x, 1e-12) << n;
  }
}

// A slip of 1e6 mm: f d is a whole even number at every double from 1e16 on, and no longer a number from 1e303 on.
TEST(Tdi, no_step_where_its_phase_leaves_the_doubles) {
  for (const double f : {1e200, 1e302, 1e303, 1e307}) EXPECT_EQ(otf_at(tdi(6, 1e9), f, 0.0).re, 1.0) << f;
}

TEST(Tdi, two_slips_are_refused) {
  auto c = tdi(8, 1.0);
  set_xy(c, "slip", 1.0, 2.0, "um");
  EXPECT_TRUE(refused(c, "slip"));
  EXPECT_TRUE(refused(tdi(0, 1.0), "stages"));
}

}  // namespace
}  // namespace mtf::test
