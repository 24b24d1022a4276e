// SPDX-License-Identifier: Apache-2.0
#pragma once

// Why the response of ISO 12233 differs from the MTF of the same edge (measure.h). Each step of the standard's method
// is applied to the measured MTF in turn, and what it changes is its share of the difference. With f along the normal,
// c = f cos(a) along the region's rows, n its columns and m its rows:
//   bins          the average over a quarter of a column: M sinc(c / 4)
//   window        the raised cosine over the region's width, which convolves the OTF with its transform
//   differences   their response is divided out one sample ahead: (y / sin y) / (x / sin x), x = pi c / 2 and
//                 y = pi (c n + 1) / (2 n + 2)
//   noise         of the pixels adds to the modulus: sqrt(M^2 + P / 2), where the windowed differences of the profile,
//                 whose bins hold m / 4 pixels each, have the noise power P = (3/2) pi^2 c^2 (n / m) / CNR^2
//   samples       figures are taken on straight lines between samples 1 / (n cos(a)) apart
// What is left is the noise of this very edge, whose part along the OTF has the variance P / 2, and the phases of the
// pixels, which do not fill the bins evenly.

#include <optional>
#include <string_view>
#include <vector>

#include "calib/iso12233/iso12233.h"

namespace calib {

/// Something that differs in the two figures that most people compare. Absent where the curve does not fall so far.
struct FigureChange {
  std::optional<double> mtf50_cy_px;
  std::optional<double> nyquist;  ///< of the modulation at 0.5 cycles per pixel
};

struct Iso12233Reason {
  std::string_view reason;
  FigureChange change;
};

struct Iso12233Difference {
  FigureChange total;                   ///< ISO 12233 less the MTF
  std::vector<Iso12233Reason> reasons;  ///< the largest change of MTF50 first; of Nyquist where there is no MTF50
  FigureChange unexplained;             ///< the total less the reasons
  FigureChange scatter;                 ///< standard deviation that the pixels' noise gives the standard's figures
};

/// Both results have to be of the same region and without trouble. Throws UsageError otherwise.
Iso12233Difference explain_difference(const EdgeMeasurement& edge, const Iso12233Result& standard);

}  // namespace calib
