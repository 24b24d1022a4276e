// SPDX-License-Identifier: Apache-2.0

// Spectra of the noise in time: their sum is the variance of the analysis of variance, their shape that of known noise,
// and their scatter what the page of `mtf characterize` draws as a band.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "calib/characterize/characterize.h"

namespace calib {
namespace {

using Engine = std::mt19937_64;

/// Sum over all frequencies but 0 of the two-sided spectrum.
double sum_of(const std::vector<double>& power, std::int64_t length) {
  double sum = 0.0;
  for (std::size_t k = 1; k <= power.size(); ++k)
    sum += (static_cast<std::int64_t>(2 * k) == length ? 1.0 : 2.0) * power[k - 1];
  return sum;
}

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

// Parseval: (T - 1) times the sample variance, of floats.
TEST(TimeSpectrum, SumsToTheVariances) {
  Engine engine(1);
  for (const int frames : {2, 3, 16, 45}) {
    const StackSummary s = drawn(30, 20, frames, 0.6, 0.5, engine);
    EXPECT_EQ(s.in_time.of_pixels, 600);
    EXPECT_EQ(s.in_time.length, frames);
    const double times = frames - 1.0, variance = pixel_variance(s.squares);
    EXPECT_NEAR(sum_of(s.in_time.pixels, frames), times * variance, 1e-5 * times * variance);
    const double of_means = s.squares.value[radiometry::kT] / 600.0;
    EXPECT_NEAR(sum_of(s.in_time.means, frames), times * of_means, 1e-4 * times * of_means);
    std::int64_t pixels = 0;
    for (const auto& [k, count] : pixels_by_variance(s)) pixels += count;
    EXPECT_EQ(pixels, 600);
  }
}

// Power of x(t) = r x(t - 1) + white: 1 / |1 - r exp(-2 pi i f)|^2, whose ends leak 1e-3 of it at most. Of 2100 frames
// two runs of 1024 are averaged.
TEST(TimeSpectrum, HasTheShapeOfKnownNoise) {
  Engine engine(2);
  const StackSummary s = drawn(32, 32, 2100, 0.5, 0.0, engine);
  EXPECT_EQ(s.in_time.length, 1024);
  EXPECT_EQ(s.in_time.runs, 2);
  for (std::size_t k = 1; k < 512; ++k) {
    const double f = static_cast<double>(k) / 1024.0;
    const double power = 1.0 / (1.25 - std::cos(2.0 * std::numbers::pi * f));
    EXPECT_NEAR(s.in_time.pixels[k - 1] / power, 1.0, 5.0 / std::sqrt(2.0 * 1024.0) + 2e-3) << k;
  }
}

// Rows of 16 pixels that share noise scatter more than as many pixels; variance_of_products() says by how much. Of 150
// draws and 15 frequencies the variance of a ratio is known to 3 %; that of an average of few rows has a longer tail.
TEST(TimeSpectrum, ScattersAsStated) {
  Engine engine(3);
  for (const double row : {0.0, 1.0}) {
    double squares = 0.0, stated = 0.0;
    int count = 0;
    for (int draw = 0; draw < 150; ++draw) {
      const StackSummary s = drawn(16, 16, 32, 0.0, row, engine);
      const double white = 1.0 + row * row;
      for (std::size_t k = 1; k < 16; ++k, ++count) squares += std::pow(s.in_time.pixels[k - 1] / white - 1.0, 2);
      stated += variance_of_products(s, 256.0, 16.0) / 150.0;
    }
    EXPECT_NEAR(squares / count / stated, 1.0, 0.2) << row;
  }
}

// Of large frames some pixels are taken, in every column and every row: one that flickers alone is seen.
TEST(TimeSpectrum, ReachesEveryColumnAndRow) {
  for (const auto& [width, height] : {std::pair{320, 256}, std::pair{321, 97}, std::pair{50, 41}})
    for (const bool column : {true, false})
      for (int line = 0; line < (column ? width : height); line += 7) {
        StackStatistics sums(width, height);
        for (int t = 0; t < 2; ++t) {
          mtf::Image frame(width, height);
          std::fill_n(frame.data(), frame.size(), 0.0F);
          for (int i = 0; i < (column ? height : width); ++i)
            frame.at(column ? line : i, column ? i : line) = static_cast<float>(t);
          sums.add(frame.view());
        }
        EXPECT_GT(sums.time_spectra().pixels.at(0), 0.0) << width << " x " << height << ", " << line;
      }
}

}  // namespace
}  // namespace calib
