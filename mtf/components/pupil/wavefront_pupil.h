// SPDX-License-Identifier: Apache-2.0
#pragma once

// Wavefronts as polynomials over the unit pupil, x right and y down as in the image, rho = 1 at its outer edge whatever
// the obscuration. Values are in waves.
//   Seidel    W020 rho^2, W040 rho^4, W131 rho^2 x, W222 x^2, W311 x
//   Fringe    Zernike circle polynomials of unit peak, 37 terms (University of Arizona order): Z1 = 1, Z2 = x, Z3 = y,
//             Z4 = 2 rho^2 - 1, Z5 = x^2 - y^2, Z7 = (3 rho^2 - 2) x, Z9 = 6 rho^4 - 6 rho^2 + 1
//   Noll      Zernike circle polynomials of unit rms over the full disc, so that the rms of a sum is the root of the
//             sum of squares when there is no obscuration: Z1 = 1, Z2 = 2x, Z3 = 2y, Z4 = sqrt(3) (2 rho^2 - 1), ...
// (Noll, J. Opt. Soc. Am. 66, 207 (1976); Wyant and Creath, Applied Optics and Optical Engineering XI, ch. 1.)
// Their OTF with a circular or annular pupil, by quadrature of the pupil's overlap, no pixel grid involved:
//   OTF(nu) = 1/(pi (1 - e^2)) * integral over the overlap of exp(2 pi i D),  D(p) = W(p + nu) - W(p - nu),
// the pupil P = exp(2 pi i W) with W in waves, nu = f lambda N as a vector, the pupil's radius being 1
// (Goodman, Introduction to Fourier Optics, ch. 6). The overlap is cut into caps (pupil.h) on which the
// integrand is analytic; Gauss-Legendre takes as many nodes as the steepest phase on the cap asks for.
// A positive tilt along x has the phase exp(4 pi i W311 nu_x): it moves the image by -2 lambda N W311.

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "mtf/frame.h"

namespace mtf {

/// sum of a[i][j] x^i y^j, i + j <= degree.
struct PupilPolynomial {
  static constexpr int kMaxDegree = 12;
  using Coefficients = std::array<std::array<double, kMaxDegree + 1>, kMaxDegree + 1>;
  int degree = 0;
  Coefficients a{};

  void add(const PupilPolynomial& other, double factor);
  double operator()(double x, double y) const;
};

enum class ZernikeNumbering { fringe, noll };
inline constexpr std::array<std::string_view, 2> kNumberingNames{"fringe", "noll"};
/// Fringe: 37; Noll: 91, all terms up to the radial order 12.
int zernike_count(ZernikeNumbering numbering);

/// Term number 1 to zernike_count (assert).
const PupilPolynomial& zernike_polynomial(ZernikeNumbering numbering, int number);

enum class SeidelTerm { w020, w040, w131, w222, w311 };
PupilPolynomial seidel_polynomial(SeidelTerm term);

/// The polynomial in coordinates (u, v) turned by the angle of (cosine, sine): x = cosine u - sine v,
/// y = sine u + cosine v.
PupilPolynomial rotated(const PupilPolynomial& p, double cosine, double sine);
/// [p(x + h, y) - p(x - h, y)] / (2h), the derivative by x at h = 0.
PupilPolynomial difference_quotient(const PupilPolynomial& p, double h);
/// [p(x + h, y) + p(x - h, y)] / 2.
PupilPolynomial shifted_mean(const PupilPolynomial& p, double h);
PupilPolynomial x_derivative(const PupilPolynomial& p);
/// x dp/dy - y dp/dx: the change when the coordinates turn.
PupilPolynomial turn_derivative(const PupilPolynomial& p);

/// Bound of |gradient| over the unit disc, at most a fifth above the largest: waves per pupil radius.
double steepest_slope(const PupilPolynomial& p);

/// What a wavefront keeps when x, y or both change sign, or when it turns; piston does not count.
struct WavefrontSymmetry {
  bool mirror_x = true, mirror_y = true, point = true, radial = true;
};
WavefrontSymmetry symmetry(const PupilPolynomial& p);

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

/// re[k] + i im[k] = weight[k] (exp(2 pi i D(w[k])) - 1), D(w) = sum of coefficient[j] w^j, j = 0 .. degree, in cycles,
/// |D| < 2^50. Relative error of a few 2^-53 of the turn, |exp - 1|, so that a small D loses no digits.
void weighted_turns(const double* coefficient, int degree, const double* w, const double* weight, std::size_t n,
                    double* re, double* im);

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
