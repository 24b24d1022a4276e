// SPDX-License-Identifier: Apache-2.0
#pragma once

// Mean of a phase that grows with distance and its square, the OTF of uniformly accelerated motion:
//   h(d, b) = integral over s = -1/2 ... 1/2 of exp(-2 pi i (d s + b s^2)) ds
// h(d, 0) = sinc(d). Absolute error below 1e-15 plus the rounding of the phases pi d and pi b/2.

#include "mtf/frame.h"

namespace mtf {

struct ChirpMean {
  Complex<double> value, by_d, by_b;
};

/// Any d and b, also infinite or NaN (0 then).
ChirpMean chirp_mean(double d, double b);

}  // namespace mtf
