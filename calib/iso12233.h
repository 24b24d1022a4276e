// SPDX-License-Identifier: Apache-2.0
#pragma once

// The edge-based spatial frequency response as commonly computed after ISO 12233:2023, to compare with other programs.
// Known biases, left in on purpose: the average over quarter-pixel bins is not divided out (up to -2 % in MTF50), the
// result depends on the width of the region, noise is not smoothed. measure.h has none of them.

#include <string>
#include <vector>

#include "calib/measure.h"

namespace calib {

struct Iso12233Options {
  int order = 5;      ///< of the polynomial edge, 1 to 5
  bool tukey = true;  ///< Tukey window (alpha = 1); otherwise Hamming
};

struct Iso12233Result {
  Trouble trouble = Trouble::none;
  std::string reason;
  std::vector<std::string> warnings;
  double angle_deg = 0.0;               ///< of the normal, in (-90, 90]
  std::vector<double> frequency_cy_px;  ///< along the normal
  std::vector<double> sfr;
  std::vector<double> esf;  ///< 4 bins a pixel along rows
  std::optional<double> mtf50, mtf10, nyquist, sampling_efficiency;
};

/// Nothing may be NaN in the region. Errors as measure_edge.
Iso12233Result measure_iso12233(mtf::ImageView<const float> image, const Roi& roi, const Iso12233Options& options = {});

}  // namespace calib
