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

#include <array>
#include <string_view>

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

}  // namespace mtf
