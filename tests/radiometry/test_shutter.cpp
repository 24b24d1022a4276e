// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/stages/detector/shutter.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"

namespace radiometry {
namespace {

using test::flat;

constexpr double kFrame_s = 0.02;
constexpr Shutter kRolling{.kind = ShutterKind::rolling, .line_time_s = 1e-4};

/// A scene whose pixels change steadily, each at its own rate.
mtf::Image scene(double time_s) {
  mtf::Image image(7, 100);
  for (std::int64_t y = 0; y < 100; ++y)
    for (std::int64_t x = 0; x < 7; ++x)
      image.at(x, y) = static_cast<float>(1000.0 + static_cast<double>(x * y) +
                                          (300.0 * static_cast<double>(x) - 50.0 * static_cast<double>(y)) * time_s);
  return image;
}

TEST(Shutter, rows_of_a_steady_change_are_of_their_own_time) {
  ShutterState state;
  for (int n = 0; n < 4; ++n) {
    mtf::Image frame = scene(n * kFrame_s);
    apply_shutter(frame.view(), kRolling, kFrame_s, 100, state);
    for (std::int64_t y = 0; y < 100; ++y) {
      // The first frame has none before it.
      const double time_s = n * kFrame_s - (n == 0 ? 0.0 : static_cast<double>(99 - y) * 1e-4);
      const mtf::Image expected = scene(time_s);
      for (std::int64_t x = 0; x < 7; ++x) ASSERT_NEAR(frame.at(x, y), expected.at(x, y), 2e-4);
    }
  }
}

TEST(Shutter, global_regions_and_nan) {
  ShutterState global, whole, part;
  for (int n = 0; n < 3; ++n) {
    mtf::Image frame = scene(n * kFrame_s), cut(7, 20);
    std::copy_n(frame.view().row(60), 7 * 20, cut.data());
    apply_shutter(frame.view(), {}, kFrame_s, 100, global);
    EXPECT_EQ(frame.at(3, 3), scene(n * kFrame_s).at(3, 3));
    apply_shutter(frame.view(), kRolling, kFrame_s, 100, whole);
    apply_shutter(cut.view(), kRolling, kFrame_s, 100, part, 60);
    for (std::int64_t y = 0; y < 20; ++y) ASSERT_EQ(cut.at(5, y), frame.at(5, 60 + y));
  }
  EXPECT_EQ(global.before.size(), 0);
  ShutterState state;
  mtf::Image bad = flat(1, 2, std::nanf("")), good = flat(1, 2, 1.0F);
  apply_shutter(bad.view(), kRolling, kFrame_s, 2, state);
  apply_shutter(good.view(), kRolling, kFrame_s, 2, state);
  EXPECT_TRUE(std::isnan(good.at(0, 0)));
  EXPECT_EQ(good.at(0, 1), 1.0F);
}

TEST(Shutter, refusals) {
  ShutterState state;
  mtf::Image frame = flat(4, 3, 1.0F), other = flat(3, 3, 1.0F);
  const auto shutter = [&](const Shutter& settings, double frame_s, std::int64_t rows, std::int64_t first) {
    apply_shutter(frame.view(), settings, frame_s, rows, state, first);
  };
  expect_refused({"line_time", "missing"}, [&] { shutter({.kind = ShutterKind::rolling}, 0.1, 3, 0); });
  expect_refused({"3 rows take longer", "1e-04 s"}, [&] { shutter(kRolling, 1e-4, 3, 0); });
  expect_refused({"longer", "nan s"}, [&] { shutter(kRolling, std::nan(""), 3, 0); });
  expect_refused({"rows 1 to 3", "detector of 3"}, [&] { shutter(kRolling, 0.1, 3, 1); });
  expect_refused({"shutter.line_time = -1 s"}, [&] { shutter({.line_time_s = -1.0}, 0.1, 3, 0); });
  shutter(kRolling, 0.1, 3, 0);
  expect_refused({"3 x 3", "4 x 3"}, [&] { apply_shutter(other.view(), kRolling, 0.1, 3, state); });
}

}  // namespace
}  // namespace radiometry
