// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sinusoidal line-of-sight vibration along a direction, many cycles (or a whole number) in one integration time:
//   otf = J0(2 pi d . f), d = amplitude (cos a, sin a), a from +x (right) to +y (down); amplitude is peak from the
//   middle
// Real: the negative lobes (contrast reversal) are kept. The high-frequency limit only: for an exposure of less than
// about two cycles the blur depends on its start, which is not offered yet. rms displacement = amplitude / sqrt(2).
// (Kopeika, A System Engineering Approach to Imaging, ch. 14; Boreman, ch. 6.)

#include "mtf/components/bessel.h"
#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct Vibration {
  static constexpr std::string_view kind = "vibration";
  static constexpr std::string_view doc = "sinusoidal vibration of many cycles in the integration time";
  static constexpr Stages stages{.presample = true};

  AxisPair<S> amplitude;
  S direction_deg{};

  static constexpr auto fields() {
    return std::tuple{Field{FieldInfo{.name = "amplitude",
                                      .dimension = Dimension::extent,
                                      .lo = 0.0,
                                      .hi = 1e9,
                                      .example = "\"5 um\"",
                                      .doc = "peak displacement from the middle, half of peak to peak"},
                            &Vibration::amplitude},
                      Field{kDirectionInfo, &Vibration::direction_deg}};
  }
  Freq<S> displacement_mm(const Context<S>& ctx) const {
    const auto [cosine, sine] = unit_vector(direction_deg);
    return {amplitude.x_um(ctx.frame) * cosine * S(1e-3), amplitude.y_um(ctx.frame) * sine * S(1e-3)};
  }
  Traits traits(const Context<S>& ctx) const {
    const Freq<S> d = displacement_mm(ctx);
    const bool along_axis = value_of(d.x) == 0.0 || value_of(d.y) == 0.0;
    return {.separable = along_axis, .even_x = along_axis, .even_y = along_axis};
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const Freq<S> d = displacement_mm(ctx);
    const S x = d.x * f.x + d.y * f.y;
    const ValueSlope j0 = bessel_j0(2.0 * kPi * value_of(x));
    return {lift({j0.value, 2.0 * kPi * j0.slope}, x), S(0)};
  }
  double cutoff_cy_mm(const Context<S>&) const { return kInfinity; }
  /// J0 falls monotonically to its deepest lobe, -0.40276 at 3.83.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const Freq<S> d = displacement_mm(ctx);
    const double x = 2.0 * kPi * (std::abs(value_of(d.x)) * fx + std::abs(value_of(d.y)) * fy);
    return x < 3.8 ? 1.0 - bessel_j0(x).value : 1.4028;
  }
  std::vector<Problem> check(const Context<S>&) const {
    if (amplitude.split)
      return {{.field = "amplitude", .text = "give one amplitude and a direction instead of amplitude_x, amplitude_y"}};
    return {};
  }
};

}  // namespace mtf
