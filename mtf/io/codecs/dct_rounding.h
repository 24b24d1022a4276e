// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the rounding of JPEG does to pixels (ITU-T T.81, A.3.3 and A.3.4).
//
// A plane is coded in blocks of 8 x 8 pixels. Their orthonormal cosine transforms are rounded to whole multiples of the
// steps q(u, v) of a table in the file. Rounding errors that are spread evenly over a step have a variance of q^2 / 12,
// and as the transform is orthonormal, those of a pixel have
//   sd = sqrt(sum of q(u, v)^2 / 12 / 64)
// in counts. That is an upper limit where a coefficient is smaller than half of its step: then it is set to zero, and
// the error is the coefficient itself, which removes noise and fine structure alike. Errors are not independent: those
// of a block belong together.

#include <cstdint>
#include <vector>

namespace mtf::io {

/// This upper limit for the steps of FileInfo::dct_steps; 0 for an empty list.
double dct_rounding_sd(const std::vector<std::uint16_t>& steps);

}  // namespace mtf::io
