// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/pupil/wavefront_pupil.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "mtf/components/pupil/pupil.h"
#include "mtf/math/clones.h"
#include "mtf/math/quadrature.h"
#include "mtf/math/special.h"

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

using Cplx = std::complex<double>;
using Row = std::array<double, PupilPolynomial::kMaxDegree + 1>;

Complex<double> plain(const Cplx& z) { return {z.real(), z.imag()}; }

// A polynomial along the chord at x = u: coefficients of powers of w, y = half_chord w.
Row on_chord(const PupilPolynomial& p, double u, double half_chord) {
  Row row{};
  double scale = 1.0;
  for (int j = 0; j <= p.degree; ++j, scale *= half_chord) {
    double sum = 0.0;
    for (int i = p.degree - j; i >= 0; --i)
      sum = sum * u + p.a[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
    row[static_cast<std::size_t>(j)] = sum * scale;
  }
  return row;
}

double evaluate(const Row& row, int degree, double w) {
  double sum = 0.0;
  for (int j = degree; j >= 0; --j) sum = sum * w + row[static_cast<std::size_t>(j)];
  return sum;
}

double slope(const Row& row, int degree, double w) {
  double sum = 0.0;
  for (int j = degree; j >= 1; --j) sum = sum * w + j * row[static_cast<std::size_t>(j)];
  return sum;
}

/// exp(2 pi i cycles) - 1 without cancellation, |cycles| < 2^50: with a = pi r of what is left of whole cycles it is
/// 2 i sin a exp(i a), and sin a and cos a come from the sine and cosine of a / 2.
[[gnu::always_inline]] inline Complex<double> turn_less_one(double cycles) {
  constexpr double kRound = 0x1.8p+52;  // adding and subtracting it rounds to whole cycles
  const double r = cycles - ((cycles + kRound) - kRound);
  const auto [s, c] = sin_cos_reduced(0.25 * r);
  const double sine = 2.0 * s * c, cosine = 1.0 - 2.0 * s * s;
  return {-2.0 * sine * sine, 2.0 * sine * cosine};
}

struct Nodes {
  const GaussRule& along;   // t, the arc
  const GaussRule& across;  // w, the chord
};

/// Polynomials in the frame whose x axis is the direction of nu; h = |nu|.
struct Phase {
  PupilPolynomial d;                // W(p + nu) - W(p - nu), in cycles
  PupilPolynomial d_u;              // its derivative by x, for the number of nodes
  std::vector<PupilPolynomial> by;  // changes of d: terms, then |nu|, then the direction over |nu|
};

// Enough nodes for exp(2 pi i D) and its polynomial factors: the steepest phase among samples of the cap decides, at
// Chebyshev's points, between which a polynomial rises little.
Nodes choose_nodes(const Phase& phase, const PupilCap& cap, double accuracy) {
  // Along a long arc the phase is a trigonometric polynomial of its degree, not an algebraic one.
  const int degree = phase.d.degree, points = (cap.angle > 0.5 * kPi ? 2 : 1) * (degree + 3);
  std::array<double, 2 * (PupilPolynomial::kMaxDegree + 3)> chebyshev;
  for (int k = 0; k < points; ++k) chebyshev[static_cast<std::size_t>(k)] = std::cos(kPi * k / (points - 1));
  double along = 0.0, across = 0.0;
  for (int k = 0; k < points; ++k) {
    const double t = 0.5 * cap.angle * (1.0 + chebyshev[static_cast<std::size_t>(k)]), c = std::cos(t), s = std::sin(t);
    const double u = cap.centre + cap.side * cap.radius * c, half_chord = cap.radius * s;
    const Row d = on_chord(phase.d, u, half_chord), d_u = on_chord(phase.d_u, u, half_chord);
    for (int l = 0; l < points; ++l) {
      const double w = chebyshev[static_cast<std::size_t>(l)], d_w = slope(d, degree, w);
      across = std::max(across, std::abs(d_w));
      // dy/dt = radius cos t w; d_w = dD/dy x half_chord.
      const double d_y = half_chord > 0.0 ? d_w / half_chord : 0.0;
      along = std::max(along,
                       std::abs(d_y * cap.radius * c * w - cap.side * half_chord * evaluate(d_u, phase.d_u.degree, w)));
    }
  }
  const double digits = -std::log10(std::clamp(accuracy, 1e-18, 1e-2));
  // Set by trial: phases of high degree grow faster off the axis than their slope on it tells, and want more.
  const auto count = [&](double radians, double start) {
    const double n = (1.0 + 0.04 * degree) * radians + 3.0 * std::cbrt(radians) + (1.0 + 0.12 * degree) * start;
    return std::clamp(2 * static_cast<int>(std::ceil(0.5 * n)), 4, kMostGaussNodes);
  };
  return {gauss_legendre(count(kPi * cap.angle * along, 1.1 * digits + 3.0 * cap.angle)),
          gauss_legendre(count(2.0 * kPi * across, 0.9 * digits))};
}

struct Sums {
  Cplx area{};              // of exp(2 pi i D) - 1
  Cplx receding{}, hole{};  // arcs: moving along x with half of the distance, and growing holes
  int degree = -1;          // of the moments: that of what is differentiated, or none
  std::array<std::array<Cplx, kMax + 1>, kMax + 1> moment{};  // of exp(2 pi i D) x^i y^j

  // Of exp(2 pi i D) where D changes by p.
  Cplx change(const PupilPolynomial& p) const {
    Cplx sum{};
    each_term(p.degree, [&](int i, int j) {
      sum += at(p, i, j) * moment[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
    });
    return {-2.0 * kPi * sum.imag(), 2.0 * kPi * sum.real()};
  }
};

/// sum[j] of value[k] w[k]^j for j < count; the values are used up.
MTFKIT_CLONES void power_sums(const double* w, std::size_t n, std::size_t count, double* __restrict value,
                              double* __restrict sum) {
  constexpr std::size_t kLanes = 8;
  for (std::size_t j = 0; j < count; ++j) {
    std::array<double, kLanes> lane{};
    std::size_t k = 0;
    for (; k + kLanes <= n; k += kLanes)
      for (std::size_t l = 0; l < kLanes; ++l) lane[l] += value[k + l], value[k + l] *= w[k + l];
    double rest = 0.0;
    for (; k < n; ++k) rest += value[k], value[k] *= w[k];
    for (const double one : lane) rest += one;
    sum[j] = rest;
  }
}

void add_cap(const Phase& phase, const PupilCap& cap, const Nodes& nodes, bool arcs, Sums& sums) {
  const int degree = phase.d.degree;
  const auto moments = static_cast<std::size_t>(sums.degree + 1);
  std::vector<double> re(nodes.across.node.size()), im(re.size());
  for (std::size_t i = 0; i < nodes.along.node.size(); ++i) {
    const double t = 0.5 * cap.angle * (1.0 + nodes.along.node[i]), c = std::cos(t), s = std::sin(t);
    const double u = cap.centre + cap.side * cap.radius * c, half_chord = cap.radius * s;
    const double weight = cap.sign * 0.5 * cap.angle * nodes.along.weight[i];
    const double area_weight = weight * half_chord * half_chord;  // dx dy = (radius sin t)^2 dt dw
    const Row d = on_chord(phase.d, u, half_chord);
    bool even = true;
    for (std::size_t j = 1; j <= static_cast<std::size_t>(degree); j += 2) even = even && d[j] == 0.0;
    const std::size_t n = nodes.across.node.size(), used = even ? n / 2 : n;  // the number is even
    const double fold = even ? 2.0 : 1.0;
    weighted_turns(d.data(), degree, nodes.across.node.data(), nodes.across.weight.data(), used, re.data(), im.data());
    Cplx chord{};
    for (std::size_t k = 0; k < used; ++k) chord += Cplx(re[k], im[k]);
    chord *= fold;
    sums.area += area_weight * chord;
    if (moments > 0) {
      for (std::size_t k = 0; k < used; ++k) re[k] += nodes.across.weight[k];
      std::array<double, kMax + 1> real, imaginary;
      power_sums(nodes.across.node.data(), used, moments, re.data(), real.data());
      power_sums(nodes.across.node.data(), used, moments, im.data(), imaginary.data());
      double y_power = fold * area_weight;
      for (std::size_t j = 0; j < moments; ++j, y_power *= half_chord) {
        if (even && j % 2 == 1) continue;
        Cplx power = y_power * Cplx(real[j], imaginary[j]);
        for (std::size_t k = 0; k + j < moments; ++k, power *= u) sums.moment[k][j] += power;
      }
    }
    if (!arcs) continue;
    const Complex<double> up = turn_less_one(evaluate(d, degree, 1.0)), down = turn_less_one(evaluate(d, degree, -1.0));
    const Cplx ends(up.re + down.re, up.im + down.im);
    sums.receding -= 0.5 * weight * cap.radius * c * ends;
    if (cap.hole) sums.hole += weight * cap.radius * ends;
  }
}

// The same OTF at a frequency in the quarter or on the half axis that the wavefront's symmetry leaves, so that mirrored
// frequencies give the same bits. Derivatives see no symmetry: a coefficient may leave it.
struct Folded {
  Freq<double> nu;
  bool conjugate = false;
};
Folded fold(const WavefrontSymmetry& own, const Freq<double>& nu) {
  if (own.radial) return {{std::hypot(nu.x, nu.y), 0.0}};
  Folded f{nu};
  if (nu.x < 0.0 || (nu.x == 0.0 && nu.y < 0.0)) f = {{-nu.x, -nu.y}, true};
  if (!(f.nu.y < 0.0)) return f;
  if (own.mirror_y || (own.point && own.mirror_x)) return {{f.nu.x, -f.nu.y}, f.conjugate};
  if (own.mirror_x) return {{f.nu.x, -f.nu.y}, !f.conjugate};
  return f;
}

}  // namespace

MTFKIT_CLONES void weighted_turns(const double* coefficient, int degree, const double* w, const double* weight,
                                  std::size_t n, double* __restrict re, double* __restrict im) {
  for (std::size_t k = 0; k < n; ++k) re[k] = coefficient[degree];
  for (int j = degree - 1; j >= 0; --j)
    for (std::size_t k = 0; k < n; ++k) re[k] = re[k] * w[k] + coefficient[j];
  for (std::size_t k = 0; k < n; ++k) {
    const Complex<double> turn = turn_less_one(re[k]);
    re[k] = weight[k] * turn.re;
    im[k] = weight[k] * turn.im;
  }
}

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

Complex<double> wavefront_pupil_otf(const PupilPolynomial& wavefront, const Freq<double>& nu, double obscuration,
                                    double accuracy) {
  const WavefrontSymmetry own = symmetry(wavefront);
  const Folded f = fold(own, nu);
  const Complex<double> h = wavefront_pupil_gradient(wavefront, f.nu, obscuration, {}, accuracy).value;
  return {h.re, own.point ? 0.0 : f.conjugate ? -h.im : h.im};
}

WavefrontOtf wavefront_pupil_gradient(const PupilPolynomial& wavefront, const Freq<double>& nu, double obscuration,
                                      const WavefrontGradient& gradient, double accuracy) {
  WavefrontOtf result;
  result.d_term.resize(gradient.terms.size());
  const double h = std::hypot(nu.x, nu.y), e = std::min(obscuration, 1.0 - 0x1p-53);
  if (!(h < 1.0)) return result;
  const double cosine = h > 0.0 ? nu.x / h : 1.0, sine = h > 0.0 ? nu.y / h : 0.0;
  const PupilPolynomial turned = rotated(wavefront, cosine, sine);
  Phase phase;
  phase.d.add(difference_quotient(turned, h), 2.0 * h);
  phase.d_u = x_derivative(phase.d);
  for (const PupilPolynomial& term : gradient.terms) {
    phase.by.emplace_back();
    phase.by.back().add(difference_quotient(rotated(term, cosine, sine), h), 2.0 * h);
  }
  if (gradient.geometry) {
    phase.by.emplace_back();  // 2: W(p + nu) - W(p - nu) changes by both slopes
    phase.by.back().add(shifted_mean(x_derivative(turned), h), 2.0);
    phase.by.emplace_back();
    phase.by.back().add(difference_quotient(turn_derivative(turned), h), 2.0);
  }

  Sums sums;
  for (const PupilPolynomial& p : phase.by) sums.degree = std::max(sums.degree, p.degree);
  for (const PupilCap& cap : pupil_caps(h, e))
    add_cap(phase, cap, choose_nodes(phase, cap, accuracy * (1.0 - e * e)), gradient.geometry, sums);

  const PupilMtf focused = annular_pupil_mtf(h, e);
  const double ring = (1.0 - e) * (1.0 + e), scale = 1.0 / (kPi * ring);
  result.value = plain(focused.value + scale * sums.area);
  for (std::size_t i = 0; i < gradient.terms.size(); ++i) result.d_term[i] = plain(scale * sums.change(phase.by[i]));
  if (!gradient.geometry) return result;
  const Cplx d_h = focused.d_nu + scale * (2.0 * sums.receding + sums.change(phase.by[gradient.terms.size()]));
  const Cplx d_turn = scale * sums.change(phase.by[gradient.terms.size() + 1]);
  Cplx d_x = cosine * d_h - sine * d_turn, d_y = sine * d_h + cosine * d_turn;
  if (h == 0.0) d_x.real(0.0), d_y.real(0.0);
  result.d_nu_x = plain(d_x);
  result.d_nu_y = plain(d_y);
  result.d_obscuration = plain(focused.d_obscuration + scale * (sums.hole + 2.0 * kPi * e * scale * sums.area));
  return result;
}

}  // namespace mtf
