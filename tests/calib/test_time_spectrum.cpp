// SPDX-License-Identifier: Apache-2.0

// Spectra of patterns. The noise in time by octaves: its sum is the variance of the analysis of variance, its shape
// that of known noise, and its scatter what the page of `mtf characterize` draws as a band.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "calib/characterize/characterize.h"

namespace calib {
namespace {

using Engine = std::mt19937_64;

/// White noise of pixels, rows and frames, the first autoregressive: x(t) = memory x(t - 1) + noise.
StackSummary drawn(std::int64_t width, std::int64_t height, int frames, double memory, double row, Engine& engine) {
  std::normal_distribution<double> normal;
  StackStatistics sums(width, height);
  mtf::Image state(width, height), frame(width, height);
  std::fill_n(state.data(), state.size(), 0.0F);
  for (int t = -50; t < frames; ++t) {
    for (std::int64_t y = 0; y < height; ++y) {
      const double line = row * normal(engine);
      for (std::int64_t x = 0; x < width; ++x) {
        state.at(x, y) = static_cast<float>(memory * static_cast<double>(state.at(x, y)) + normal(engine));
        frame.at(x, y) = 1000.0F + state.at(x, y) + static_cast<float>(line);
      }
    }
    if (t >= 0) sums.add(frame.view());
  }
  return summary_of(sums);
}

// Parseval, for as many frames as a power of two: (T - 1) times the sample variance, of floats.
TEST(TimeSpectrum, SumsToTheVariances) {
  Engine engine(1);
  for (const int frames : {2, 4, 16, 64}) {
    const StackSummary s = drawn(30, 20, frames, 0.6, 0.5, engine);
    const double times = frames - 1.0, variance = pixel_variance(s.squares);
    double sum = 0.0, of_frames = 0.0;
    for (std::size_t j = 0; j < s.noise.mean.size(); ++j) {
      sum += s.noise.differences(j) * s.noise.mean[j];
      of_frames += s.noise.frame[j];
    }
    EXPECT_NEAR(sum, times * variance, 1e-5 * times * variance);
    const double of_means = s.squares.value[radiometry::kT] / 600.0;
    EXPECT_NEAR(of_frames, times * of_means, 1e-4 * times * of_means);
    std::int64_t pixels = 0;
    for (const auto& [k, count] : pixels_by_variance(s)) pixels += count;
    EXPECT_EQ(pixels, 600);
  }
}

// Of x(t) = r x(t - 1) + white, whose frames k apart have the covariance r^k / (1 - r^2): the variance of the
// difference of two stretches of n frames, by its n^2 pairs.
TEST(TimeSpectrum, HasTheShapeOfKnownNoise) {
  Engine engine(2);
  const double r = 0.5;
  const StackSummary s = drawn(32, 32, 2100, r, 0.0, engine);
  ASSERT_EQ(s.noise.mean.size(), 11U);
  for (std::size_t j = 0; j < s.noise.mean.size(); ++j) {
    const int n = 1 << j;
    double sum = 0.0;
    for (int a = 0; a < 2 * n; ++a)
      for (int b = 0; b < 2 * n; ++b) sum += ((a < n) == (b < n) ? 1.0 : -1.0) * std::pow(r, std::abs(a - b));
    EXPECT_NEAR(s.noise.mean[j] / (sum / (2.0 * n * (1.0 - r * r))), 1.0,
                5.0 * std::sqrt(2.0 / (1024.0 * s.noise.differences(j))))
        << j;
  }
}

// Rows of 16 pixels that share noise scatter more than as many pixels; variance_of_products() says by how much. Of 400
// draws the variance of a ratio is known to 7 %; that of an average of few rows has a longer tail.
TEST(TimeSpectrum, ScattersAsStated) {
  Engine engine(3);
  for (const double row : {0.0, 1.0}) {
    double squares = 0.0, stated = 0.0;
    constexpr int kDraws = 400;
    for (int draw = 0; draw < kDraws; ++draw) {
      const StackSummary s = drawn(16, 16, 32, 0.0, row, engine);
      for (std::size_t j = 0; j < 5; ++j)
        squares += 0.1 * s.noise.differences(j) * std::pow(s.noise.mean[j] / (1.0 + row * row) - 1.0, 2) / kDraws;
      stated += variance_of_products(s, 256.0, 16.0) / kDraws;
    }
    EXPECT_NEAR(squares / stated, 1.0, 0.2) << row;
  }
}

// White noise has its variance at every frequency, a wave its power n A^2/4 at its own (Parseval), in rows of any
// length.
TEST(Spectrum, OfRowsAndColumns) {
  constexpr std::int64_t kWidth = 49, kHeight = 2000;
  Engine engine(3);
  std::normal_distribution<float> normal(0.0F, 2.0F);
  mtf::Image plane(kWidth, kHeight);
  for (std::int64_t y = 0; y < kHeight; ++y)
    for (std::int64_t x = 0; x < kWidth; ++x)
      plane.at(x, y) =
          normal(engine) +
          static_cast<float>(3.0 * std::cos(2.0 * std::numbers::pi * 7.0 * static_cast<double>(x) / kWidth));
  const std::vector<double> rows = line_spectrum(plane.view(), LineAxis::rows);
  ASSERT_EQ(rows.size(), 24U);
  for (std::size_t k = 1; k <= rows.size(); ++k)  // each is the mean of 2000 exponential numbers
    EXPECT_NEAR(rows[k - 1], k == 7 ? 4.0 + kWidth * 9.0 / 4.0 : 4.0, k == 7 ? 3.0 : 4.5 * 4.0 / std::sqrt(2000.0))
        << k;
  EXPECT_EQ(line_spectrum(plane.view(), LineAxis::columns).size(), 1000U);
}

}  // namespace
}  // namespace calib
