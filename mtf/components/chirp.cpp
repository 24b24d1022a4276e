// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/chirp.h"

#include "mtf/math/fresnel.h"
#include "mtf/math/quadrature.h"

namespace mtf {
namespace {

constexpr double kQuadratureUpTo = 4.0;  // in d and in b: at most 19 radians over half the range

Complex<double> times(double a, const Complex<double>& z) { return {a * z.re, a * z.im}; }
Complex<double> times_i(double a, const Complex<double>& z) { return {-a * z.im, a * z.re}; }

// The moments <cos(2 pi d s) exp(..)>, s and s^2 times as much, by Gauss-Legendre over s = 0 ... 1/2.
ChirpMean by_quadrature(double d, double b) {
  static const GaussRule rule = mean_rule(0.0, 0.5, 24);
  ChirpMean h{};
  for (std::size_t i = 0; i < rule.weight.size(); ++i) {
    const double s = rule.node[i], w = rule.weight[i], x = 2.0 * kPi * d * s, y = 2.0 * kPi * b * s * s;
    const double c = std::cos(x), e = std::cos(y), f = std::sin(y), by_d = -2.0 * kPi * s * std::sin(x),
                 by_b = -2.0 * kPi * s * s * c;
    h.value = h.value + Complex<double>{w * c * e, -w * c * f};
    h.by_d = h.by_d + Complex<double>{w * by_d * e, -w * by_d * f};
    h.by_b = h.by_b + Complex<double>{w * by_b * f, w * by_b * e};
  }
  return h;
}

// What one end of the range adds, apart from its phase: t(q, b) = (i f(u) - g(u))/(2 sqrt b), q = the frequency there
// |d +- b|, u = q/sqrt b, f and g the auxiliary Fresnel functions.
struct End {
  Complex<double> value, by_q, by_b;
};

End end_of(double q, double b) {
  if (q * q >= kFresnelTailFrom * kFresnelTailFrom * b) {  // (i F(y) - G(y))/(2 pi q), y = 2b/(pi q^2): also for b = 0
    const double dy = 2.0 / q / (kPi * q), scale = 1.0 / (2.0 * kPi * q);
    const FresnelTail tail = fresnel_tail(dy * b);
    const Complex<double> t{-scale * tail.g.value, scale * tail.f.value};
    const Complex<double> by_y{-scale * tail.g.slope, scale * tail.f.slope};
    return {t, times(-1.0 / q, t + times(2.0 * dy * b, by_y)), times(dy, by_y)};
  }
  const double root = std::sqrt(b), u = q / root, phase = 0.5 * kPi * u * u, scale = 0.5 / root;
  const FresnelIntegrals integrals = fresnel(u);
  const double c = 0.5 - integrals.c.value, s = 0.5 - integrals.s.value, cosine = std::cos(phase),
               sine = std::sin(phase);
  const Complex<double> a{-(c * cosine + s * sine), s * cosine - c * sine};  // i f - g
  const Complex<double> by_u = Complex<double>{1.0, 0.0} + times_i(kPi * u, a);
  const Complex<double> t = times(scale, a), slope = times(scale, by_u);
  return {t, times(1.0 / root, slope), times(-0.5 / b, t + times(u, slope))};
}

// d >= 0, b >= 0, one of them large. Inside the range the phase stands still at s = -d/(2b) when d < b.
ChirpMean by_ends(double d, double b) {
  const Complex<double> turn{cos_pi(d), -sin_pi(d)}, back{turn.re, -turn.im}, common{cos_pi(0.5 * b), -sin_pi(0.5 * b)};
  const bool inside = d < b;
  const double side = inside ? 1.0 : -1.0;
  const End far = end_of(d + b, b), near = end_of(std::abs(d - b), b);
  const Complex<double> near_by_d = times(-side, near.by_q), near_by_b = times(side, near.by_q) + near.by_b;

  const Complex<double> sum = far.value * turn + times(side, near.value) * back;
  const Complex<double> by_d =
      (far.by_q + times_i(-kPi, far.value)) * turn + times(side, near_by_d + times_i(kPi, near.value)) * back;
  const Complex<double> by_b = (far.by_q + far.by_b) * turn + times(side, near_by_b) * back;
  ChirpMean h{common * sum, common * by_d, common * (by_b + times_i(-0.5 * kPi, sum))};
  if (!inside) return h;

  // (1 - i)/(2 sqrt b) exp(i pi d^2/(2b)), the phase in two parts as long as its square does not overflow.
  double square = d * (d / b), rest = 0.0;
  if (b < 1e150) {
    const double dd = d * d, low = std::fma(d, d, -dd);
    square = dd / b;
    rest = (low - std::fma(square, b, -dd)) / b;
  }
  const Complex<double> still = times(0.5 / std::sqrt(b), Complex<double>{1.0, -1.0}) *
                                Complex<double>{cos_pi(0.5 * square), sin_pi(0.5 * square)} *
                                Complex<double>{cos_pi(0.5 * rest), sin_pi(0.5 * rest)};
  h.value = h.value + still;
  h.by_d = h.by_d + times_i(kPi * (d / b), still);
  h.by_b = h.by_b + times(-0.5 / b, still) + times_i(-0.5 * kPi * (d / b) * (d / b), still);
  return h;
}

}  // namespace

ChirpMean chirp_mean(double d, double b) {
  const double p = std::abs(d), q = std::abs(b);
  if (!(p < 1e300 && q < 1e300)) return {};
  ChirpMean h = p <= kQuadratureUpTo && q <= kQuadratureUpTo ? by_quadrature(p, q) : by_ends(p, q);
  if (b == 0.0) {
    const ValueSlope s = sinc(p);
    h.value = {s.value, 0.0};
    h.by_d = {s.slope, 0.0};
    h.by_b.re = 0.0;
  }
  if (d < 0.0) h.by_d = times(-1.0, h.by_d);  // even in d, conjugate under b -> -b
  if (b < 0.0) return {{h.value.re, -h.value.im}, {h.by_d.re, -h.by_d.im}, {-h.by_b.re, h.by_b.im}};
  return h;
}

}  // namespace mtf
