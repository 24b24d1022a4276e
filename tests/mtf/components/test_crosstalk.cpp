// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> crosstalk(double side, double corner) {
  auto c = Component<double>::make("crosstalk");
  set(c, "side", side);
  set(c, "corner", corner);
  return c;
}

TEST(Crosstalk, ten_digits) {
  const std::array values{.9888593622, .9585402939, .8771338564, .8400000000};
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(otf_at(crosstalk(0.03, 0.005), kGoldenFrequencies[i], 0.0).re, values[i], kTenDigits) << i;
}

TEST(Crosstalk, is_the_filter_of_its_nine_taps) {
  const double s = 0.07, c = 0.012, m = 1.0 - 4.0 * (s + c);
  const auto filter = fir({{c, s, c}, {s, m, s}, {c, s, c}});
  const System<double> system = detector(12.0, 17.0);
  for (const double fx : {0.0, 3.0, 17.0, 41.0, -60.0})
    for (const double fy : {0.0, 5.0, 29.0, 100.0})
      EXPECT_NEAR(otf_at(crosstalk(s, c), fx, fy, system).re, otf_at(filter, fx, fy, system).re, 4e-16);
}

TEST(Crosstalk, corner_is_optional) {
  auto c = Component<double>::make("crosstalk");
  set(c, "side", 0.05);
  EXPECT_EQ(otf_at(c, 13.0, 7.0).re, otf_at(crosstalk(0.05, 0.0), 13.0, 7.0).re);
  EXPECT_TRUE(refused(crosstalk(0.126, 0.0), "side"));
  EXPECT_FALSE(refused(crosstalk(0.125, 0.125), "side"));
}

// They describe the same spread of charge, measured together.
TEST(Crosstalk, beside_diffusion_is_warned_about) {
  System<double> s = detector();
  auto diffusion = Component<double>::make("diffusion");
  set(diffusion, "absorption_length", 10.0);
  set(diffusion, "diffusion_length", 20.0);
  const auto warned = [&] {
    for (const auto& f : s.check())
      if (!f.problem.error && f.where == "readout[0].kind") return f.problem.text.find("twice") != std::string::npos;
    return false;
  };
  s.add(Stage::readout, crosstalk(0.03, 0.0));
  EXPECT_FALSE(warned());
  s.add(Stage::presample, diffusion);
  EXPECT_TRUE(warned());
}

}  // namespace
}  // namespace mtf::test
