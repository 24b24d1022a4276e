// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/pupil/pupil_polynomial.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

namespace mtf {
namespace {

constexpr int kMax = PupilPolynomial::kMaxDegree;

double& at(PupilPolynomial& p, int i, int j) { return p.a[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]; }
double at(const PupilPolynomial& p, int i, int j) {
  return p.a[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
}

// f(i, j) for every term of the polynomial.
template <class F>
void each_term(int degree, const F& f) {
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; i + j <= degree; ++j) f(i, j);
}

double binomial(int n, int k) {
  double value = 1.0;
  for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
  return value;
}

PupilPolynomial product(const PupilPolynomial& p, const PupilPolynomial& q) {
  PupilPolynomial result{p.degree + q.degree, {}};
  each_term(p.degree, [&](int i, int j) {
    if (at(p, i, j) != 0.0)
      each_term(q.degree, [&](int k, int l) { at(result, i + k, j + l) += at(p, i, j) * at(q, k, l); });
  });
  return result;
}

PupilPolynomial monomial(int i, int j) {
  PupilPolynomial p{i + j, {}};
  at(p, i, j) = 1.0;
  return p;
}

// Radial order n, azimuthal order m >= 0: R_n^m(rho) cos(m t) or sin(m t), 1 at the edge where the cosine is.
PupilPolynomial zernike(int n, int m, bool sine) {
  PupilPolynomial angular{m, {}};  // the real or imaginary part of (x + i y)^m
  for (int k = sine ? 1 : 0; k <= m; k += 2) at(angular, m - k, k) = (k / 2 % 2 == 0 ? 1.0 : -1.0) * binomial(m, k);
  PupilPolynomial square{2, {}}, power = monomial(0, 0), radial{n - m, {}};
  at(square, 2, 0) = at(square, 0, 2) = 1.0;
  for (int k = (n - m) / 2; k >= 0; --k) {  // coefficient of rho^(n - 2k), lowest power first
    const double c = (k % 2 == 0 ? 1.0 : -1.0) * binomial(n - k, k) * binomial(n - 2 * k, (n - m) / 2 - k);
    radial.add(power, c);
    if (k > 0) power = product(power, square);
  }
  return product(radial, angular);
}

PupilPolynomial make_zernike(ZernikeNumbering numbering, int number) {
  if (numbering == ZernikeNumbering::fringe) {
    if (number == 37) return zernike(12, 0, false);
    // Groups of equal (n + m)/2 = g hold 2g + 1 terms: m = g .. 1 as cosine and sine, then m = 0.
    int g = 0;
    while ((g + 1) * (g + 1) < number) ++g;
    const int place = number - 1 - g * g, m = g - place / 2;
    return zernike(2 * g - m, m, place % 2 == 1);
  }
  int n = 0;
  while ((n + 1) * (n + 2) / 2 < number) ++n;
  const int place = number - 1 - n * (n + 1) / 2, m = n % 2 == 0 ? (place + 1) / 2 * 2 : place / 2 * 2 + 1;
  PupilPolynomial p{};
  p.add(zernike(n, m, m > 0 && number % 2 == 1), std::sqrt((m == 0 ? 1.0 : 2.0) * (n + 1.0)));
  return p;
}

std::vector<PupilPolynomial> make_all(ZernikeNumbering numbering) {
  std::vector<PupilPolynomial> all;
  for (int number = 1; number <= zernike_count(numbering); ++number) all.push_back(make_zernike(numbering, number));
  return all;
}

// Taylor shift by +-h: the terms of odd (over 2h) or even order.
PupilPolynomial shifted(const PupilPolynomial& p, double h, bool odd) {
  PupilPolynomial result{odd ? std::max(p.degree - 1, 0) : p.degree, {}};
  each_term(p.degree, [&](int i, int j) {
    if (at(p, i, j) == 0.0) return;
    double power = 1.0;
    for (int order = odd ? 1 : 0; order <= i; order += 2, power *= h * h)
      at(result, i - order, j) += at(p, i, j) * binomial(i, order) * power;
  });
  return result;
}

}  // namespace

void PupilPolynomial::add(const PupilPolynomial& other, double factor) {
  if (factor == 0.0) return;
  degree = std::max(degree, other.degree);
  each_term(other.degree, [&](int i, int j) { at(*this, i, j) += factor * at(other, i, j); });
}

double PupilPolynomial::operator()(double x, double y) const {
  double sum = 0.0;
  for (int i = degree; i >= 0; --i) {
    double row = 0.0;
    for (int j = degree - i; j >= 0; --j) row = row * y + at(*this, i, j);
    sum = sum * x + row;
  }
  return sum;
}

int zernike_count(ZernikeNumbering numbering) {
  return numbering == ZernikeNumbering::fringe ? 37 : (kMax + 1) * (kMax + 2) / 2;
}

const PupilPolynomial& zernike_polynomial(ZernikeNumbering numbering, int number) {
  assert(number >= 1 && number <= zernike_count(numbering));
  static const std::array all{make_all(ZernikeNumbering::fringe), make_all(ZernikeNumbering::noll)};
  return all[static_cast<std::size_t>(numbering)][static_cast<std::size_t>(number - 1)];
}

PupilPolynomial seidel_polynomial(SeidelTerm term) {
  PupilPolynomial square{2, {}};
  at(square, 2, 0) = at(square, 0, 2) = 1.0;
  if (term == SeidelTerm::w020) return square;
  if (term == SeidelTerm::w040) return product(square, square);
  if (term == SeidelTerm::w131) return product(square, monomial(1, 0));
  return monomial(term == SeidelTerm::w222 ? 2 : 1, 0);
}

PupilPolynomial rotated(const PupilPolynomial& p, double cosine, double sine) {
  // Powers of x = cosine u - sine v and of y = sine u + cosine v; index: power of u, the rest is v.
  using Power = std::array<double, kMax + 1>;
  std::array<Power, kMax + 1> x{}, y{};
  x[0][0] = y[0][0] = 1.0;
  for (std::size_t n = 1; n <= static_cast<std::size_t>(p.degree); ++n)
    for (std::size_t k = 0; k <= n; ++k) {
      const double x_up = k > 0 ? x[n - 1][k - 1] : 0.0, x_same = k < n ? x[n - 1][k] : 0.0;
      const double y_up = k > 0 ? y[n - 1][k - 1] : 0.0, y_same = k < n ? y[n - 1][k] : 0.0;
      x[n][k] = cosine * x_up - sine * x_same;
      y[n][k] = sine * y_up + cosine * y_same;
    }
  PupilPolynomial result{p.degree, {}};
  each_term(p.degree, [&](int i, int j) {
    const double c = at(p, i, j);
    if (c == 0.0) return;
    for (int k = 0; k <= i; ++k)
      for (int l = 0; l <= j; ++l)
        at(result, k + l, i + j - k - l) += c * x[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] *
                                            y[static_cast<std::size_t>(j)][static_cast<std::size_t>(l)];
  });
  return result;
}

PupilPolynomial difference_quotient(const PupilPolynomial& p, double h) { return shifted(p, h, true); }
PupilPolynomial shifted_mean(const PupilPolynomial& p, double h) { return shifted(p, h, false); }

PupilPolynomial x_derivative(const PupilPolynomial& p) { return shifted(p, 0.0, true); }

PupilPolynomial turn_derivative(const PupilPolynomial& p) {
  PupilPolynomial result{p.degree, {}};
  each_term(p.degree, [&](int i, int j) {
    if (j > 0) at(result, i + 1, j - 1) += j * at(p, i, j);
    if (i > 0) at(result, i - 1, j + 1) -= i * at(p, i, j);
  });
  return result;
}

double steepest_slope(const PupilPolynomial& p) {
  // Chebyshev points along rho and even ones around: between them a polynomial of this degree rises by less than a
  // fifth of what it reaches on them (Ehlich and Zeller, Math. Z. 86, 41 (1964)).
  const int rings = 2 * p.degree, spokes = 8 * p.degree;
  const PupilPolynomial dx = x_derivative(p), dy = rotated(x_derivative(rotated(p, 0.0, 1.0)), 0.0, -1.0);
  double steepest = 0.0;
  for (int ring = 0; ring < rings; ++ring)
    for (int spoke = 0; spoke < spokes; ++spoke) {
      const double r = std::cos(0.5 * std::numbers::pi * ring / rings), t = 2.0 * std::numbers::pi * spoke / spokes;
      const double x = r * std::cos(t), y = r * std::sin(t);
      steepest = std::max(steepest, std::hypot(dx(x, y), dy(x, y)));
    }
  return 1.2 * steepest;
}

WavefrontSymmetry symmetry(const PupilPolynomial& p) {
  WavefrontSymmetry s;
  each_term(p.degree, [&](int i, int j) {
    const double c = at(p, i, j);
    // A polynomial in rho^2 has binomial coefficients; products of rounded ones differ in their last digits.
    const double radial = i % 2 + j % 2 == 0 ? at(p, i + j, 0) * binomial((i + j) / 2, j / 2) : 0.0;
    s.radial = s.radial && std::abs(c - radial) <= 1e-14 * std::abs(radial);
    if (c == 0.0) return;
    s.mirror_x = s.mirror_x && i % 2 == 0;
    s.mirror_y = s.mirror_y && j % 2 == 0;
    s.point = s.point && (i + j) % 2 == 0;
  });
  return s;
}

}  // namespace mtf
