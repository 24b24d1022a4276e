// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "radiometry/stages/noise/flicker.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"
#include "tests/radiometry/statistics.h"

namespace radiometry {
namespace {

using test::flat;
using test::kMostSigmas;

constexpr Flicker kFlicker{.white_e = 30.0, .corner_cy_px = 0.02};

/// Periodogram with a Hann window at k cycles per line, e-^2 per (cycle per pixel). The window sees
/// 2/3 S(k) + (S(k - 1) + S(k + 1)) / 6.
double periodogram(const mtf::Image& line, std::int64_t k) {
  const auto n = static_cast<double>(line.width());
  double re = 0.0, im = 0.0;
  for (std::int64_t i = 0; i < line.width(); ++i) {
    const double turn = 2.0 * mtf::kPi * static_cast<double>(i) / n;
    const double value = 0.5 * (1.0 - std::cos(turn)) * static_cast<double>(line.at(i, 0));
    re += value * std::cos(static_cast<double>(k) * turn);
    im += value * std::sin(static_cast<double>(k) * turn);
  }
  return (re * re + im * im) / (n * 3.0 / 8.0);
}

// Density, slope and corner: lines of 4096 pixels, 2000 frames; the mean of a periodogram has 1/sqrt(2000) of itself.
TEST(Flicker, spectrum) {
  const std::int64_t n = 4096;
  const int frames = 2000;
  const std::vector<std::int64_t> ks{8, 16, 33, 64, 82, 131, 260, 517, 900, 1400, 1800, 2040};
  std::vector<double> mean(ks.size(), 0.0), with_white(ks.size(), 0.0);
  mtf::Image line(n, 1);
  for (std::uint32_t frame = 0; frame < frames; ++frame) {
    std::fill_n(line.data(), n, 0.0F);
    add_flicker(line.view(), kFlicker, n, 1, {11, frame});
    for (std::size_t i = 0; i < ks.size(); ++i) mean[i] += periodogram(line, ks[i]) / frames;
    if (frame % 4 != 0) continue;
    add_gaussian(line.view(), kFlicker.white_e, {11, frame}, Stream::read);
    for (std::size_t i = 0; i < ks.size(); ++i) with_white[i] += periodogram(line, ks[i]) * 4 / frames;
  }
  const double level = kFlicker.white_e * kFlicker.white_e;
  for (std::size_t i = 0; i < ks.size(); ++i) {
    const auto density = [&](std::int64_t k) {
      return flicker_density(kFlicker, n, 1, static_cast<double>(k) / static_cast<double>(n));
    };
    const double expected = 2.0 / 3.0 * density(ks[i]) + (density(ks[i] - 1) + density(ks[i] + 1)) / 6.0;
    EXPECT_LT(std::abs(mean[i] / expected - 1.0) * std::sqrt(frames), kMostSigmas) << ks[i];
    // The density should be W^2 fc / f, and with the white noise W^2 (1 + fc / f).
    const double f = static_cast<double>(ks[i]) / static_cast<double>(n), ideal = level * kFlicker.corner_cy_px / f;
    const double most = (f < 0.02 ? 0.05 : 0.11) + (ks[i] < 20 ? 0.01 : 0.0);  // and the window's at the lowest
    EXPECT_NEAR(mean[i] / ideal, 1.0, most + kMostSigmas / std::sqrt(frames)) << ks[i];
    EXPECT_NEAR(with_white[i] / (level + ideal), 1.0,
                most * ideal / (level + ideal) + kMostSigmas / std::sqrt(frames / 4.0))
        << ks[i];
  }
}

TEST(Flicker, density_is_one_over_f) {
  for (int i = 0; i <= 400; ++i) {
    const double f = 1e-5 * std::pow(5e4, i / 400.0);
    const double ratio = flicker_density(kFlicker, 1280, 1024, f) * f / (900.0 * 0.02);
    EXPECT_NEAR(ratio, 1.0, f <= 0.02 ? 0.045 : 0.11) << f;
  }
}

TEST(Flicker, variance_is_the_integral_of_the_density) {
  // Trigonometric polynomials: the mean over more points than their degree is exact.
  double sum = 0.0;
  const int points = 1024;
  for (int i = 0; i < points; ++i) sum += flicker_density(kFlicker, 8, 8, (i + 0.5) / points) / points;
  EXPECT_NEAR(sum / flicker_variance(kFlicker, 8, 8), 1.0, 1e-12);
  double squares = 0.0, fourth = 0.0;
  const int frames = 20000;
  for (std::uint32_t frame = 0; frame < frames; ++frame) {
    mtf::Image image = flat(8, 8, 0.0F);
    add_flicker(image.view(), kFlicker, 8, 8, {2, frame});
    double one = 0.0;
    for (const float value : test::samples(image)) one += static_cast<double>(value) * static_cast<double>(value) / 64;
    squares += one / frames;
    fourth += one * one / frames;
  }
  const double sd = std::sqrt((fourth - squares * squares) / frames);
  EXPECT_LT(std::abs(squares - flicker_variance(kFlicker, 8, 8)) / sd, kMostSigmas);
}

TEST(Flicker, pixels_follow_one_another_in_the_order_of_the_readout) {
  mtf::Image image = flat(64, 32, 0.0F), line = flat(2048, 1, 0.0F), columns = flat(32, 64, 0.0F);
  add_flicker(image.view(), kFlicker, 64, 32, {5, 1});
  add_flicker(line.view(), kFlicker, 2048, 1, {5, 1});
  EXPECT_TRUE(std::equal(image.data(), image.data() + image.size(), line.data()));
  Flicker down = kFlicker;
  down.order = ReadoutOrder::columns;
  add_flicker(columns.view(), down, 32, 64, {5, 1});
  for (std::int64_t y = 0; y < 64; ++y)
    for (std::int64_t x = 0; x < 32; ++x) ASSERT_EQ(columns.at(x, y), image.at(y, x));
}

TEST(Flicker, regions_threads_and_frames) {
  mtf::Image whole = flat(300, 200, 100.0F), again = whole.clone(), next = whole.clone(), part = flat(70, 50, 100.0F);
  add_flicker(whole.view(), kFlicker, 300, 200, {5, 1});
  add_flicker(again.view(), kFlicker, 300, 200, {5, 1}, {}, 2);
  add_flicker(next.view(), kFlicker, 300, 200, {5, 2});
  EXPECT_TRUE(std::equal(whole.data(), whole.data() + whole.size(), again.data()));
  for (const ReadoutOrder order : {ReadoutOrder::rows, ReadoutOrder::columns}) {
    Flicker flicker = kFlicker;
    flicker.order = order;
    whole = flat(300, 200, 100.0F);
    part = flat(70, 50, 100.0F);
    add_flicker(whole.view(), flicker, 300, 200, {5, 1});
    add_flicker(part.view(), flicker, 300, 200, {5, 1}, {217, 99});
    for (std::int64_t y = 0; y < 50; ++y)
      for (std::int64_t x = 0; x < 70; ++x) ASSERT_EQ(part.at(x, y), whole.at(217 + x, 99 + y));
  }
  // Frames are independent, also in their slow part: the first 400 pixels of one frame and of the next.
  std::vector<float> now, then;
  for (std::uint32_t frame = 0; frame < 401; ++frame) {
    mtf::Image first = flat(1, 1, 0.0F);
    add_flicker(first.view(), kFlicker, 300, 200, {5, frame});
    if (frame < 400) now.push_back(first.at(0, 0));
    if (frame > 0) then.push_back(first.at(0, 0));
  }
  EXPECT_LT(std::abs(test::correlation_sigmas<float>(now, then)), kMostSigmas);
}

TEST(Flicker, a_small_region_of_a_huge_detector) {
  const std::int64_t huge = std::int64_t{1} << 31;
  mtf::Image part = flat(5, 4, 0.0F), shifted = flat(5, 4, 0.0F);
  add_flicker(part.view(), kFlicker, huge, huge, {1, 0}, {huge - 5, huge - 4});
  add_flicker(shifted.view(), kFlicker, huge, huge, {1, 0}, {huge - 6, huge - 4});
  for (std::int64_t y = 0; y < 4; ++y)
    for (std::int64_t x = 1; x < 5; ++x) EXPECT_EQ(part.at(x - 1, y), shifted.at(x, y));
  EXPECT_NE(part.at(0, 0), 0.0F);
}

TEST(Flicker, nothing_and_refusals) {
  mtf::Image image = flat(4, 3, 2.0F);
  add_flicker(image.view(), {.white_e = 0.0, .corner_cy_px = 1.0}, 4, 3, {});
  add_flicker(image.view(), {.white_e = 5.0, .corner_cy_px = 0.0}, 4, 3, {});
  for (const float value : test::samples(image)) EXPECT_EQ(value, 2.0F);
  image.at(1, 1) = std::nanf("");
  add_flicker(image.view(), kFlicker, 4, 3, {});
  EXPECT_TRUE(std::isnan(image.at(1, 1)));
  EXPECT_FALSE(std::isnan(image.at(2, 1)));
  mtf::Image one = flat(1, 1, 0.0F);
  add_flicker(one.view(), kFlicker, 1, 1, {});
  EXPECT_NE(one.at(0, 0), 0.0F);
  expect_refused({"flicker.corner = -1"}, [&] { add_flicker(image.view(), {.corner_cy_px = -1.0}, 4, 3, {}); });
  expect_refused({"flicker.white = nan e-"}, [&] { add_flicker(image.view(), {.white_e = std::nan("")}, 4, 3, {}); });
  expect_refused({"region of 4 x 3", "column 1", "detector of 4 x 3"}, [&] {
    add_flicker(image.view(), kFlicker, 4, 3, {}, {1, 0});
  });
  expect_refused({"2^62"},
                 [&] { add_flicker(image.view(), kFlicker, std::int64_t{1} << 32, std::int64_t{1} << 31, {}); });
  expect_refused({"detector of 0 x 3"}, [] { flicker_variance(kFlicker, 0, 3); });
}

}  // namespace
}  // namespace radiometry
