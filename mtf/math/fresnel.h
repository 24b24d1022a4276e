// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fresnel integrals C(u) = integral_0^u cos(pi t^2/2) dt, S(u) with sin, and their remainders for large u:
//   C = 1/2 + f sin(pi u^2/2) - g cos(pi u^2/2),  S = 1/2 - f cos(pi u^2/2) - g sin(pi u^2/2)
// f and g do not oscillate. With y = 2/(pi u^2) they are means over the weight exp(-x^2) on the real line,
//   pi u f = F(y) = <1/(1 + x^4 y^2)>,  pi u g = G(y) = <x^2 y/(1 + x^4 y^2)>   (DLMF 7.7.10, 7.7.11)
// whose trapezoidal sums converge exponentially: all terms positive, so F, G and their slopes keep a relative error of
// a few 2^-53 from u = 1.5 to infinity. Below 1.5 the power series of C and S serve.

#include "mtf/math/special.h"

namespace mtf {

struct FresnelIntegrals {
  ValueSlope c, s;
};

/// Absolute error below 1e-15 for any u; 1/2 at infinity.
FresnelIntegrals fresnel(double u);

/// F(y) and G(y) above with their slopes, 0 <= y <= 2/(pi 1.5^2).
struct FresnelTail {
  ValueSlope f, g;
};
FresnelTail fresnel_tail(double y);
inline constexpr double kFresnelTailFrom = 1.5;  ///< smallest u

}  // namespace mtf
