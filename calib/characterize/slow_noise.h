// SPDX-License-Identifier: Apache-2.0
#pragma once

// 1/f noise of pixels from frame to frame: S(f) = K/f, one-sided, from `lowest` to half a cycle per frame, beside white
// noise W^2, as [frame_flicker] of a sensor file has it (radiometry/stages/noise/frame_flicker.h): K ln 2 in an octave.
// The mean of n frames keeps
//   V(n) = integral of (sin(pi n f)/(n sin(pi f)))^2 df/f    times K,
// differences of the scale n (spectra.h) have the variance W^2 + K 2 n (V(n) - V(2 n)). W^2 and K are fitted to the
// mean squares at all scales of a dark stack, each with the error of its number of pixels and differences, and 3 % of
// the 1/f part, within which the noise of the chain follows 1/f. Pixels that change more slowly or are noisier than
// those others make any, as blinking and hot ones, are left out; so is what all pixels of a frame share. Frames resolve
// what is faster than T of them: slower noise moves pixels as a fixed pattern does. `lowest` is a tenth of a cycle in
// the stack; the part from there on of its mean frame is counted as noise, the rest as DSNU. In T frames the mean
// square tvh has K `within`, the mean frame K `of_mean` more than tvh/T.

#include "calib/characterize/stack_statistics.h"
#include "calib/measure/measure.h"

namespace calib {

/// Fewer frames have too few scales to tell 1/f noise from other noise that lasts.
inline constexpr std::int64_t kSlowFrames = 16;

struct SlowNoise {
  Estimate strength{};  ///< K, counts^2; sd 0: not known
  Estimate corner{};    ///< K/(2 W^2), cycles per frame
  double lowest = 0.0;  ///< cycles per frame
  double p = 1.0;       ///< of scales that differ as much by chance
  bool found = false;   ///< it is above 3 sd, and the scales are those of 1/f noise; else none is assumed
  std::int64_t frames = 0;
  std::vector<char> left_out{};  ///< of the pixels of NoiseScales; 2: slower than the others, 1: noisier

  double within(double n) const;  ///< of n frames
  double of_mean(double n) const;
  double within_sd(double n) const { return found ? within(n) * strength.sd / strength.value : 0.0; }
  double of_mean_sd(double n) const { return found ? of_mean(n) * strength.sd / strength.value : 0.0; }
  /// Degrees of freedom of a temporal variance over those of white noise.
  double freedom(double variance, double n) const;
};

/// `lines`: variance of the mean square of a frame that noise of rows and columns makes, over 2.
SlowNoise estimate_slow_noise(const NoiseScales& noise, double lines);

}  // namespace calib
