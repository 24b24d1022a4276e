// SPDX-License-Identifier: Apache-2.0
#pragma once

// Interpolation between the samples of an image.
//   otf = h(fx px) h(fy py),  sinc(x) = sin(pi x)/(pi x)
//   nearest          h(x) = sinc(x)
//   linear           h(x) = sinc(x)^2
//   cubic            h(x) = A + a B,  A = 3 (sinc(x)^2 - sinc(2x))/(pi x)^2,
//                    B = 2 (3 sinc(2x)^2 - 2 sinc(2x) - sinc(4x))/(pi x)^2
//   bspline          h(x) = sinc(x)^4 / (2/3 + cos(2 pi x)/3)
//   six_coefficient  h(x) = 1/2 + sum over j = 1 ... 6 of c_j cos((2j - 1) pi x)
// p = pitch, so that x is in cycles/pixel; beyond x = 1/2 the otf is what is left of the replicas of the spectrum.
// cubic: Keys' kernel of parameter a; a = -1/2 is of third order; below, fine detail is amplified. bspline: the cubic
// spline through the samples. six_coefficient: doubles the samples by a symmetric filter of twelve taps, period 2; its
// coefficients are published to four decimals, so otf(0) = 0.9996 per axis (0.9992 for an image) and up to 1.0008
// within the band; this gain is kept and declared, as that of `fir` is. Real; nothing is shifted. (Keys, IEEE Trans.
// ASSP-29, 1153 (1981); Unser, IEEE Signal Proc. Mag. 16(6), 22 (1999); six coefficients: the zoom of the NVTherm
// family of sensor models.)

#include <utility>

#include "mtf/components/field.h"

namespace mtf {

/// The two parts of Keys' response. Their formulas cancel towards x = 0; there a power series in (pi x)^2.
struct KeysCubic {
  ValueSlope a0;  ///< A(x)
  ValueSlope a1;  ///< B(x)
  explicit KeysCubic(double x) {
    if (std::abs(x) < kSeries) {
      series(x);
      return;
    }
    if (!std::isfinite(x)) return;
    const ValueSlope s1 = sinc(x), s2 = sinc(2.0 * x), s4 = sinc(4.0 * x);
    const double scale = 1.0 / (kPi * x) / (kPi * x);
    const auto divided = [&](double value, double slope) {
      return ValueSlope{scale * value, scale * (slope - 2.0 * value / x)};
    };
    a0 = divided(3.0 * (s1.value * s1.value - s2.value), 6.0 * (s1.value * s1.slope - s2.slope));
    a1 = divided(2.0 * (3.0 * s2.value * s2.value - 2.0 * s2.value - s4.value),
                 2.0 * (12.0 * s2.value * s2.slope - 4.0 * s2.slope - 4.0 * s4.slope));
  }
  /// Largest |A + a B - 1| up to x: below kSeries term by term, then the extremes of A (-0.0223, 1), B (+-0.2098).
  static double deviation(double a, double x) {
    if (!(x < kSeries)) return 1.0223 + (a < -0.5 ? 0.2098 * -a : 0.0);
    const double q = kPi * kPi * x * x;
    double power = 1.0, bound = 0.0;
    for (int k = 2; k <= kTerms; ++k) bound += std::abs(coefficient_a0(k) + a * coefficient_a1(k)) * (power *= q);
    return bound;
  }

  static constexpr double kSeries = 0.25;

 private:
  static constexpr int kTerms = 16;
  /// 1/(2k + 2)!, k >= 0
  static constexpr double inverse_factorial(int k) {
    double f = 1.0;
    for (int i = 2; i <= 2 * k + 2; ++i) f /= i;
    return f;
  }
  static constexpr double power_of_4(int k) { return k == 0 ? 1.0 : 4.0 * power_of_4(k - 1); }
  /// Coefficients of (pi x)^(2k - 2), k >= 1.
  static constexpr double coefficient_a0(int k) {
    return (k % 2 == 1 ? 6.0 : -6.0) * k * power_of_4(k) * inverse_factorial(k);
  }
  static constexpr double coefficient_a1(int k) {
    return (k % 2 == 1 ? 2.0 : -2.0) * power_of_4(k) * ((2 * k - 4) * power_of_4(k) + 4 * (k + 1)) *
           inverse_factorial(k);
  }
  static constexpr auto table(double (*coefficient)(int)) {
    std::array<double, kTerms> c{};
    for (int k = 1; k <= kTerms; ++k) c[static_cast<std::size_t>(k - 1)] = coefficient(k);
    return c;
  }
  static ValueSlope polynomial(const std::array<double, kTerms>& c, double x) {
    const double q = kPi * kPi * x * x;
    double value = 0.0, slope = 0.0;
    for (std::size_t k = c.size(); k-- > 0;) {
      slope = slope * q + value;
      value = value * q + c[k];
    }
    return {value, 2.0 * kPi * kPi * x * slope};
  }
  void series(double x) {
    static constexpr auto c0 = table(coefficient_a0), c1 = table(coefficient_a1);
    a0 = polynomial(c0, x);
    a1 = polynomial(c1, x);
  }
};

template <class S>
struct Interpolation {
  static constexpr std::string_view kind = "interpolation";
  static constexpr std::string_view doc = "interpolation between samples: nearest, linear, cubic, spline, zoom filter";
  static constexpr Stages stages{.postsample = true};
  static constexpr SensorPart part = SensorPart::display;
  static constexpr bool is_reconstruction = true;

  enum Kernel { nearest, linear, cubic, bspline, six_coefficient };
  static constexpr std::array<std::string_view, 5> kKernelNames{"nearest", "linear", "cubic", "bspline",
                                                                "six_coefficient"};
  static constexpr std::array<double, 6> kSix{.6213, -.1704, .0693, -.0276, .0100, -.0030};

  Choice kernel{0, kKernelNames};
  std::optional<S> a{};

  static constexpr auto fields() {
    return std::tuple{
        required(&Interpolation::kernel, "kernel", "\"cubic\"", "nearest, linear, cubic, bspline or six_coefficient"),
        optional(&Interpolation::a, "a", -2.0, 0.0, "-0.5",
                 "parameter of the cubic kernel, its slope at one pixel; -0.5 unless given")};
  }
  double cubic_a() const { return a ? value_of(*a) : -0.5; }
  Traits traits(const Context<S>& ctx) const {
    const bool six = kernel.index == six_coefficient;
    double zero = 0.5;
    for (const double c : kSix) zero += c;
    return {.separable = !six,
            .even_x = true,
            .even_y = true,
            .square = ctx.frame.square(),
            .gain = six || (kernel.index == cubic && cubic_a() < -0.5),
            .dc = six ? zero * zero : 1.0};
  }
  S response(const S& x) const {
    const double v = value_of(x);
    if (kernel.index == cubic) {
      const KeysCubic keys(v);
      return lift(keys.a0, x) + a.value_or(S(-0.5)) * lift(keys.a1, x);
    }
    if (kernel.index == six_coefficient) {
      // cos and sin of odd multiples of pi x by their recurrence, twice the angle at a time.
      const double c1 = cos_pi(v), s1 = sin_pi(v), step = 2.0 * (c1 - s1) * (c1 + s1);
      double c = c1, s = s1, c_before = c1, s_before = -s1;
      ValueSlope sum{0.5, 0.0};
      for (std::size_t j = 0; j < kSix.size(); ++j) {
        sum.value += kSix[j] * c;
        sum.slope -= kSix[j] * (2.0 * static_cast<double>(j) + 1.0) * kPi * s;
        c_before = std::exchange(c, step * c - c_before);
        s_before = std::exchange(s, step * s - s_before);
      }
      return lift(sum, x);
    }
    const S s = sinc_of(x);
    if (kernel.index == nearest) return s;
    if (kernel.index == linear) return s * s;
    const S wave = lift({cos_pi(2.0 * v), -2.0 * kPi * sin_pi(2.0 * v)}, x);
    return S(3) * (s * s) * (s * s) / (S(2) + wave);
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    return {response(ctx.frame.cy_per_px(f.x, Axis::x)) * response(ctx.frame.cy_per_px(f.y, Axis::y)), S(0)};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double x = axis_deviation(fx * 1e-3 * value_of(ctx.frame.pitch_x_um)),
                 y = axis_deviation(fy * 1e-3 * value_of(ctx.frame.pitch_y_um));
    return x + y + x * y;
  }
  std::vector<Problem> check(const Context<S>&) const {
    if (a && kernel.index != cubic)
      return {{.field = "a", .text = "belongs to kernel = \"cubic\"; remove it, or choose that kernel"}};
    return {};
  }

 private:
  /// Bound of |1 - response| up to x. Squares of sinc and splines fall from 1 to their first zero and stay in [0, 1].
  double axis_deviation(double x) const {
    switch (kernel.index) {
      case nearest:
        return sinc_deviation(x);
      case cubic:
        return KeysCubic::deviation(cubic_a(), x);
      case six_coefficient: {
        double bound = 0.0, zero = -0.5;
        for (std::size_t j = 0; j < kSix.size(); ++j) {
          const double half = 0.5 * (2.0 * static_cast<double>(j) + 1.0) * kPi * x;
          bound += 2.0 * std::abs(kSix[j]) * std::min(1.0, half * half);
          zero += kSix[j];
        }
        return bound + std::abs(zero);
      }
      default:
        return x < 1.0 ? std::max(0.0, 1.0 - Interpolation<double>{kernel, {}}.response(x)) : 1.0;
    }
  }
};

}  // namespace mtf
