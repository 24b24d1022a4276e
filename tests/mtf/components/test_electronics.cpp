// SPDX-License-Identifier: Apache-2.0
// Filters of the electronics: cutoffs in time, AC coupling.
#include <gtest/gtest.h>

#include <complex>

#include "mtf/plan/sensor_plan.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> filter(const char* kind, double cutoff, const char* unit, int axis = 0) {
  auto c = Component<double>::make(kind);
  set(c, "cutoff", cutoff, unit);
  if (std::string_view(kind) == "butterworth") set(c, "poles", 2.0);
  choose(c, "axis", axis);
  return c;
}

Component<double> highpass(double f0, int axis = 0, bool keep = true) {
  auto c = filter("rc_highpass", f0, "cy/mm", axis);
  choose(c, "dc", keep ? 0 : 1);
  return c;
}

constexpr std::array kKinds{"rc_lowpass", "rc_highpass", "butterworth"};

// 25 kHz at 2 m/s are 12.5 cycles/mm; 20 rad/s x 100 mm is the same speed; 1 MHz of 10 MHz is 0.1 cycles/pixel.
TEST(Electronics, cutoff_in_time_by_each_scan) {
  const System<double> s = detector(10.0, 20.0);
  for (const char* kind : kKinds)
    for (const int axis : {0, 1})
      for (const double f : {0.0, 1.0, 12.5, -40.0, 200.0}) {
        const double x = axis == 0 ? f : 3.0, y = axis == 0 ? 3.0 : f;
        const auto same = [&](const Component<double>& temporal, const Component<double>& spatial) {
          EXPECT_FALSE(refused(temporal, "cutoff", s));
          const auto h = otf_at(temporal, x, y, s), g = otf_at(spatial, x, y, s);
          EXPECT_NEAR(h.re, g.re, 1e-15) << kind << f;
          EXPECT_NEAR(h.im, g.im, 1e-15) << kind << f;
        };
        auto velocity = filter(kind, 25.0, "kHz", axis), rate = velocity, clock = filter(kind, 1.0, "MHz", axis);
        set(velocity, "scan_velocity", 2e6);
        set(rate, "scan_rate", 20e6);
        set(clock, "pixel_clock", 10e6);
        same(velocity, filter(kind, 12.5, "cy/mm", axis));
        same(rate, filter(kind, 12.5, "cy/mm", axis));
        same(clock, filter(kind, 0.1, "cy/px", axis));
        same(clock, filter(kind, axis == 0 ? 10.0 : 5.0, "cy/mm", axis));
      }
}

TEST(Electronics, a_cutoff_in_time_needs_exactly_one_scan) {
  for (const char* kind : kKinds) {
    auto c = filter(kind, 25.0, "kHz");
    EXPECT_TRUE(refused(c, "cutoff"));
    set(c, "scan_rate", 1e6);
    EXPECT_FALSE(refused(c, "cutoff"));
    set(c, "pixel_clock", 1e6);
    EXPECT_TRUE(refused(c, "scan_rate"));
    auto spatial = filter(kind, 25.0, "cy/px");
    EXPECT_FALSE(refused(spatial, "pixel_clock"));
    set(spatial, "pixel_clock", 1e6);
    EXPECT_TRUE(refused(spatial, "pixel_clock"));
  }
}

TEST(RcHighpass, values_at_parts_of_the_cutoff) {
  for (const auto& [u, re, im] : {std::array{1.0, 0.5, 0.5}, std::array{2.0, 0.8, 0.4}, std::array{-2.0, 0.8, -0.4},
                                  std::array{1.0 / 3.0, 0.1, 0.3}, std::array{1e-200, 0.0, 1e-200}}) {
    const auto h = otf_at(highpass(7.0), 7.0 * u, 3.0);
    EXPECT_NEAR(h.re, re, 1e-15) << u;
    EXPECT_NEAR(h.im, im, 1e-15) << u;
  }
}

// Its definition: a point less what flows off after it, 2 pi f0 exp(-2 pi f0 x) on x > 0.
TEST(RcHighpass, droops_behind_a_point) {
  const double f0 = 4.0;
  for (const double f : {0.3, 4.0, -25.0}) {
    std::complex<double> sum = 1.0;
    constexpr int kPanels = 40000;  // Simpson over 2 pi f0 x from 0 to 40
    for (int k = 0; k <= kPanels; ++k) {
      const double t = 40.0 * k / kPanels, w = (k == 0 || k == kPanels ? 1.0
                                                : k % 2 == 1           ? 4.0
                                                                       : 2.0) *
                                               40.0 / kPanels / 3.0;
      sum -= w * std::exp(-t) * std::polar(1.0, -f / f0 * t);
    }
    for (const int axis : {0, 1}) {
      const auto h = otf_at(highpass(f0, axis), axis == 0 ? f : 1.0, axis == 0 ? 1.0 : f);
      EXPECT_NEAR(h.re, sum.real(), 1e-10) << f;
      EXPECT_NEAR(h.im, sum.imag(), 1e-10) << f;
    }
  }
}

TEST(RcHighpass, is_what_the_lowpass_leaves) {
  for (const double f : {1e-9, 0.5, 7.0, 7.0000001, 90.0, -1e6}) {
    const auto high = otf_at(highpass(7.0), f, 3.0), low = otf_at(rc(7.0, 0), f, 3.0);
    EXPECT_NEAR(high.re + low.re, 1.0, 2e-16) << f;
    EXPECT_EQ(high.im, -low.im) << f;
  }
}

TEST(RcHighpass, policy_of_the_mean) {
  for (const int axis : {0, 1}) {
    const double x = axis == 0 ? 0.0 : 30.0, y = axis == 0 ? 30.0 : 0.0;
    EXPECT_EQ(otf_at(highpass(7.0, axis, true), x, y).re, 1.0);
    EXPECT_EQ(otf_at(highpass(7.0, axis, false), x, y).re, 0.0);
    EXPECT_EQ(highpass(7.0, axis, true).traits(detector().context()).dc, 1.0);
    EXPECT_EQ(highpass(7.0, axis, false).traits(detector().context()).dc, 0.0);
  }
}

// A bright point on an even ground: its line keeps its mean or loses it; the undershoot is to the right.
TEST(RcHighpass, in_an_image) {
  for (const Stage stage : {Stage::presample, Stage::readout})
    for (const bool keep : {true, false}) {
      System<double> s;
      s.frame = {100.0, 10.0, 20.0, 0.0, 0, 0};
      s.add(stage, highpass(1.0, 0, keep));
      Image in(64, 8), out(64, 8);
      for (std::int64_t i = 0; i < in.size(); ++i) in.data()[i] = 10.0F;
      in.at(16, 4) = 138.0F;  // + 2 in the mean of its line
      PlanOptions options;
      options.border = Border::periodic;
      options.tolerance = 1e-5;
      options.scene = summarise(in.view(), options.border, 0.0);
      if (stage == Stage::presample)
        compile(s, {64, 8, 10.0, 20.0}, {64, 8, 10.0, 20.0}, options).run(in.view(), out.view(), 0.0, 1);
      else
        compile_post(s, {64, 8, 10.0, 20.0}, std::array{stage}, options).run(in.view(), out.view(), 0.0, 1);
      for (std::int64_t y = 0; y < 8; ++y) {
        double mean = 0.0;
        for (std::int64_t x = 0; x < 64; ++x) mean += out.at(x, y) / 64.0;
        EXPECT_NEAR(mean, !keep ? 0.0 : y == 4 ? 12.0 : 10.0, 1e-3) << y;
      }
      const double ground = keep ? 12.0 : 0.0;
      EXPECT_GT(out.at(16, 4), ground + 100.0);
      EXPECT_LT(out.at(18, 4), ground - 4.0);
      EXPECT_LT(out.at(18, 4), out.at(40, 4));
    }
}

}  // namespace
}  // namespace mtf::test
