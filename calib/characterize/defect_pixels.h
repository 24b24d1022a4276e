// SPDX-License-Identifier: Apache-2.0
#pragma once

// Defective pixels of a camera, as [defects] of a sensor file has them (radiometry/stages/noise/fixed_pattern.h).
//   hot    more dark signal than its row and column by x, exponentially distributed over a part f of the pixels:
//          P(x) = exp(-x/m)/m. Those beyond the limit F of a defect (pattern.h) are found. As the exponential forgets
//          where it begins, they exceed F by m on average, and there are f exp(-F/m + s^2/(2 m^2)) of all pixels, with
//          s the scatter of the others, which lifts more pixels over F than it takes below. With the number n of them
//          the relative errors are 1/sqrt(n) of m, and of f sqrt(1 + (F/m - s^2/m^2)^2)/sqrt(n).
//   dead   a response below half of that of the others
// A pixel beyond the limit that is neither answers weakly, or is cold; the chain has none of those. What defects add to
// the mean of a dark frame, and to the noise, is no part of the offset and of the read noise of the others. Crosstalk
// gives the neighbours of a defect a part of its signal, which is taken back from them.

#include "calib/characterize/characterize.h"

namespace calib {

struct DefectSums {
  std::vector<Defect> hot{};  ///< that are not dead
  std::int64_t dead = 0;      ///< also those that stand at a value of their own
  std::int64_t others = 0;    ///< beyond the limit in the dark or in the response, and neither
  double mean = 0.0;          ///< what all these add to the mean of a dark frame, counts
  double variance = 0.0;      ///< and to the temporal variance of a pixel, counts^2
  double scatter = 0.0;       ///< mean over all pixels of the square of the variance that the defective ones have
};

/// `dark`: of the mean dark frame, whose noise that is. `response`: of its difference to one of that much more signal;
/// may be null.
DefectSums defect_sums(const NoiseScales& noise, const PlaneSquares& dark, const PlaneSquares* response, double signal);

/// The share of so many of the pixels, with Poisson limits.
Finding share_finding(const char* name, double count, double pixels, const std::string& from);

/// Whether stacks have exposure times that differ by a hundredth and more.
bool exposures_differ(const std::vector<Stack>& stacks);
inline constexpr std::string_view kHotChanges =
    "the stacks have several exposure times, with which hot pixels change; they are in the offset and the noise, and "
    "in "
    "the list of defects";

/// Takes what crosstalk gave of the signal of defects from their neighbours.
void take_back_leaks(mtf::Image& plane, const std::vector<Defect>& defects, double side, double corner);

/// hot_fraction, and hot_excess in units of `gain`; `sums.hot` are of that plane.
void add_hot_pixels(const DefectSums& sums, const PlaneSquares& dark, const Estimate& gain, const std::string& from,
                    Characterization& camera);
void add_dead_pixels(const DefectSums& sums, double pixels, const std::string& from, Characterization& camera);

}  // namespace calib
