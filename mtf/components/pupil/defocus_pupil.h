// SPDX-License-Identifier: Apache-2.0
#pragma once

// OTF of a defocused circular or annular pupil, exact at any amount (Hopkins, Proc. R. Soc. A 231, 91 (1955)).
// Pupil radius 1, wavefront W020 rho^2 in waves; the two copies of the pupil are d = 2 nu apart along x, and the phase
// between them depends on x alone:
//   OTF(nu) = 1/(pi (1 - e^2)) * integral over their overlap of cos(k x) dx dy,  k = 8 pi W020 nu.
// Real, even in W020, 1 at nu = 0, 0 from nu = 1 on; negative values (contrast reversal) are kept.

namespace mtf {

/// Value and derivatives; those by nu and by the obscuration at nu = 0 and at an obscuration of 0 are one-sided.
struct DefocusOtf {
  double value = 0.0;
  double d_nu = 0.0;
  double d_obscuration = 0.0;
  double d_w020 = 0.0;
};

/// nu >= 0, obscuration in [0, 1), any finite w020_waves. Absolute error below 2e-15 (1 + k 2^-3) / (1 - e^2): the
/// rounding of the phase k x grows with k, areas of a thin annulus are differences. Constant time: 30 to 130
/// evaluations of sine and cosine whatever the defocus.
DefocusOtf defocus_pupil_otf(double nu, double obscuration, double w020_waves);

}  // namespace mtf
