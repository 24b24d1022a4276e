// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/motion_means.h"

#include <algorithm>
#include <vector>

#include "mtf/math/fresnel.h"
#include "mtf/math/quadrature.h"
#include "mtf/math/special.h"

namespace mtf {
namespace {

constexpr double kSeriesUpTo = 50.0, kRmsSeriesUpTo = 2000.0, kRmsBlend = 500.0;
constexpr double kLargest = 1e300;                   // beyond it, and where products overflowed, the values of this x
constexpr double kTurnMean = 16.0, kTurnRms = 64.0;  // radians that Gauss-Legendre takes

using C = Complex<double>;
C times(double a, const C& z) { return {a * z.re, a * z.im}; }
C times_i(double a, const C& z) { return {-a * z.im, a * z.re}; }
C conj(const C& z) { return {z.re, -z.im}; }

/// exp(-i x sin(2 pi t)).
C phase_at(double x, double turns) {
  const double a = x * sin_pi(2.0 * turns);
  return {std::cos(a), -std::sin(a)};
}

/// J_0 ... J_n of x >= 0 up to where they vanish: power series for small x, else Miller's downward recurrence.
std::vector<double> bessel_orders(double x) {
  if (x < 0.5) {
    std::vector<double> j(16);
    double lead = 1.0;
    for (std::size_t n = 0; n < j.size(); ++n) {
      const double q = 0.25 * x * x, m = static_cast<double>(n);
      if (n > 0) lead *= 0.5 * x / m;
      double tail = 1.0;
      for (int k = 8; k >= 1; --k) tail = 1.0 - q / (k * (k + m)) * tail;
      j[n] = lead * tail;
    }
    return j;
  }
  const auto last = static_cast<std::size_t>(x + 12.0 * std::cbrt(x) + 8.0);  // J below 1e-17 from there
  std::vector<double> j(last + 2);
  j[last] = 1e-150;
  double norm = 0.0;
  for (std::size_t n = last; n > 0; --n) {
    j[n - 1] = 2.0 * static_cast<double>(n) / x * j[n] - j[n + 1];
    if (n % 2 == 1) norm += (n == 1 ? 1.0 : 2.0) * j[n - 1];
  }
  for (double& value : j) value /= norm;
  j[0] = bessel_j0(x).value;
  return j;
}

SineMean by_series(double x, double cycles, double turns) {
  const std::vector<double> j = bessel_orders(x);
  SineMean h{};
  h.value.re = j[0];
  h.by_x.re = -j[1];
  for (std::size_t n = 1; n + 1 < j.size(); ++n) {
    const double m = static_cast<double>(n), slope = j[n - 1] - j[n + 1];  // 2 dJ_n/dx
    const ValueSlope s = sinc(m * cycles);
    const double c = cos_pi(2.0 * m * turns), d = sin_pi(2.0 * m * turns), turn = 2.0 * kPi * m;
    if (n % 2 == 0) {
      h.value.re += 2.0 * j[n] * s.value * c;
      h.by_x.re += slope * s.value * c;
      h.by_cycles.re += 2.0 * j[n] * m * s.slope * c;
      h.by_turns.re -= 2.0 * j[n] * s.value * turn * d;
    } else {
      h.value.im -= 2.0 * j[n] * s.value * d;
      h.by_x.im -= slope * s.value * d;
      h.by_cycles.im -= 2.0 * j[n] * m * s.slope * d;
      h.by_turns.im -= 2.0 * j[n] * s.value * turn * c;
    }
  }
  return h;
}

/// The mean over a window short enough for a fixed rule.
SineMean by_quadrature(double x, double cycles, double turns) {
  static const GaussRule rule = mean_rule(-0.5, 0.5, 32);
  SineMean h{};
  for (std::size_t i = 0; i < rule.weight.size(); ++i) {
    const double s = rule.node[i], t = turns + cycles * s, sine = sin_pi(2.0 * t);
    const C e = times(rule.weight[i], phase_at(x, t));
    const C by_t = times_i(-2.0 * kPi * x * cos_pi(2.0 * t), e);
    h.value = h.value + e;
    h.by_x = h.by_x + times_i(-sine, e);
    h.by_cycles = h.by_cycles + times(s, by_t);
    h.by_turns = h.by_turns + by_t;
  }
  return h;
}

// One end of a window next to the extremum number m of the sine, at t = (2m + 1)/4 (a crest for even m). With
// s = |sin(distance/2)|, sin(2 pi t) = +-(1 - 2 s^2): the integral over the angle from the end away from the extremum,
// into the valley, is 2 sum of c_k n_k x phase, where (1 - s^2)^(-1/2) = sum of c_k s^(2k) and n_k are the moments of
// exp(2 i x s^2) over that symbol's Fresnel tail.
struct WindowEnd {
  double m, side;  // side: +1 when t lies behind the extremum, -1 before it
  double crest;    // +1 crest, -1 trough
  C value, by_x;   // the integral into the valley
};

WindowEnd window_end(double x, double t) {
  const double m = std::floor(2.0 * t), away = t - 0.25 * (2.0 * m + 1.0);  // -1/4 ... 1/4
  WindowEnd end{m, away < 0.0 ? -1.0 : 1.0, std::remainder(m, 2.0) == 0.0 ? 1.0 : -1.0, {}, {}};
  const double s = std::abs(sin_pi(away)), u = 2.0 * s * std::sqrt(x / kPi);
  C n, dn;
  if (u >= kFresnelTailFrom) {
    const double y = 0.5 / (s * s * x), scale = 0.25 / (s * x);
    const FresnelTail tail = fresnel_tail(y);
    n = {scale * tail.g.value, scale * tail.f.value};
    dn = times(-1.0 / x, n + C{scale * y * tail.g.slope, scale * y * tail.f.slope});
  } else {
    const FresnelIntegrals f = fresnel(u);
    const double phase = 0.5 * kPi * u * u, scale = 0.5 * std::sqrt(kPi / x);
    const C a = C{0.5 - f.c.value, 0.5 - f.s.value} * C{std::cos(phase), -std::sin(phase)};
    n = times(scale, a);
    dn = times(-0.5 / x, n + times(scale * u, C{1.0, 0.0} + times_i(kPi * u, a)));
  }
  C sum = n, by_x = dn;
  double coefficient = 1.0, power = s;  // s^(2k-1)
  for (int k = 1; k <= 60 && coefficient * (power + n.im * n.im) > 0.0; ++k) {
    dn = times_i(0.25 * (2 * k - 1) / x, dn);
    n = times_i(0.25 / x, C{power, 0.0} + times(2 * k - 1, n));
    dn = dn + times(-1.0 / x, n);
    coefficient *= (2.0 * k - 1.0) / (2.0 * k);
    sum = sum + times(coefficient, n);
    by_x = by_x + times(coefficient, dn);
    power *= s * s;
    if (std::abs(n.re) + std::abs(n.im) < 1e-18 * (std::abs(sum.re) + std::abs(sum.im))) break;
  }
  if (end.crest < 0.0) sum = conj(sum), by_x = conj(by_x);
  const C phase = phase_at(x, t);
  end.value = times(2.0, sum) * phase;
  end.by_x = times(2.0, by_x) * phase + times_i(-sin_pi(2.0 * t), end.value);
  return end;
}

SineMean by_ends(double x, double cycles, double turns) {
  const double whole = std::floor(cycles), rest = cycles - whole;
  const double first = std::remainder(turns - 0.5 * cycles, 1.0);
  const WindowEnd a = window_end(x, first), b = window_end(x, first + rest);
  // Counted so that what both ends share cancels exactly.
  const double halves = 2.0 * whole + (b.m - a.m) + 0.5 * (b.side - a.side),
               crests = b.side * b.crest - a.side * a.crest;
  const double scale = 1.0 / (2.0 * kPi * cycles);
  const C middle{kPi * halves * ::j0(x), crests == 0.0 ? 0.0 : -0.5 * kPi * crests * ::y0(x)},
      middle_by_x{-kPi * halves * ::j1(x), crests == 0.0 ? 0.0 : 0.5 * kPi * crests * ::y1(x)};
  SineMean h{};
  h.value = times(scale, middle + times(-b.side, b.value) + times(a.side, a.value));
  h.by_x = times(scale, middle_by_x + times(-b.side, b.by_x) + times(a.side, a.by_x));
  const C early = phase_at(x, first), late = phase_at(x, first + rest);
  h.by_cycles = times(1.0 / cycles, times(0.5, early + late) + times(-1.0, h.value));
  h.by_turns = times(1.0 / cycles, late + times(-1.0, early));
  return h;
}

SineRms square_root(double square, double by_x, double by_cycles) {
  if (!(square > 0.0)) return {};
  const double root = std::sqrt(std::min(square, 1.0));  // a mean of squares below 1; its sum may round to more
  return {root, 0.5 * by_x / root, 0.5 * by_cycles / root};
}

SineRms rms_by_series(double x, double cycles) {
  const std::vector<double> j = bessel_orders(x);
  double sum = j[0] * j[0], by_x = -2.0 * j[0] * j[1], by_cycles = 0.0;
  for (std::size_t n = 1; n + 1 < j.size(); ++n) {
    const double m = static_cast<double>(n);
    const ValueSlope s = sinc(m * cycles);
    sum += 2.0 * j[n] * j[n] * s.value * s.value;
    by_x += 2.0 * j[n] * (j[n - 1] - j[n + 1]) * s.value * s.value;
    by_cycles += 4.0 * j[n] * j[n] * s.value * m * s.slope;
  }
  return square_root(sum, by_x, by_cycles);
}

SineRms rms_by_quadrature(double x, double cycles) {
  static const GaussRule rule = mean_rule(0.0, 1.0, 80);
  double sum = 0.0, by_x = 0.0, by_cycles = 0.0;
  for (std::size_t i = 0; i < rule.weight.size(); ++i) {
    const double s = rule.node[i], w = 2.0 * (1.0 - s) * rule.weight[i], sine = sin_pi(cycles * s);
    const ValueSlope j = bessel_j0(2.0 * x * sine);
    sum += w * j.value;
    by_x += w * j.slope * 2.0 * sine;
    by_cycles += w * j.slope * 2.0 * x * kPi * s * cos_pi(cycles * s);
  }
  return square_root(sum, by_x, by_cycles);
}

// The lags of whole cycles, where the argument of J0 vanishes, and those of half cycles, where it is stationary.
SineRms rms_leading(double x, double c) {
  const double k = std::ceil(c) - 1.0, m = std::max(0.0, std::ceil(c - 0.5));
  const double zeros = 1.0 + 2.0 * (k - 0.5 * k * (k + 1.0) / c), still = 2.0 * (m - 0.5 * m * m / c);
  const double scale = 1.0 / (kPi * x * c), sine = std::sin(2.0 * x), crest = std::sin(x) + std::cos(x);
  // zeros + sin(2x) still, which vanishes for whole cycles wherever 1 + sin(2x) = (sin x + cos x)^2 does.
  const double square = scale * ((zeros - still) + crest * crest * still);
  const double by_c = scale * (k * (k + 1.0) + sine * m * m) / (c * c) - square / c;
  return square_root(square, -square / x + 2.0 * scale * std::cos(2.0 * x) * still, by_c);
}

// From 0 to 1 with its slope, smooth at both ends.
ValueSlope blend_weight(double t) {
  if (!(t > 0.0)) return {0.0, 0.0};
  if (!(t < 1.0)) return {1.0, 0.0};
  return {t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t)};
}

SineRms blend(const SineRms& p, const SineRms& q, double weight, double by_x, double by_cycles) {
  const double step = q.value - p.value;
  return {p.value + weight * step, p.by_x + weight * (q.by_x - p.by_x) + by_x * step,
          p.by_cycles + weight * (q.by_cycles - p.by_cycles) + by_cycles * step};
}

// The sum, which is |J0| for whole cycles: the root of a rounded sum would lose it next to its zeros.
SineRms rms_exact(double x, double cycles) {
  if (!(cycles > 0.0 && cycles == std::floor(cycles))) return rms_by_series(x, cycles);
  const ValueSlope j = bessel_j0(x);
  return {std::abs(j.value), j.value < 0.0 ? -j.slope : j.slope, 0.0};
}

// The sum, going over into its leading term.
SineRms rms_of_many_turns(double x, double cycles) {
  const ValueSlope w = blend_weight((x - kRmsSeriesUpTo) / kRmsBlend);
  if (w.value == 0.0) return rms_exact(x, cycles);
  if (w.value == 1.0) return rms_leading(x, cycles);
  return blend(rms_exact(x, cycles), rms_leading(x, cycles), w.value, w.slope / kRmsBlend, 0.0);
}

constexpr double kQuadratureUpTo = 4.0;  // in d and in b: at most 19 radians over half the range

// The moments <cos(2 pi d s) exp(..)>, s and s^2 times as much, by Gauss-Legendre over s = 0 ... 1/2.
ChirpMean chirp_by_quadrature(double d, double b) {
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
ChirpMean chirp_by_ends(double d, double b) {
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

SineMean sine_mean(double x, double cycles, double phase_turns) {
  const bool finite = std::abs(x) < kLargest;
  const double a = finite ? std::abs(x) : kLargest, window = 2.0 * kPi * std::min(cycles, 1.0);
  // Half a turn reverses the motion. Without whole and half turns (exact) a short window about a crossing of the middle
  // keeps its digits: added to a phase of one turn, its ends would be rounded to 2^-53.
  const double turns = std::remainder(phase_turns, 0.5);
  const bool reversed = (std::remainder(phase_turns - turns, 1.0) != 0.0) != (x < 0.0);
  const double steepest = std::min(1.0, std::abs(cos_pi(2.0 * turns)) + 0.5 * window);
  SineMean h{};
  if (a <= kSeriesUpTo)
    h = by_series(a, cycles, turns);
  else if (a * window * steepest <= kTurnMean)
    h = by_quadrature(a, cycles, turns);
  else
    h = by_ends(a, cycles, turns);
  if (cycles > 0.0 && cycles == std::floor(cycles)) h.value = {bessel_j0(a).value, 0.0};
  // A mean of phases; the sum of its terms may round to more.
  if (const double modulus = std::hypot(h.value.re, h.value.im); modulus > 1.0) h.value = times(1.0 / modulus, h.value);
  h.by_x = times(!finite ? 0.0 : x < 0.0 ? -1.0 : 1.0, h.by_x);
  return reversed ? SineMean{conj(h.value), conj(h.by_x), conj(h.by_cycles), conj(h.by_turns)} : h;
}

SineRms sine_rms(double x, double cycles) {
  const bool finite = std::abs(x) < kLargest;
  const double a = finite ? std::abs(x) : kLargest;
  SineRms r{};
  const double turn_by_x = 2.0 * sin_pi(cycles), turn = a * turn_by_x;
  if (cycles < 0.5 && turn <= kTurnRms) {
    r = rms_by_quadrature(a, cycles);
    // Where the series is no longer at hand, its leading term is met without a step.
    const ValueSlope w = blend_weight((turn - 0.75 * kTurnRms) / (0.25 * kTurnRms));
    if (w.value > 0.0 && a > kRmsSeriesUpTo) {
      const double slope = w.slope / (0.25 * kTurnRms), turn_by_cycles = 2.0 * kPi * a * cos_pi(cycles);
      r = blend(r, rms_of_many_turns(a, cycles), w.value, slope * turn_by_x, slope * turn_by_cycles);
    }
  } else {
    r = rms_of_many_turns(a, cycles);
  }
  r.by_x *= !finite ? 0.0 : x < 0.0 ? -1.0 : 1.0;
  return r;
}

ChirpMean chirp_mean(double d, double b) {
  const double p = std::abs(d), q = std::abs(b);
  if (!(p < 1e300 && q < 1e300)) return {};
  ChirpMean h = p <= kQuadratureUpTo && q <= kQuadratureUpTo ? chirp_by_quadrature(p, q) : chirp_by_ends(p, q);
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
