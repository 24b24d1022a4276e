// SPDX-License-Identifier: Apache-2.0
#pragma once

// Values that end at a limit within the noise of a side, as those of a dark side do whose mean is 1.5 standard
// deviations above the converter's zero. Pixels at the limit left out, the mean of the others is too high; taken at
// their value, it is too high too. That they lie somewhere beyond the limit is what they tell, and the likelihood of
// all is largest where each of them has the value that is expected of it (J. Tobin, Econometrica 26, 24 (1958), for the
// model; A. P. Dempster et al., J. R. Stat. Soc. B 39, 1 (1977), for the solution by alternation): for a pixel of the
// mean m and the noise s, at or below the limit L,
//   m - s r,  r = phi(z) / Phi(z),  z = (L - m) / s,
// with the deviation s sqrt(1 - z r - r^2), by which they lie above and below it in turn: the scatter of the pixels is
// then that of the noise, too.

#include "calib/edge/edge_pixels.h"
#include "calib/measure/edge_fit.h"
#include "calib/measure/measure.h"

namespace calib {

/// The limits that the options state; for one that they leave open, the end of the values where they are heaped up
/// there: more pixels have the last value than the next one, and noise makes the values between them continuous.
struct FoundLimits {
  ValueLimits limits;
  std::int64_t heaped = 0;  ///< pixels at limits that were found
};
FoundLimits find_limits(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& region,
                        const MeasureOptions& options, double noise_sd);

/// Pixels at or beyond a limit, in the unit of EdgePixels::value.
struct CutPixels {
  EdgePixels pixels{0};
  double low = -INFINITY, high = INFINITY;  ///< values at or below, at or above are cut off
};
/// Those within `range_px` of the curve.
CutPixels gather_cut(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& region,
                     const ValueLimits& limits, const EdgeCurve& curve, double range_px, const Rounding& rounding);

/// Adds those that noise takes beyond a limit (others, as reflections, are no part of the edge); returns how many.
std::size_t add_cut(EdgePixels& pixels, const CutPixels& cut, const EdgeModel& model, const FitState& state);
/// Gives each pixel beyond a limit its expected value under the model.
void expect_cut(EdgePixels& pixels, const CutPixels& limits, const EdgeModel& model, const FitState& state);

}  // namespace calib
