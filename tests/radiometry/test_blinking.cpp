// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/stages/noise/blinking.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"
#include "tests/radiometry/statistics.h"

namespace radiometry {
namespace {

using test::flat;
using test::kMostSigmas;

TEST(Blinking, fraction_and_excess) {
  const Blinking blinking{.fraction = 0.02, .excess_e = 700.0};
  const auto found = find_blinking(1000, 500, blinking, 4);
  const auto n = static_cast<double>(found.size());
  EXPECT_LT(std::abs(n - 1e4) / std::sqrt(1e4), kMostSigmas);
  double sum = 0.0, squares = 0.0;
  for (const BlinkingPixel& pixel : found) {
    sum += static_cast<double>(pixel.excess_e) / n;
    squares += static_cast<double>(pixel.excess_e) * static_cast<double>(pixel.excess_e) / n;
  }
  EXPECT_LT(std::abs(sum / 700.0 - 1.0) * std::sqrt(n), kMostSigmas);
  EXPECT_LT(std::abs(squares / (2.0 * 700.0 * 700.0) - 1.0) / std::sqrt(5.0) * std::sqrt(n),
            kMostSigmas);  // exponential
  EXPECT_TRUE(find_blinking(1000, 500, {}, 4).empty());
  EXPECT_EQ(find_blinking(20, 10, {.fraction = 1.0, .excess_e = 1.0}, 4).size(), 200U);
}

// Half of the pixels are high in any frame; from one frame to one n later (1 - exp(-2 n / d))/2 of them change.
TEST(Blinking, telegraph_statistics) {
  const double pixels = 40000.0;
  for (const double dwell : {1.0, 2.7, 40.0, 3000.0})
    for (const std::uint32_t frame : {0U, 1U, 977U, 4000000000U}) {
      const Blinking blinking{.fraction = 1.0, .excess_e = 1.0, .dwell_frames = dwell};
      for (const std::uint32_t later : {1U, 2U, 30U}) {
        double high = 0.0, changed = 0.0;
        for (std::int64_t y = 0; y < 200; ++y)
          for (std::int64_t x = 0; x < 200; ++x) {
            const bool now = is_high(blinking, {7, frame}, x, y);
            high += now ? 1.0 : 0.0;
            changed += now != is_high(blinking, {7, frame + later}, x, y) ? 1.0 : 0.0;
          }
        EXPECT_LT(std::abs(high - 0.5 * pixels) / std::sqrt(0.25 * pixels), kMostSigmas) << dwell << " " << frame;
        const double p = -0.5 * std::expm1(-2.0 * later / dwell), sd = std::sqrt(p * (1.0 - p) * pixels);
        EXPECT_LT(std::abs(changed - p * pixels) / sd, kMostSigmas) << dwell << " " << frame << " " << later;
      }
    }
}

// The mean time in a state: changes of a few pixels over many frames. A state that is sampled once a frame misses short
// visits.
TEST(Blinking, dwell_over_a_long_sequence) {
  const Blinking blinking{.fraction = 1.0, .excess_e = 1.0, .dwell_frames = 50.0};
  double changed = 0.0;
  const int frames = 20000, pixels = 20;
  for (int pixel = 0; pixel < pixels; ++pixel) {
    bool before = is_high(blinking, {3, 0}, pixel, 5);
    for (std::uint32_t frame = 1; frame <= frames; ++frame) {
      const bool now = is_high(blinking, {3, frame}, pixel, 5);
      changed += now != before ? 1.0 : 0.0;
      before = now;
    }
  }
  const double expected = -0.5 * std::expm1(-2.0 / 50.0) * frames * pixels;
  EXPECT_LT(std::abs(changed - expected) / std::sqrt(expected), kMostSigmas);
}

TEST(Blinking, regions_and_frames) {
  const Blinking blinking{.fraction = 0.1, .excess_e = 50.0, .dwell_frames = 5.0};
  const Origin origin{123, 45};
  const auto all = find_blinking(300, 200, blinking, 9), some = find_blinking(40, 30, blinking, 9, origin);
  for (const std::uint32_t frame : {0U, 1U, 100U}) {
    mtf::Image whole = flat(300, 200, 10.0F), part = flat(40, 30, 10.0F);
    apply_blinking(whole.view(), all, blinking, {9, frame});
    apply_blinking(part.view(), some, blinking, {9, frame}, origin);
    for (std::int64_t y = 0; y < 30; ++y)
      for (std::int64_t x = 0; x < 40; ++x) ASSERT_EQ(part.at(x, y), whole.at(123 + x, 45 + y));
  }
  // A dwell longer than any sequence: nothing changes.
  const Blinking slow{.fraction = 1.0, .excess_e = 1.0, .dwell_frames = 1e9};
  for (std::int64_t x = 0; x < 100; ++x) EXPECT_EQ(is_high(slow, {1, 0}, x, 0), is_high(slow, {1, 10}, x, 0));
}

TEST(Blinking, refusals) {
  mtf::Image image = flat(4, 3, 1.0F);
  expect_refused({"blinking.fraction = 1.5"}, [] { find_blinking(4, 3, {.fraction = 1.5}, 1); });
  expect_refused({"blinking.dwell = 0.5"}, [] { find_blinking(4, 3, {.dwell_frames = 0.5}, 1); });
  expect_refused({"blinking.excess = -1 e-"}, [] { find_blinking(4, 3, {.excess_e = -1.0}, 1); });
  const BlinkingPixel outside{.x = 0, .y = 3};
  expect_refused({"pixel 0, 3", "4 x 3"}, [&] { apply_blinking(image.view(), {&outside, 1}, {}, {}); });
}

}  // namespace
}  // namespace radiometry
