// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mtf/math/special.h"
#include "radiometry/stages/noise/frame_flicker.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"
#include "tests/radiometry/statistics.h"

namespace radiometry {
namespace {

using test::flat;
using test::kMostSigmas;

/// 1/f from a hundredth of a hertz to 8 kHz at 50 frames a second.
constexpr FrameFlicker kNoise{.strength = 4.0, .lowest = 2e-4, .highest = 160.0};

/// K/f folded at the frames, two-sided.
double folded(const FrameFlicker& noise, double f) {
  double sum = 0.0;
  const auto add = [&](double g) {
    if (g >= noise.lowest && g <= noise.highest) sum += 0.5 * noise.strength / g;
  };
  add(f);
  for (double k = 1.0; k < noise.highest + 1.0; ++k) add(k - f), add(k + f);
  return sum;
}

TEST(FrameFlicker, density_is_that_of_folded_one_over_f) {
  for (int i = 0; i <= 200; ++i) {
    const double f = 1e-3 * std::pow(490.0, i / 200.0);
    EXPECT_NEAR(frame_flicker_density(kNoise, f) / folded(kNoise, f), 1.0, f < 0.02 ? 0.03 : 0.05) << f;
    const FrameFlicker slow{.strength = 4.0, .lowest = 2e-4, .highest = 2.0};
    EXPECT_NEAR(frame_flicker_density(slow, f) / folded(slow, f), 1.0, f < 0.02 ? 0.03 : 0.07) << f;
    for (const double highest : {0.6, 0.75, 1.0, 1.25, 1.5, 1.75}) {
      const FrameFlicker between{.strength = 4.0, .lowest = 2e-4, .highest = highest};
      EXPECT_NEAR(frame_flicker_density(between, f) / folded(between, f), 1.0,
                  f < 0.02   ? 0.03
                  : f < 0.25 ? 0.16
                             : 0.31)
          << f << " of " << highest;
    }
  }
}

// Up to half a cycle, as a photon detector has it: differences of the means of n frames and of the n after them are as
// large as 1/f noise makes them, over the frequencies in equal ratios.
TEST(FrameFlicker, octaves_up_to_half_a_cycle) {
  const FrameFlicker noise = FlickerOctaves{.octave_e = 1.5, .lowest_cy_frame = 1e-4}.noise();
  for (int n = 1; n <= 128; n *= 2) {
    constexpr int kSteps = 200000;
    const double ratio = std::log(0.5 / noise.lowest) / kSteps;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double x = mtf::kPi * noise.lowest * std::exp(ratio * (i + 0.5)), wave = std::sin(n * x);
      sum += noise.strength * ratio * 4.0 * std::pow(wave, 4) / std::pow(n * std::sin(x), 2);
    }
    const double found = 4.0 * (frame_flicker_mean_variance(noise, n) - frame_flicker_mean_variance(noise, 2 * n));
    EXPECT_NEAR(found / sum, 1.0, 0.025) << n;
  }
}

TEST(FrameFlicker, variance_is_the_integral_of_the_density) {
  double sum = 0.0;
  const int points = 1 << 18;  // more than twice the longest octave
  for (int i = 0; i < points; ++i) sum += frame_flicker_density(kNoise, std::abs((i + 0.5) / points - 0.5)) / points;
  EXPECT_NEAR(sum / frame_flicker_variance(kNoise), 1.0, 1e-9);
  EXPECT_NEAR(frame_flicker_variance(kNoise), 4.0 * std::log(160.0 / 2e-4), 1e-12);
}

/// Periodograms of 256 pixels over 4096 frames with a Hann window, which sees 2/3 S(k) + (S(k - 1) + S(k + 1))/6.
TEST(FrameFlicker, spectrum_over_4096_frames) {
  constexpr int kFrames = 4096, kPixels = 256;
  std::vector<float> values(static_cast<std::size_t>(kFrames) * kPixels);
  for (int n = 0; n < kFrames; ++n) {
    mtf::Image frame = flat(16, 16, 0.0F);
    add_frame_flicker(frame.view(), kNoise, {3, static_cast<std::uint32_t>(n)}, {100, 40});
    for (int p = 0; p < kPixels; ++p) values[static_cast<std::size_t>(p * kFrames + n)] = frame.data()[p];
  }
  for (const int k : {4, 8, 16, 41, 82, 164, 410, 819, 1638, 2000}) {
    double power = 0.0;
    for (int p = 0; p < kPixels; ++p) {
      double re = 0.0, im = 0.0;
      for (int n = 0; n < kFrames; ++n) {
        const double turn = 2.0 * mtf::kPi * n / kFrames;
        const double value =
            0.5 * (1.0 - std::cos(turn)) * static_cast<double>(values[static_cast<std::size_t>(p * kFrames + n)]);
        re += value * std::cos(k * turn);
        im += value * std::sin(k * turn);
      }
      power += (re * re + im * im) / (kFrames * 3.0 / 8.0) / kPixels;
    }
    const auto density = [&](int j) { return folded(kNoise, static_cast<double>(j) / kFrames); };
    const double expected = 2.0 / 3.0 * density(k) + (density(k - 1) + density(k + 1)) / 6.0;
    EXPECT_NEAR(power / expected, 1.0, 0.05 + kMostSigmas / std::sqrt(kPixels)) << k;
  }
}

TEST(FrameFlicker, every_frame_has_the_same_variance) {
  for (const std::uint32_t n : {0U, 1U, 7U, 1000U, 123456789U}) {
    mtf::Image frame = flat(128, 128, 0.0F);
    add_frame_flicker(frame.view(), kNoise, {9, n});
    const auto found = test::moments(test::samples(frame));
    EXPECT_LT(std::abs(found.variance / frame_flicker_variance(kNoise) - 1.0) * std::sqrt(0.5 * 128 * 128),
              kMostSigmas);
  }
}

TEST(FrameFlicker, a_region_is_a_crop_of_the_detector) {
  mtf::Image whole = flat(40, 30, 5.0F), part = flat(10, 6, 5.0F);
  add_frame_flicker(whole.view(), kNoise, {9, 77}, {}, 2);
  add_frame_flicker(part.view(), kNoise, {9, 77}, {13, 9});
  for (std::int64_t y = 0; y < 6; ++y)
    for (std::int64_t x = 0; x < 10; ++x) EXPECT_EQ(part.at(x, y), whole.at(x + 13, y + 9));
}

TEST(FrameFlicker, what_cannot_be_is_refused) {
  mtf::Image image = flat(2, 2, 0.0F);
  for (const FrameFlicker& wrong :
       {FrameFlicker{1.0, 0.0, 1.0}, FrameFlicker{1.0, 2.0, 1.0}, FrameFlicker{-1.0, 0.1, 1.0}})
    expect_refused({"1/f noise of frames", "above 0 and rise"}, [&] {
      add_frame_flicker(image.view(), wrong, {1, 0});
    });
}

/// By another route: the density times the response of a mean of n frames, (sin(pi f n)/(n sin(pi f)))^2.
TEST(FrameFlicker, the_mean_of_frames_keeps_what_the_density_says) {
  const FrameFlicker noise{2.0, 1e-3, 40.0};
  for (const int frames : {1, 2, 7, 64}) {
    constexpr int kSteps = 400000;
    double sum = 0.0;  // midpoints of u^3, which crowd where the density peaks
    for (int i = 0; i < kSteps; ++i) {
      const double u = (i + 0.5) / kSteps, f = 0.5 * u * u * u;
      const double mean = std::sin(mtf::kPi * f * frames) / (frames * std::sin(mtf::kPi * f));
      sum += 2.0 * frame_flicker_density(noise, f) * mean * mean * 1.5 * u * u / kSteps;
    }
    EXPECT_NEAR(frame_flicker_mean_variance(noise, frames) / sum, 1.0, 1e-6) << frames;
  }
  EXPECT_NEAR(frame_flicker_mean_variance(noise, 1), frame_flicker_variance(noise), 1e-13);
}

}  // namespace
}  // namespace radiometry
