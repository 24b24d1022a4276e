// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mtf/component.h"
#include "mtf/error.h"
#include "tests/expect_error.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/conformance.h"

namespace mtf::test {
namespace {

Curve make(std::vector<double> f, std::vector<double> v) {
  return make_curve("lens.csv", *find_unit("cy/mm"), std::move(f), std::move(v));
}

TEST(Curve, passes_through_its_samples) {
  const Curve c = make({0, 10, 25, 40, 70}, {1, 0.8, 0.75, -0.2, 0});
  for (std::size_t i = 0; i < c.frequency.size(); ++i) EXPECT_EQ(evaluate(c, c.frequency[i]).value, c.value[i]) << i;
  EXPECT_EQ(evaluate(c, -25.0).value, 0.75);
  EXPECT_EQ(evaluate(c, 12.0).slope, -evaluate(c, -12.0).slope);
  EXPECT_EQ(evaluate(c, 0.0).slope, 0.0);
}

TEST(Curve, straight_samples_stay_straight) {
  const Curve c = make({0, 10, 35, 50}, {1, 0.8, 0.3, 0});
  for (double f = 0.5; f < 50.0; f += 0.7) {
    EXPECT_NEAR(evaluate(c, f).value, 1.0 - f / 50.0, 1e-15);
    EXPECT_NEAR(evaluate(c, f).slope, -0.02, 1e-15);
  }
}

TEST(Curve, no_overshoot_and_monotone_between_samples) {
  Random random(7);
  for (int round = 0; round < 200; ++round) {
    std::vector<double> f{0.0}, v{1.0};
    for (int i = 0; i < 8; ++i) {
      f.push_back(f.back() + random.decades(0.01, 30.0));
      v.push_back(random.uniform(-0.3, 1.0));
    }
    const Curve c = make(f, v);
    for (std::size_t i = 0; i + 1 < f.size(); ++i) {
      double previous = v[i];
      const double direction = v[i + 1] >= v[i] ? 1.0 : -1.0;
      for (int k = 1; k <= 50; ++k) {
        const double value = evaluate(c, f[i] + (f[i + 1] - f[i]) * k / 50.0 * (1.0 - 1e-15)).value;
        EXPECT_GE(direction * (value - previous), -1e-14) << round << " " << i;
        EXPECT_LE(value, std::max(v[i], v[i + 1]) + 1e-15);
        EXPECT_GE(value, std::min(v[i], v[i + 1]) - 1e-15);
        previous = value;
      }
    }
  }
}

TEST(Curve, value_and_slope_are_continuous) {
  const Curve c = make({0, 3, 20, 21, 60}, {1, 0.95, 0.5, 0.2, 0.1});
  for (const double f : {3.0, 20.0, 21.0}) {
    const double step = 1e-9;
    EXPECT_NEAR(evaluate(c, f - step).value, evaluate(c, f).value, 1e-9);
    EXPECT_NEAR(evaluate(c, f - step).slope, evaluate(c, f).slope, 1e-8) << f;
    EXPECT_NEAR(evaluate(c, f + step).slope, evaluate(c, f).slope, 1e-8) << f;
  }
  for (double f = 0.1; f < 90.0; f += 0.37) {
    const double h = 1e-6;
    EXPECT_NEAR(evaluate(c, f).slope, (evaluate(c, f + h).value - evaluate(c, f - h).value) / (2 * h), 1e-6) << f;
  }
}

TEST(Curve, starts_from_one) {
  const Curve c = make({10, 20}, {0.9, 0.5});
  EXPECT_EQ(evaluate(c, 0.0).value, 1.0);
  EXPECT_EQ(c.frequency.front(), 0.0);
  EXPECT_GT(evaluate(c, 5.0).value, 0.9);
  EXPECT_LT(evaluate(c, 5.0).value, 1.0);
  EXPECT_EQ(make({0, 20}, {0.9995, 0.5}).value.front(), 1.0);  // rounding of the file
}

// Beyond the last sample: straight to 0 along the last slope, at least as steeply as 1 over the last frequency.
TEST(Curve, ends_in_zero) {
  const Curve steep = make({0, 20, 40}, {1, 0.7, 0.3});
  const double slope = steep.slope.back();
  EXPECT_NEAR(slope, -0.02, 1e-15);
  EXPECT_NEAR(evaluate(steep, 50.0).value, 0.05, 1e-15);  // 1/40 a step is steeper than the last slope
  const Curve falling = make({0, 20, 40}, {1, 0.9, 0.3});
  EXPECT_NEAR(evaluate(falling, 45.0).value, 0.15, 1e-15);  // 0.03 a step, the last slope
  EXPECT_NEAR(evaluate(falling, 45.0).slope, -0.03, 1e-15);
  for (const double f : {80.0, 1e3, 1e300}) {
    EXPECT_EQ(evaluate(steep, f).value, 0.0);
    EXPECT_EQ(evaluate(steep, f).slope, 0.0);
  }
  const Curve flat = make({0, 20, 40}, {1, 0.5, 0.5});
  EXPECT_NEAR(evaluate(flat, 50.0).value, 0.25, 1e-15);
  EXPECT_EQ(evaluate(flat, 60.0).value, 0.0);
  const Curve reversed = make({0, 20, 40}, {1, 0.1, -0.2});
  EXPECT_LT(evaluate(reversed, 41.0).value, 0.0);
  EXPECT_GT(evaluate(reversed, 41.0).value, -0.2);
  EXPECT_GT(evaluate(reversed, 41.0).slope, 0.0);
  EXPECT_EQ(evaluate(reversed, 90.0).value, 0.0);
  for (const Curve& c : {steep, falling, flat, reversed, make({0, 20, 40, 50}, {1, 0.5, 0, 0}), make({0, 5}, {1, 0})}) {
    const double end = end_of(c);
    EXPECT_EQ(evaluate(c, end * (1.0 + 1e-15)).value, 0.0);
    EXPECT_GT(std::abs(evaluate(c, 0.999 * end).value), 0.0);
  }
}

TEST(Curve, what_is_no_curve_is_refused) {
  const double nan = std::nan(""), inf = HUGE_VAL;
  const auto refusal = [](std::vector<double> f, std::vector<double> v, const char* unit = "cy/mm") -> std::string {
    return message_of<mtf::UsageError>([&] { make_curve("lens.csv", *find_unit(unit), std::move(f), std::move(v)); });
  };
  const auto expect = [](const std::string& message, const char* part) {
    expect_says(message, {part});
    EXPECT_TRUE(message.starts_with("lens.csv: ")) << message;
  };
  expect(refusal({}, {}), "two samples");
  expect(refusal({0}, {1}), "two samples");
  expect(refusal({0, 10}, {1}), "differ in length");
  expect(refusal({0, 10, 10}, {1, 0.5, 0.4}), "sample 3");
  expect(refusal({0, 20, 10}, {1, 0.5, 0.4}), "increase");
  expect(refusal({-1, 10}, {1, 0.5}), "negative frequency");
  expect(refusal({0, nan}, {1, 0.5}), "not finite");
  expect(refusal({0, inf}, {1, 0.5}), "not finite");
  expect(refusal({0, 10}, {1, nan}), "not finite");
  expect(refusal({0, 10}, {1, -1.06}), "above 1.05");
  expect(refusal({0, 10}, {100, 50}), "percent");
  expect(refusal({0, 10}, {0.9, 0.5}), "has to be 1");
  expect(refusal({0, 10}, {1, 0.5}, "mm"), "cy/mm, cy/mrad or cy/px");
}

TEST(Curve, component_reads_its_own_unit_and_axis) {
  System<double> s = mwir();
  s.frame.pitch_y_um = 30.0;
  auto c = Component<double>::make("curve");
  const auto use = [&](const char* unit, int axis) {
    *std::get<CurveSum<double>*>(field(c, "file").value) =
        std::make_shared<const Curve>(make_curve("lens.csv", *find_unit(unit), {0, 1}, {1, 0}));
    choose(c, "axis", axis);
  };
  const auto at = [&](double x, double y) { return c.otf({x, y}, s.context()).re; };
  use("cy/mm", 0);
  EXPECT_NEAR(at(0.3, 0.4), 0.5, 1e-15);
  use("cy/mrad", 1);  // 100 mm: 1 cy/mrad = 10 cy/mm
  EXPECT_NEAR(at(4.0, 99.0), 0.6, 1e-15);
  use("cy/px", 2);  // 30 um: 1 cy/px = 33.3 cy/mm
  EXPECT_NEAR(at(99.0, 20.0), 0.4, 1e-15);
  EXPECT_FALSE(c.traits(s.context()).gain);
  use("cy/px", 0);
  EXPECT_FALSE(c.traits(s.context()).radial);  // elliptic over these pixels
  EXPECT_NEAR(at(20.0, 0.0), 0.7, 1e-15);
  EXPECT_NEAR(c.cutoff_cy_mm(s.context()), 1e3 / 15.0, 1e-9);  // along the shorter side
  *std::get<CurveSum<double>*>(field(c, "file").value) =
      std::make_shared<const Curve>(make({0, 10, 20}, {1, -1.01, 0}));
  EXPECT_TRUE(c.traits(s.context()).gain);
}

}  // namespace
}  // namespace mtf::test
