// SPDX-License-Identifier: Apache-2.0
#pragma once

// OTF of an aberrated circular or annular pupil by quadrature of the pupil's overlap, no pixel grid involved.
//   OTF(nu) = 1/(pi (1 - e^2)) * integral over the overlap of exp(2 pi i D),  D(p) = W(p + nu) - W(p - nu),
// the pupil P = exp(2 pi i W) with W in waves, nu = f lambda N as a vector, the pupil's radius being 1
// (Goodman, Introduction to Fourier Optics, ch. 6). The overlap is cut into caps (pupil_circles.h) on which the
// integrand is analytic; Gauss-Legendre takes as many nodes as the steepest phase on the cap asks for.
// A positive tilt along x has the phase exp(4 pi i W311 nu_x): it moves the image by -2 lambda N W311.

#include <span>
#include <vector>

#include "mtf/components/pupil/pupil_polynomial.h"
#include "mtf/frame.h"

namespace mtf {

/// What is to be differentiated besides the value.
struct WavefrontGradient {
  std::span<const PupilPolynomial> terms{};  ///< derivative by the coefficient of each
  bool geometry = false;                     ///< by nu_x, nu_y and the obscuration
};

struct WavefrontOtf {
  Complex<double> value{};
  Complex<double> d_nu_x{}, d_nu_y{}, d_obscuration{};  ///< at nu = 0 the mean of both sides
  std::vector<Complex<double>> d_term{};
};

/// Steepest slope of a wavefront (waves per pupil radius) that the quadrature takes; check() refuses more.
inline constexpr double kSteepestWavefront = 40.0;

/// Absolute error below `accuracy`, 1e-14 at the least, and 1e-15 / (1 - e^2); modulus at most 1 beyond rounding.
/// Exactly 0 from |nu| = 1 on; Hermitian and with the wavefront's own symmetry to the last bit.
Complex<double> wavefront_pupil_otf(const PupilPolynomial& wavefront, const Freq<double>& nu, double obscuration,
                                    double accuracy = 1e-13);

/// The same with derivatives, whose error is relative to 2 pi times the largest change of D that they stand for. The
/// imaginary part of a point-symmetric wavefront is zero within rounding.
WavefrontOtf wavefront_pupil_gradient(const PupilPolynomial& wavefront, const Freq<double>& nu, double obscuration,
                                      const WavefrontGradient& gradient, double accuracy = 1e-13);

}  // namespace mtf
