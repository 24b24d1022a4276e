// SPDX-License-Identifier: Apache-2.0
#pragma once

// Lateral diffusion in a front-lit detector: charge from the field-free bulk behind the depletion layer spreads.
//   otf = [1 - exp(-W/A) / (1 + L(f)/A)] / [1 - exp(-W/A) / (1 + L0/A)],  L(f) = L0 / sqrt(1 + (2 pi L0 |f|)^2)
// A = absorption length (1 / absorption coefficient), W = depth of the depletion layer, L0 = diffusion length. Light
// absorbed within W is collected where it fell: a floor above 0 unless W = 0. The bulk is thicker than A and L0 by far
// (nothing returns from its other side). Light from the back crosses the bulk first and spreads more: not by this
// formula, take a `curve`. Real, positive, radial. A depends on the wavelength: give the mean of the band. Do not use
// it beside `crosstalk` for the same measured spread. (Seib, IEEE Trans. Electron Devices 21, 210 (1974).)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct Diffusion {
  static constexpr std::string_view kind = "diffusion";
  static constexpr std::string_view doc = "lateral charge diffusion with depth of absorption";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::detector;

  OptionalIn<S, micrometres> absorption_length_um{};
  NumberIn<S, micrometres> depletion_depth_um{};
  OptionalIn<S, micrometres> diffusion_length_um{};

  static constexpr auto fields() {
    return std::tuple{required(&Diffusion::absorption_length_um, "absorption_length", "um", 1e-3, 1e6, "\"10 um\"",
                               "depth in which 1/e of the light is left, 1 / absorption coefficient"),
                      required(&Diffusion::depletion_depth_um, "depletion_depth", "um", 0.0, 1e6, "\"3 um\"",
                               "depth of the depletion layer"),
                      required(&Diffusion::diffusion_length_um, "diffusion_length", "um", 1e-6, 1e6, "\"20 um\"",
                               "diffusion length of the carriers")};
  }
  Traits traits(const Context<S>&) const { return {.radial = true, .even_x = true, .even_y = true}; }
  /// The fraction above with q = 1 - exp(-W/A), s = L(f)/L0: the value from sums of positive terms, the derivatives
  /// from 1 - otf = L0/(qA + L0) x A (1 - q)/(A + L0 s) x (1 - s), so that they vanish at f = 0 without cancellation.
  Complex<S> otf(const Freq<S>& f, const Context<S>&) const {
    const S a = absorption_length_um.value_or(S(1)), l = diffusion_length_um.value_or(S(1));
    const S depth = depletion_depth_um.value / a;
    const double left = std::exp(-value_of(depth));
    const S near = a * lift({-std::expm1(-value_of(depth)), left}, depth);
    const S x = radius(S(l * f.x * S(1e-3)), S(l * f.y * S(1e-3)));
    const ValueSlope s = shrink(value_of(x));
    const S far = l * lift(s, x);
    const S value = ((near + far) / (near + l)) * ((a + l) / (a + far));
    const S lost = l / (near + l) * (a * lift({left, -left}, depth) / (a + far)) * lift({1.0 - s.value, -s.slope}, x);
    return {lift({value_of(value), 1.0}, S(S(1) - lost)), S(0)};
  }
  /// The otf falls monotonically.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    return std::max(0.0, 1.0 - value_of(otf({S(std::hypot(fx, fy)), S(0)}, ctx).re));
  }

 private:
  /// 1/sqrt(1 + (2 pi x)^2).
  static ValueSlope shrink(double x) {
    const double u = 2.0 * kPi * x;
    if (!(u < 1e150)) return {u < kInfinity ? 1.0 / u : 0.0, 0.0};
    const double value = 1.0 / std::sqrt(1.0 + u * u);
    return {value, -2.0 * kPi * (u * value) * value * value};
  }
};

}  // namespace mtf
