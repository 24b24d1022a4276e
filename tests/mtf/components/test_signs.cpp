// SPDX-License-Identifier: Apache-2.0
// The sign convention, executed: OTF(f) = integral of psf(x) exp(-2 pi i f.x) dx, +x right along columns, +y down along
// rows; frequencies in other units reach cycles/mm through Frame only.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "mtf/math/special.h"
#include "mtf/plan/plan.h"
#include "tests/mtf/builders.h"

namespace mtf::test {
namespace {

System<double> bare() {
  System<double> s;
  s.frame = {100.0, 10.0, 20.0, 0.01, 0, 0};
  return s;
}

// Inverse transform by hand on a period of 2 mm, smoothed so that the sum converges: psf(x), x in mm along one axis.
double psf(const Component<double>& component, double x, bool along_y, double smooth_um = 1.0) {
  const System<double> s = bare();
  double sum = 0.0;
  for (int k = -2000; k <= 2000; ++k) {
    const double f = 0.5 * k;
    const Complex<double> h = component.otf({along_y ? 0.0 : f, along_y ? f : 0.0}, s.context());
    const double window = mtf::gaussian(smooth_um * 1e-3 * f).value;
    sum += 0.5 * window * (h.re * std::cos(2.0 * kPi * f * x) - h.im * std::sin(2.0 * kPi * f * x));
  }
  return sum;
}

TEST(Signs, rc_lowpass_trails_towards_the_positive_axis) {
  for (const int axis : {0, 1}) {
    const auto c = rc(10.0, axis);
    const double decay_mm = 1.0 / (2.0 * kPi * 10.0);  // of exp(-x / decay) / decay, x >= 0
    for (const double x : {0.005, 0.01, 0.03}) {
      EXPECT_NEAR(psf(c, x, axis == 1), std::exp(-x / decay_mm) / decay_mm, 5e-3 / decay_mm) << axis << x;
      EXPECT_NEAR(psf(c, -x, axis == 1), 0.0, 1e-3 / decay_mm) << axis << x;
    }
  }
}

TEST(Signs, tap_right_of_the_middle_is_a_phase_of_one_pixel) {
  const System<double> s = bare();
  const auto right = fir({{0, 0, 1}}), down = fir({{0}, {0}, {1}});
  for (const double f : {3.0, 11.0, 25.0}) {
    const Complex<double> x = right.otf({f, 4.0}, s.context()), y = down.otf({4.0, f}, s.context());
    EXPECT_NEAR(x.re, std::cos(2.0 * kPi * f * 0.010), 1e-15);
    EXPECT_NEAR(x.im, -std::sin(2.0 * kPi * f * 0.010), 1e-15);
    EXPECT_NEAR(y.re, std::cos(2.0 * kPi * f * 0.020), 1e-15);
    EXPECT_NEAR(y.im, -std::sin(2.0 * kPi * f * 0.020), 1e-15);
  }
}

TEST(Signs, tap_right_of_the_middle_moves_a_point_to_the_right_in_an_image) {
  System<double> s = bare();
  const std::array stages{Stage::postsample};
  for (const bool down : {false, true}) {
    s.list(Stage::postsample).clear();
    s.add(Stage::postsample, down ? fir({{0}, {0}, {1}}) : fir({{0, 0, 1}}));
    Image in(9, 7), out(9, 7);
    for (std::int64_t i = 0; i < in.size(); ++i) in.data()[i] = 1.0F;
    in.at(4, 3) = 5.0F;
    PlanOptions options;
    options.border = Border::periodic;
    options.tolerance = 1e-5;
    options.scene = summarise(in.view(), options.border, 0.0);
    compile_post(s, {9, 7, 10.0, 20.0}, stages, options).run(in.view(), out.view(), 0.0, 1);
    for (std::int64_t y = 0; y < 7; ++y)
      for (std::int64_t x = 0; x < 9; ++x)
        EXPECT_NEAR(out.at(x, y), x == (down ? 4 : 5) && y == (down ? 4 : 3) ? 5.0 : 1.0, 1e-4) << x << " " << y;
  }
}

TEST(Signs, rc_lowpass_trails_to_the_right_in_an_image) {
  System<double> s = bare();
  s.add(Stage::presample, rc(15.0, 0));
  Image in(32, 8), out(32, 8);
  for (std::int64_t i = 0; i < in.size(); ++i) in.data()[i] = 0.0F;
  in.at(16, 4) = 1.0F;
  PlanOptions options;
  options.border = Border::periodic;
  options.scene = summarise(in.view(), options.border, 0.0);
  compile(s, {32, 8, 10.0, 20.0}, {32, 8, 10.0, 20.0}, options).run(in.view(), out.view(), 0.0, 1);
  double left = 0.0, right = 0.0;
  for (std::int64_t k = 1; k < 8; ++k) left += out.at(16 - k, 4), right += out.at(16 + k, 4);
  EXPECT_GT(right, 0.2);
  EXPECT_LT(std::abs(left), 0.2 * right);
}

TEST(Signs, motion_direction_goes_from_right_to_down) {
  // At 45 degrees (towards +x and +y, lower right) detail along the other diagonal is kept, along this one it is lost.
  const System<double> s = bare();
  const auto c = motion(20.0, 45.0);
  EXPECT_LT(c.otf({30.0, 30.0}, s.context()).re, 0.2);
  EXPECT_EQ(c.otf({30.0, -30.0}, s.context()).re, 1.0);
  const auto shallow = motion(20.0, 30.0);
  const double dx = 0.020 * std::cos(kPi / 6.0), dy = 0.020 * std::sin(kPi / 6.0);
  EXPECT_NEAR(shallow.otf({17.0, 23.0}, s.context()).re, sinc(dx * 17.0 + dy * 23.0).value, 1e-15);
}

TEST(Signs, frequency_units_convert_by_frame_only) {
  const Frame<double> frame{50.0, 10.0, 20.0, 0.0, 0, 0};
  EXPECT_DOUBLE_EQ(frame.nyquist_cy_mm(Axis::x), 50.0);
  EXPECT_DOUBLE_EQ(frame.nyquist_cy_mm(Axis::y), 25.0);
  EXPECT_DOUBLE_EQ(frame.cy_per_px(frame.nyquist_cy_mm(Axis::x), Axis::x), 0.5);
  EXPECT_DOUBLE_EQ(frame.cy_per_px(25.0, Axis::y), 0.5);
  EXPECT_DOUBLE_EQ(frame.cy_per_mrad(20.0), 1.0);  // 1 mrad x 50 mm = 50 um, one period of 20 cy/mm
  EXPECT_DOUBLE_EQ(frame.cy_mm_from_mrad(1.0), 20.0);
  EXPECT_DOUBLE_EQ(frame.cy_mm_from_px(0.5, Axis::y), 25.0);
  EXPECT_DOUBLE_EQ(frame.um_from_urad(200.0), 10.0);

  // The same low-pass written in three units.
  System<double> s = bare();
  s.frame = frame;
  for (const auto& [value, unit] : {std::pair{20.0, "cy/mm"}, std::pair{1.0, "cy/mrad"}, std::pair{0.2, "cy/px"}}) {
    auto c = rc(1.0, 0);
    set(c, "cutoff", value, unit);
    EXPECT_NEAR(c.otf({20.0, 0.0}, s.context()).re, 0.5, 1e-15) << unit;
    EXPECT_NEAR(c.otf({20.0, 0.0}, s.context()).im, -0.5, 1e-15) << unit;
  }
  // The same jitter as a length, an angle and in pixels; pixels differ per axis here.
  for (const auto& [value, unit] : {std::pair{4.0, "um"}, std::pair{80.0, "urad"}, std::pair{0.4, "px"}})
    EXPECT_NEAR(jitter(value, unit).otf({20.0, 0.0}, s.context()).re, jitter(4.0).otf({20.0, 0.0}, s.context()).re,
                1e-15)
        << unit;
  EXPECT_NEAR(jitter(0.4, "px").otf({0.0, 20.0}, s.context()).re, jitter(8.0).otf({0.0, 20.0}, s.context()).re, 1e-15);
}

}  // namespace
}  // namespace mtf::test
