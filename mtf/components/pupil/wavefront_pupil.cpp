// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/pupil/wavefront_pupil.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "mtf/components/pupil/pupil.h"
#include "mtf/math/clones.h"
#include "mtf/math/quadrature.h"
#include "mtf/math/special.h"
#include "mtf/math/turns.h"

namespace mtf {
namespace {

using Cplx = std::complex<double>;
using Row = std::array<double, PupilPolynomial::kMaxDegree + 1>;

Complex<double> plain(const Cplx& z) { return {z.real(), z.imag()}; }

// re[k] + i im[k] = weight[k] (exp(2 pi i D(w[k])) - 1), D(w) = sum of coefficient[j] w^j, j = 0 .. degree, in cycles,
// |D| < 2^50. Relative error of a few 2^-53 of the turn, |exp - 1|, so that a small D loses no digits.
MTFKIT_CLONES void weighted_turns(const double* coefficient, int degree, const double* w, const double* weight,
                                  std::size_t n, double* __restrict re, double* __restrict im) {
  for (std::size_t k = 0; k < n; ++k) re[k] = coefficient[degree];
  for (int j = degree - 1; j >= 0; --j)
    for (std::size_t k = 0; k < n; ++k) re[k] = re[k] * w[k] + coefficient[j];
  constexpr double kRound = 0x1.8p+52;  // adding and subtracting it rounds to whole cycles
  for (std::size_t k = 0; k < n; ++k) {
    // With a = pi r, exp(2 i a) - 1 = 2 i sin a exp(i a); sin a and cos a come from the sine and cosine of a / 2.
    const double r = re[k] - ((re[k] + kRound) - kRound);
    const auto [s, c] = sin_cos_reduced(0.25 * r);
    const double sine = 2.0 * s * c, cosine = 1.0 - 2.0 * s * s;
    re[k] = -2.0 * weight[k] * sine * sine;
    im[k] = 2.0 * weight[k] * sine * cosine;
  }
}

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

// exp(2 pi i cycles) - 1 without cancellation.
Cplx turn_less_one(double cycles) {
  const double half = kPi * (cycles - std::nearbyint(cycles)), s = std::sin(half), c = std::cos(half);
  return {-2.0 * s * s, 2.0 * s * c};
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
  const auto chebyshev = [points](int k) { return std::cos(kPi * k / (points - 1)); };
  double along = 0.0, across = 0.0;
  for (int k = 0; k < points; ++k) {
    const double t = 0.5 * cap.angle * (1.0 + chebyshev(k)), c = std::cos(t), s = std::sin(t);
    const double u = cap.centre + cap.side * cap.radius * c, half_chord = cap.radius * s;
    const Row d = on_chord(phase.d, u, half_chord), d_u = on_chord(phase.d_u, u, half_chord);
    for (int l = 0; l < points; ++l) {
      const double w = chebyshev(l), d_w = slope(d, degree, w);
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
  std::vector<Cplx> by{};
};

void add_cap(const Phase& phase, const PupilCap& cap, const Nodes& nodes, bool arcs, Sums& sums) {
  const int degree = phase.d.degree;
  std::array<Cplx, PupilPolynomial::kMaxDegree + 1> moment{};
  std::size_t moments = 0;
  for (const PupilPolynomial& p : phase.by) moments = std::max(moments, static_cast<std::size_t>(p.degree) + 1);
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
    moment.fill({});
    for (std::size_t k = 0; k < used && !phase.by.empty(); ++k) {
      Cplx power = fold * Cplx(re[k] + nodes.across.weight[k], im[k]);
      for (std::size_t j = 0; j < moments; ++j, power *= nodes.across.node[k]) moment[j] += power;
    }
    if (even)
      for (std::size_t j = 1; j < moment.size(); j += 2) moment[j] = {};
    sums.area += area_weight * chord;
    for (std::size_t q = 0; q < phase.by.size(); ++q) {
      const Row row = on_chord(phase.by[q], u, half_chord);
      Cplx sum{};
      for (std::size_t j = 0; j <= static_cast<std::size_t>(phase.by[q].degree); ++j) sum += row[j] * moment[j];
      sums.by[q] += area_weight * Cplx(-2.0 * kPi * sum.imag(), 2.0 * kPi * sum.real());
    }
    if (!arcs) continue;
    const Cplx ends = turn_less_one(evaluate(d, degree, 1.0)) + turn_less_one(evaluate(d, degree, -1.0));
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
  sums.by.resize(phase.by.size());
  for (const PupilCap& cap : pupil_caps(h, e))
    add_cap(phase, cap, choose_nodes(phase, cap, accuracy * (1.0 - e * e)), gradient.geometry, sums);

  const PupilMtf focused = annular_pupil_mtf(h, e);
  const double ring = (1.0 - e) * (1.0 + e), scale = 1.0 / (kPi * ring);
  result.value = plain(focused.value + scale * sums.area);
  for (std::size_t i = 0; i < gradient.terms.size(); ++i) result.d_term[i] = plain(scale * sums.by[i]);
  if (!gradient.geometry) return result;
  const Cplx d_h = focused.d_nu + scale * (2.0 * sums.receding + sums.by[gradient.terms.size()]);
  const Cplx d_turn = scale * sums.by[gradient.terms.size() + 1];
  Cplx d_x = cosine * d_h - sine * d_turn, d_y = sine * d_h + cosine * d_turn;
  if (h == 0.0) d_x.real(0.0), d_y.real(0.0);
  result.d_nu_x = plain(d_x);
  result.d_nu_y = plain(d_y);
  result.d_obscuration = plain(focused.d_obscuration + scale * (sums.hole + 2.0 * kPi * e * scale * sums.area));
  return result;
}

}  // namespace mtf
