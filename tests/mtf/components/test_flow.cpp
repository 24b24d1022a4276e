// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Context<double> at_place(double x_um, double y_um) {
  Context<double> ctx = detector().context();
  ctx.place = {x_um, y_um};
  return ctx;
}

Component<double> flow(double zoom, double rotation_urad) {
  auto c = Component<double>::make("flow");
  set(c, "zoom", zoom);
  set(c, "rotation", rotation_urad);
  return c;
}

// Second route: the mean phase over the path of a point that a zoom and a turn about the axis move.
TEST(Flow, is_the_mean_over_the_path) {
  const auto c = flow(0.004, 3000.0);
  for (const auto& [x, y] : {std::pair{4000.0, 3000.0}, {-2500.0, 1000.0}, {0.0, -6000.0}})
    for (const auto& [fx, fy] : {std::pair{20.0, 0.0}, {0.0, 25.0}, {-30.0, 40.0}}) {
      double re = 0.0, im = 0.0;
      for (const double t : {0.5 - 0.288675134594812882, 0.5 + 0.288675134594812882})  // Gauss rule of two nodes ...
        for (int k = 0; k < 200; ++k) {
          const double time = (k + t) / 200.0 - 0.5, grown = 1.0 + 0.004 * time, angle = 0.003 * time;
          const double moved_x = grown * (x * std::cos(angle) - y * std::sin(angle)) - x,
                       moved_y = grown * (x * std::sin(angle) + y * std::cos(angle)) - y;
          const double cycles = 1e-3 * (fx * moved_x + fy * moved_y);
          re += std::cos(2.0 * kPi * cycles) / 400.0, im -= std::sin(2.0 * kPi * cycles) / 400.0;
        }
      // ... and 1e-4: the square of 0.004, which the formula leaves out, times 6 mm times 50 cycles/mm.
      const Complex<double> h = c.otf({fx, fy}, at_place(x, y));
      EXPECT_NEAR(h.re, re, 1e-4);
      EXPECT_NEAR(h.im, im, 2e-3);  // a shift of the same order
    }
}

TEST(Flow, a_shift_alone_is_a_linear_motion) {
  auto c = Component<double>::make("flow"), line = Component<double>::make("linear_motion");
  set(c, "shift", 10.0, "um");
  set(line, "travel", 10.0 * std::sqrt(2.0), "um");
  set(line, "direction", 45.0);
  for (const auto& [fx, fy] : {std::pair{20.0, 5.0}, {-60.0, 33.0}})
    EXPECT_NEAR(otf_at(c, fx, fy).re, otf_at(line, fx, fy).re, 1e-14);
  EXPECT_FALSE(c.traits(detector().context()).placed);
  EXPECT_TRUE(flow(0.0, 1.0).traits(detector().context()).placed);
  EXPECT_TRUE(refused(Component<double>::make("flow"), "zoom"));
}

// Beyond small motion the straight path is not the path: at a turn of 1 rad its middle is an eighth of the radius off.
TEST(Flow, is_of_small_motion) {
  const auto worst = [](double zoom, double rotation_urad) {  // 0: nothing is said, 1: a doubt, 2: an error
    System<double> s = detector();
    s.add(Stage::presample, flow(zoom, rotation_urad));
    int found = 0;
    for (const auto& [where, problem] : s.check()) found = std::max(found, problem.error ? 2 : 1);
    return found;
  };
  EXPECT_EQ(worst(0.004, 3000.0), 0);
  EXPECT_EQ(worst(-0.2, 0.0), 1);
  EXPECT_EQ(worst(1.0, 0.0), 2);
  EXPECT_EQ(worst(0.0, -1e6), 2);
}

}  // namespace
}  // namespace mtf::test
