// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> hold(double width, const char* unit, int axis) {
  auto c = Component<double>::make("sample_and_hold");
  set(c, "width", width, unit);
  choose(c, "axis", axis);
  return c;
}

// One pitch at the Nyquist frequency and at the sampling frequency.
TEST(SampleAndHold, values_along_its_axis_only) {
  const System<double> s = detector(10.0, 20.0);
  EXPECT_NEAR(otf_at(hold(1.0, "px", 0), 50.0, 33.0, s).re, 2.0 / kPi, 1e-15);
  EXPECT_NEAR(otf_at(hold(1.0, "px", 1), 33.0, 25.0, s).re, 2.0 / kPi, 1e-15);
  EXPECT_NEAR(otf_at(hold(1.0, "px", 0), 100.0, 0.0, s).re, 0.0, 1e-15);
  EXPECT_NEAR(otf_at(hold(1.0, "px", 0), 150.0, 0.0, s).re, -2.0 / (3.0 * kPi), 1e-15);
  EXPECT_EQ(otf_at(hold(15.0, "um", 0), 17.0, 5.0, s).re, otf_at(footprint(15.0), 17.0, 0.0, s).re);
}

TEST(SampleAndHold, two_widths_are_refused) {
  auto c = hold(1.0, "px", 0);
  set_xy(c, "width", 1.0, 2.0, "px");
  EXPECT_TRUE(refused(c, "width"));
}

}  // namespace
}  // namespace mtf::test
