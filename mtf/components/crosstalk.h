// SPDX-License-Identifier: Apache-2.0
#pragma once

// Crosstalk between neighbouring pixels, or inter-pixel capacitance: every pixel passes a fraction s of its signal to
// each of its four side neighbours and c to each of its four corner neighbours.
//   otf = (1 - 4s - 4c) + 2s (cos X + cos Y) + 4c cos X cos Y,  X = 2 pi fx px, Y = 2 pi fy py
// px, py = pitch. Real; periodic in the sampling frequency, so the same before and after sampling. The bounds of s and
// c keep the middle tap from going negative: passive. Do not use it beside `diffusion` for the same measured spread.
// (Moore, Ninkov, Forrest, Opt. Eng. 45, 076402 (2006).)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct Crosstalk {
  static constexpr std::string_view kind = "crosstalk";
  static constexpr std::string_view doc = "crosstalk or inter-pixel capacitance between neighbouring pixels";
  static constexpr Stages stages{.presample = true, .readout = true};
  static constexpr SensorPart part = SensorPart::detector;

  S side{};
  std::optional<S> corner{};

  static constexpr auto fields() {
    return std::tuple{required(&Crosstalk::side, "side", 0.0, 0.125, "0.03",
                               "fraction that reaches each of the four side neighbours"),
                      optional(&Crosstalk::corner, "corner", 0.0, 0.125, "0.005",
                               "fraction that reaches each of the four corner neighbours; 0 when absent")};
  }
  Traits traits(const Context<S>& ctx) const { return {.even_x = true, .even_y = true, .square = ctx.frame.square()}; }
  /// sin^2(pi f p), the only form in which the frequency enters: no cancellation at small f.
  static S sine_square(const S& f, Axis axis, const Context<S>& ctx) {
    const S x = ctx.frame.cy_per_px(f, axis);
    const auto [s, c] = sin_cos_pi(value_of(x));
    return lift({s * s, 2.0 * kPi * s * c}, x);
  }
  S value(const S& a, const S& b) const {
    const S c = corner.value_or(S(0));
    return S(1) - S(4) * (side + S(2) * c) * (a + b) + S(16) * c * a * b;
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    return {value(sine_square(f.x, Axis::x, ctx), sine_square(f.y, Axis::y, ctx)), S(0)};
  }
  auto rows(std::span<const S> fx, const Context<S>& ctx) const {
    std::vector<S> a;
    for (const S& f : fx) a.push_back(sine_square(f, Axis::x, ctx));
    return [*this, a = std::move(a), ctx](const S& fy, std::span<Complex<S>> h) {
      const S b = sine_square(fy, Axis::y, ctx);
      for (std::size_t i = 0; i < h.size(); ++i) {
        const S v = value(a[i], b);
        h[i] = {h[i].re * v, h[i].im * v};
      }
    };
  }
  /// 1 - otf = 4s (a + b) + 8c (a + b - 2ab), every part of it >= 0.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const auto largest = [&](double f, Axis axis) {
      const double s = sin_pi(std::min(0.5, f * value_of(ctx.frame.pitch_um(axis)) * 1e-3));
      return s * s;
    };
    const double sum = largest(fx, Axis::x) + largest(fy, Axis::y);
    return 4.0 * value_of(side) * sum + 8.0 * value_of(corner.value_or(S(0))) * std::min(1.0, sum);
  }
};

}  // namespace mtf
