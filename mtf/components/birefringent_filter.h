// SPDX-License-Identifier: Apache-2.0
#pragma once

// Optical low-pass filter of birefringent plates before a sampled detector: each point becomes two along x, each of
// these two along y, four spots of equal strength at (+-sx/2, +-sy/2).
//   otf = cos(pi sx fx) cos(pi sy fy)
// s = separation of the spots per axis; a separation of 0 leaves that axis alone (a two-spot filter). Real and signed:
// the first zero at f = 1/(2 s) is Nyquist for a separation of one pitch. Separable. The plates' own dispersion is left
// out: the separation holds at every wavelength. (Greivenkamp, Appl. Opt. 29, 676 (1990).)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct BirefringentFilter {
  static constexpr std::string_view kind = "birefringent_filter";
  static constexpr std::string_view doc = "optical low-pass filter that splits each point into four";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::optics;

  AxisPair<S> separation{};

  static constexpr auto fields() {
    return std::tuple{required(&BirefringentFilter::separation, "separation", 0.0, 1e9, "\"0.5 px\"",
                               "distance between the spots, per axis")};
  }
  S separation_mm(Axis axis, const Context<S>& ctx) const {
    return (axis == Axis::x ? separation.x_um(ctx.frame) : separation.y_um(ctx.frame)) * S(1e-3);
  }
  Traits traits(const Context<S>& ctx) const {
    const bool alike = value_of(separation_mm(Axis::x, ctx)) == value_of(separation_mm(Axis::y, ctx));
    return {.separable = true, .even_x = true, .even_y = true, .square = alike};
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    return {cosine(S(separation_mm(Axis::x, ctx) * f.x)) * cosine(S(separation_mm(Axis::y, ctx) * f.y)), S(0)};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const auto one_axis = [&](Axis axis, double f) {
      const double s = sin_pi(0.5 * std::min(1.0, value_of(separation_mm(axis, ctx)) * f));
      return 2.0 * s * s;  // 1 - cos, which rises up to half a turn
    };
    return std::min(2.0, one_axis(Axis::x, fx) + one_axis(Axis::y, fy));
  }

 private:
  /// cos(pi x), the argument reduced exactly.
  static S cosine(const S& x) {
    const auto [s, c] = sin_cos_pi(value_of(x));
    return lift({c, -kPi * s}, x);
  }
};

}  // namespace mtf
