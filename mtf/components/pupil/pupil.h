// SPDX-License-Identifier: Apache-2.0
#pragma once

// Autocorrelation of clear and annular pupils: the incoherent diffraction MTF as a function of nu = f/f_cutoff.
//   circular:  M(nu) = (2/pi) [acos nu - nu sqrt(1 - nu^2)]
//   annular:   M(nu, e) = [A(1,1) - 2 A(1,e) + A(e,e)] / (pi (1 - e^2)),
//              A(R, r) = overlap area of circles of radius R, r with centres 2 nu apart
// (Goodman, Introduction to Fourier Optics, ch. 6; O'Neill, J. Opt. Soc. Am. 46, 285 (1956).)
//
// The overlap of two annular pupils as a sum of caps. Centres at x = -nu and x = nu, radii 1 and e; by inclusion and
// exclusion the overlap of the annuli is lens(1,1) - lens(1,e) - lens(e,1) + lens(e,e), where lens(a, b) is common to
// the disc of radius a about (-nu, 0) and that of radius b about (nu, 0). The chord through the points where the
// circles cross divides a lens into two caps:
//   x = centre + side radius cos t, |y| <= radius sin t, 0 <= t <= angle; a disc inside the other is one cap, angle pi.
// On a cap every function that is analytic in x and y is analytic in t, so Gauss-Legendre converges geometrically.

#include <array>

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

/// A leg from the factors of its square, each formed without cancellation; 0 where rounding makes the product negative.
/// acos loses its relative accuracy near 1, asin(x/r) its absolute one: atan2 of legs keeps both.
double root_of_product(double a, double b);

struct PupilCap {
  double sign = 1.0;    ///< of its lens
  double centre = 0.0;  ///< of its circle, on the x axis
  double side = 1.0;    ///< +1: the cap lies to the right of the chord, -1: to the left
  double radius = 0.0;
  double angle = 0.0;  ///< half angle of its arc, 0 to pi
  bool hole = false;   ///< the arc belongs to a hole, and moves with the obscuration
};

/// At most eight caps.
struct PupilCaps {
  std::array<PupilCap, 8> cap;
  int count = 0;
  const PupilCap* begin() const { return cap.data(); }
  const PupilCap* end() const { return cap.data() + count; }
};

/// 0 <= nu < 1, obscuration in [0, 1).
PupilCaps pupil_caps(double nu, double obscuration);

}  // namespace mtf
