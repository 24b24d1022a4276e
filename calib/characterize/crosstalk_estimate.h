// SPDX-License-Identifier: Apache-2.0
#pragma once

// Crosstalk between pixels from the covariances of their shot noise. Charge that couples to its neighbours after it was
// collected (interpixel capacitance) makes the noise of a pixel part of theirs: with the fractions s to each side and c
// to each corner, h0 = 1 - 4 s - 4 c, white shot noise of the variance W has the covariances
//   r00 = h0^2 + 4 s^2 + 4 c^2   at the pixel itself,   r01 = 2 s h0 + 4 s c   at one column or row,
//   r11 = 2 c h0 + 2 s^2         at a corner,           times W
// So the variance, and the gain that is taken from it, is low by r00: by 15 % at s = 0.02 (A. C. Moore, Z. Ninkov,
// W. J. Forrest, Opt. Eng. 45, 076402 (2006)). The covariances grow with the light as the shot noise does; their slopes
// against it are r01/r00 and r11/r00. Noise of the readout does not enter, nor does charge that diffuses before it is
// collected, which leaves no covariance.

#include <array>
#include <vector>

#include "calib/characterize/stack_statistics.h"
#include "calib/measure/measure.h"

namespace calib {

/// A stack: the covariances of its pixels' noise at kLags, and the shot noise of a pixel, in counts^2.
struct CorrelatedLevel {
  std::array<Estimate, kLags.size()> covariance{};  ///< sd 0: not known
  double shot = 0.0;
};

struct CrosstalkEstimate {
  Estimate side, corner;
  Estimate power{1.0, 0.0};                    ///< r00: apparent gain over gain
  std::array<Estimate, kLags.size()> ratio{};  ///< covariance over shot noise
  bool found = false;  ///< the side is above 3 standard deviations; else none is assumed: corner 0, power 1
  bool corner_found = false;
};

CrosstalkEstimate estimate_crosstalk(const std::vector<CorrelatedLevel>& levels);

/// The plane before crosstalk, by iteration; neighbours beyond the border have the value at the border.
void undo_crosstalk(mtf::Image& plane, double side, double corner);

}  // namespace calib
