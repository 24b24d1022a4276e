// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/stages/detector/lag.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"

namespace radiometry {
namespace {

using test::flat;

TEST(Lag, follows_a_step_as_an_exponential) {
  for (const double tau_s : {1e-3, 0.01, 0.3, 50.0}) {
    LagState state;
    mtf::Image frame = flat(3, 2, 100.0F);
    apply_lag(frame.view(), {.time_constant_s = tau_s}, 0.02, state);
    EXPECT_EQ(frame.at(2, 1), 100.0F);  // in the steady state
    for (int n = 1; n <= 50; ++n) {
      frame = flat(3, 2, 400.0F);
      apply_lag(frame.view(), {.time_constant_s = tau_s}, 0.02, state);
      EXPECT_NEAR(frame.at(1, 1), 100.0 - 300.0 * std::expm1(-0.02 * n / tau_s), 3e-5) << tau_s << " " << n;
    }
  }
}

TEST(Lag, a_constant_scene_is_exact_and_slow_pixels_creep_on) {
  LagState state;
  for (int n = 0; n < 100; ++n) {
    mtf::Image frame = flat(2, 2, 123.4567F);
    apply_lag(frame.view(), {.time_constant_s = 0.013}, 1.0 / 60.0, state);
    ASSERT_EQ(frame.at(0, 0), 123.4567F);
  }
  // 1e-8 a frame: far below the step of a float, and yet it adds up.
  LagState slow;
  mtf::Image frame = flat(1, 1, 1e6F);
  apply_lag(frame.view(), {.time_constant_s = 1e6}, 0.01, slow);
  for (int n = 0; n < 100000; ++n) {
    frame.at(0, 0) = 2e6F;
    apply_lag(frame.view(), {.time_constant_s = 1e6}, 0.01, slow);
  }
  EXPECT_NEAR(frame.at(0, 0), 1e6 - 1e6 * std::expm1(-1e-3), 0.1);
}

TEST(Lag, pixels_that_were_not_finite_start_anew) {
  LagState state;
  for (const float value : {1.0F, std::nanf(""), 3.0F, INFINITY, 5.0F}) {
    mtf::Image frame = flat(1, 1, value);
    apply_lag(frame.view(), {.time_constant_s = 1.0}, 0.1, state);
    if (value == 3.0F || value == 5.0F) {
      EXPECT_EQ(frame.at(0, 0), value);
    } else {
      EXPECT_EQ(std::isfinite(frame.at(0, 0)), std::isfinite(value));
    }
  }
}

TEST(Lag, refusals) {
  LagState state;
  mtf::Image frame = flat(4, 3, 1.0F), other = flat(3, 4, 1.0F);
  expect_refused({"lag.time_constant = 0 s"}, [&] { apply_lag(frame.view(), {.time_constant_s = 0.0}, 0.1, state); });
  expect_refused({"0 s from frame"}, [&] { apply_lag(frame.view(), {}, 0.0, state); });
  expect_refused({"nan s from frame"}, [&] { apply_lag(frame.view(), {}, std::nan(""), state); });
  apply_lag(frame.view(), {}, 0.1, state);
  expect_refused({"3 x 4", "4 x 3"}, [&] { apply_lag(other.view(), {}, 0.1, state); });
}

}  // namespace
}  // namespace radiometry
