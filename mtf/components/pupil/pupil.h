// SPDX-License-Identifier: Apache-2.0
#pragma once

// Autocorrelation of clear and annular pupils: the incoherent diffraction MTF as a function of nu = f/f_cutoff.
//   circular:  M(nu) = (2/pi) [acos nu - nu sqrt(1 - nu^2)]
//   annular:   M(nu, e) = [A(1,1) - 2 A(1,e) + A(e,e)] / (pi (1 - e^2)),
//              A(R, r) = overlap area of circles of radius R, r with centres 2 nu apart
// (Goodman, Introduction to Fourier Optics, ch. 6; O'Neill, J. Opt. Soc. Am. 46, 285 (1956).)

#include "mtf/component.h"

namespace mtf {

/// M and dM/dnu for nu >= 0; exactly 0 from nu = 1 on.
ValueSlope circular_pupil_mtf(double nu);

struct PupilMtf {
  double value = 0.0;
  double d_nu = 0.0;
  double d_obscuration = 0.0;
};

/// Annular pupil, obscuration (linear ratio) in [0, 1).
PupilMtf annular_pupil_mtf(double nu, double obscuration);

/// The frequencies, rising, at which the OTF of a clear or annular pupil is not smooth, aberrated or not: where the
/// rims of pupil and image begin or cease to cross, and the cutoff.
std::vector<double> pupil_kinks(double obscuration, double cutoff);

}  // namespace mtf
