// SPDX-License-Identifier: Apache-2.0
#pragma once

// Spectra of fixed patterns, as EMVA 1288 (release 4, section 8) shows them: the periodograms of all rows, or of all
// columns, averaged,
//   P_k = mean over the rows of |sum over x of p(x) exp(-2 pi i k x / n)|^2 / n,   k/n cycles per pixel
// A white pattern has its variance at every frequency; the mean of each row, at k = 0, is left out.

#include <vector>

#include "mtf/image.h"

namespace calib {

enum class LineAxis { rows, columns };

/// P_1 to P_(n/2).
std::vector<double> line_spectrum(mtf::ImageView<const float> plane, LineAxis axis);

}  // namespace calib
