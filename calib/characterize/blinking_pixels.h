// SPDX-License-Identifier: Apache-2.0
#pragma once

// Blinking pixels of a dark stack of T frames, as [blinking] of a sensor file has them
// (radiometry/stages/noise/blinking.h): two levels that are x apart, exponentially distributed over a part f of the
// pixels, P(x) = exp(-x/m)/m; from one frame to the next the level changes with the chance
//   p = (1 - exp(-2/d))/2,   d the dwell in frames
// The frames are read twice: the first time tells the pixels that are noisier than the others, the second time gives
// their values in all frames (PixelSeries). Their two levels are parted where both are as many standard deviations
// away, those of the other pixels' noise w, and of w and the shot noise of x. A pixel blinks where the noise about the
// levels is that noise, and x is above a limit X, so high that all pixels above it that change at all are noisy, and
// their levels 8 standard deviations apart. Of n such pixels
//   changes  are binomial, p of T - 1, but for those without any, which are not seen: p from their mean, its limits by
//            those of Poisson numbers, and the part s = 1 - (1 - p)^(T - 1) of the blinking pixels that are seen
//   x - X    has the mean m, and n = N f s exp(-X/m) of N pixels, as of hot ones (defect_pixels.h)
// Pixels that do not change in the stack stand as hot ones, or at their place in the pattern.

#include <array>

#include "calib/characterize/stack_statistics.h"
#include "calib/measure/measure.h"

namespace calib {

/// The values of some pixels in all frames of a stack.
struct PixelSeries {
  std::vector<std::int64_t> places{};  ///< along rows, in rising order
  std::vector<float> values{};         ///< of a frame after the other
  std::int64_t frames = 0;

  void add(mtf::ImageView<const float> frame);
};

/// The probability that a pixel of normal noise, as the others have, is counted as noisy.
inline constexpr double kNoisy_p = 1e-7;
/// What is known of the noise of others: a pixel has more than these where it is this factor above it, and more than
/// chance makes with that probability.
inline constexpr double kAlikeNoise = 1.25, kAlike_p = 1e-4;
/// Fewer frames tell too little of the two levels; and the most values that are kept of a stack.
inline constexpr std::int64_t kBlinkFrames = 8, kMostSeriesValues = 1 << 22;

struct BlinkingPixel {
  std::int64_t place = 0;
  double excess = 0.0;   ///< counts
  double changes = 0.0;  ///< in T - 1 steps
  double high = 0.0;     ///< part of the frames
};

struct BlinkingNoise {
  std::vector<BlinkingPixel> pixels{};  ///< with an excess above the limit
  double least = 0.0, scatter = 0.0;    ///< X, and the rms error of an excess
  Estimate change{};                    ///< p; sd 0: not known
  std::array<double, 2> change95{};     ///< its limits
  double seen = 1.0;                    ///< s
  std::int64_t frames = 0;

  /// Variance of the share of n frames in which a pixel is high.
  double share_variance(double n) const;
};

/// s, of that chance of a change.
double seen_part(double change, double steps);

/// `white`: variance of a pixel that does not blink; `shot`: of the shot noise of an excess of one count.
BlinkingNoise estimate_blinking(const PixelSeries& series, double white, double shot);

}  // namespace calib
