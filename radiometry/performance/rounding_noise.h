// SPDX-License-Identifier: Apache-2.0
#pragma once

// The noise of rounding to whole steps behind Gaussian noise of s steps rms, as the mean over all places of the signal
// between two steps. With y = round(m + s n), V(m) and b(m) the variance and the bias of y at the signal m:
//   mean of b^2 = B(s) = sum over k >= 1 of exp(-4 pi^2 k^2 s^2)/(2 pi^2 k^2),  1/12 at s = 0, 9e-5 at s = 0.4
//   mean of V   = s^2 + 1/12 - B,  s/sqrt(pi) below s = 0.05
//   dE[y]/dm    = 1 + 2 sum of (-1)^k cos(2 pi k m) exp(-2 pi^2 k^2 s^2): 1 in the mean, least in the middle of a step
// The mean square of y - m is s^2 + 1/12 at any s; what of it does not change from frame to frame is an error that
// stays. Sheppard's 1/12 is a temporal noise where s dithers, from some 0.4 on. Below, most signals give one count
// without noise, and a change of the signal by less than a step may change nothing.
// (Widrow and Kollar, Quantization Noise, Cambridge 2008, chs. 4 and 19.)

#include "mtf/component.h"

namespace radiometry {

/// Values in steps^2, slopes by s.
struct RoundingNoise {
  mtf::ValueSlope temporal;  ///< mean of V less s^2: what rounding adds to the noise from frame to frame
  mtf::ValueSlope fixed;     ///< B: of the error that stays
  double response = 1.0;     ///< least dE[y]/dm, 0 to 1: a small change shows as that part of itself at some signals
};

/// `noise_steps`: s, 0 or above.
RoundingNoise rounding_noise(double noise_steps);

/// s of the whole temporal noise s^2 + 1/12 - B (its square, in steps^2, 0 or above), the inverse of the above.
mtf::ValueSlope noise_before_rounding(double temporal_steps2);

/// The least response from which on noise counts as dithering: s = 0.39.
inline constexpr double kDitheredResponse = 0.9;

}  // namespace radiometry
