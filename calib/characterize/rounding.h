// SPDX-License-Identifier: Apache-2.0
#pragma once

// What rounding to whole counts makes of normal noise, exactly. With the pixels' means spread evenly over a count (a
// spread of 0.5 counts rms suffices), noise of the standard deviation s has after rounding the temporal variance
//   Q(s^2) = s^2 + 1/12 - R(s^2),   R(s^2) = sum over k >= 1 of exp(-4 pi^2 k^2 s^2) / (2 pi^2 k^2)
// averaged over the pixels: the error of rounding has the variance 1/12 in all, of which R stays the same from frame to
// frame and adds to the fixed pattern (B. Widrow, I. Kollar, Quantization Noise, Cambridge 2008, ch. 4 and 5). For
// small s the same sum by Poisson's formula, Q(s^2) = s/sqrt(pi) + terms of exp(-n^2 / (4 s^2)), is used. Q is inverted
// down to s = 0.05 and below; 1/12 alone is off by 0.4 % at s = 0.4 and by 25 % at 0.2. In counts everywhere.

#include <string>

namespace calib {

/// Noise below it is told by the offset where all pixels have one: its variance is off by up to (4 s^2 + 1/pi^2)
/// exp(-2 pi^2 s^2), 0.1 % at 0.6 counts, 6 % at 0.45 (Widrow and Kollar, ch. 4).
inline constexpr double kHidden_counts = 0.6;
/// "noise below 0.6 counts, and pixels within half a count of each other", for messages.
std::string hidden_words();

/// Q and its derivative; s2 >= 0.
struct RoundedVariance {
  double value = 0.0, slope = 1.0;
};
RoundedVariance rounded_variance(double s2);
/// R: the variance over the pixels of the part of the error that is fixed.
double rounding_pattern(double s2);
/// The s^2 with Q(s^2) = v; 0 for v <= 0.
double unrounded_variance(double v);

}  // namespace calib
