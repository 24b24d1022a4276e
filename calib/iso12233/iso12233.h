// SPDX-License-Identifier: Apache-2.0
#pragma once

// The edge-based spatial frequency response as commonly computed after ISO 12233:2023, to compare with other programs:
// 1. The region is turned so that its edge is closer to vertical than to horizontal.
// 2. Each row's edge position is the centroid of its windowed differences; a polynomial goes through the positions, the
//    windows are centred on it and the fit is repeated.
// 3. The rows are cut to whole cycles of the edge's phase against the pixels, after the slope of a straight fit.
// 4. Pixels fall along the polynomial into bins of a quarter pixel; their averages are the edge spread function.
// 5. Its central differences, windowed about their maximum over the whole width, are transformed; the modulus is
//    divided by its value at 0 and by the response of the differences. Frequencies are scaled to the edge's normal by
//    1 / cos of the slope's angle.
// Known biases, left in on purpose: the average over quarter-pixel bins is not divided out (up to -2 % in MTF50), the
// result depends on the width of the region, noise is not smoothed. measure.h has none of them. Clipped pixels count
// with the values that they have, which makes the edge too sharp: a warning says so where measure.h sees clipping.
// Source: the standard's fourth edition as its reference program computes it; tests/calib/test_iso12233.cpp compares.

#include <optional>
#include <string>
#include <vector>

#include "calib/measure/measure.h"

namespace calib {

struct Iso12233Options {
  int order = 5;           ///< of the polynomial edge, 1 to 5
  bool tukey = true;       ///< Tukey window (alpha = 1); otherwise Hamming
  MeasureOptions image{};  ///< saturation, floor and steps of its values: measure_edge tells clipping by them
};

struct Iso12233Result {
  Roi roi;
  Trouble trouble = Trouble::none;      ///< none: everything below holds
  std::string reason;                   ///< what is wrong and what to change, one sentence; "" without trouble
  std::vector<std::string> warnings;    ///< the method's bias always, then what to be careful with
  double angle_deg = 0.0;               ///< of the normal at the straight fit, in (-90, 90]
  double contrast = 0.0;                ///< |bright - dark| / (bright + dark) of the columns at the sides
  double edge_rms_px = 0.0;             ///< of the rows' edge positions about the polynomial
  double clipped_share = 0.0;           ///< of the region's pixels
  std::vector<double> frequency_cy_px;  ///< along the normal, 0 to about 1
  std::vector<double> sfr;
  std::vector<double> esf;  ///< image's unit, 4 bins a pixel along rows
  /// First frequency of that contrast, interpolated linearly; absent when the curve stays above.
  std::optional<double> mtf50, mtf10;
  std::optional<double> nyquist;              ///< at 0.5 cycles per pixel
  std::optional<double> sampling_efficiency;  ///< mtf10 / 0.495 cycles per pixel, at most 1
};

/// Measures the edge in `roi` of a linear image. Nothing may be NaN in the region. Data never throw: what cannot be
/// measured is an outcome. Throws UsageError for a region that is empty or outside the image and for an order outside
/// 1 to 5. Takes time in proportion to the pixels and to the square of the region's width.
Iso12233Result measure_iso12233(mtf::ImageView<const float> image, const Roi& roi, const Iso12233Options& options = {});

}  // namespace calib
