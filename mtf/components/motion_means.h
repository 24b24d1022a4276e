// SPDX-License-Identifier: Apache-2.0
#pragma once

// Means of the phase of a motion over the exposure. The OTF of sinusoidal motion seen through a finite exposure, x = 2
// pi f A:
//   h(x, c, p) = mean of exp(-i x sin(2 pi t)) over a window of c cycles centred at t = p
//              = sum over all n of J_n(x) exp(-2 pi i n p) sinc(n c)
//   r(x, c)    = sqrt(mean of |h|^2 over p) = sqrt(sum over all n of J_n(x)^2 sinc(n c)^2)
// h: the sum up to x = 50. Beyond it, Gauss-Legendre while the phase turns by less than 16 radians in the window,
// otherwise exact end contributions: whole half cycles give pi J0(x); what is left runs from each end of the window
// into the complex plane, in Fresnel integrals and a short recurrence. Bounded work for any x; absolute error below
// 1e-14 plus the rounding of the phase, x 2^-53.
// r: Gauss-Legendre on the autocorrelation, mean of J0(2 x sin(pi c s)) weighted with 2 (1 - s), while that turns by
// less than 64 radians. Otherwise the sum up to x = 2000, going over without a step into the leading term of the mean
// in 1/x at x = 2500: absolute error below 2e-4 from 2000 on.
//
// The OTF of uniformly accelerated motion, whose phase grows with distance and its square:
//   h(d, b) = integral over s = -1/2 ... 1/2 of exp(-2 pi i (d s + b s^2)) ds
// h(d, 0) = sinc(d). Absolute error below 1e-15 plus the rounding of the phases pi d and pi b/2.

#include "mtf/frame.h"

namespace mtf {

struct SineMean {
  Complex<double> value, by_x, by_cycles, by_turns;
};

/// Any x, beyond 1e300 the value there; cycles >= 0; the phase in turns, of which whole and half ones are exact. Whole
/// cycles: J0(x).
SineMean sine_mean(double x, double cycles, double phase_turns);

struct SineRms {
  double value = 0.0, by_x = 0.0, by_cycles = 0.0;
};

SineRms sine_rms(double x, double cycles);

struct ChirpMean {
  Complex<double> value, by_d, by_b;
};

/// Any d and b, also infinite or NaN (0 then).
ChirpMean chirp_mean(double d, double b);

}  // namespace mtf
