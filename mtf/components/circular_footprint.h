// SPDX-License-Identifier: Apache-2.0
#pragma once

// Circular or elliptic detector footprint of uniform response.
//   otf = 2 J1(pi r)/(pi r),  r = sqrt((dx fx)^2 + (dy fy)^2)
// d = diameter of the active area, per axis. Real and signed: negative between its zeros, the first at r = 1.2197.
// Radial when the diameters are equal. (Boreman, Modulation Transfer Function in Optical and Electro-Optical Systems,
// ch. 2.)

#include "mtf/components/field.h"
#include "mtf/math/special.h"

namespace mtf {

template <class S>
struct CircularFootprint {
  static constexpr std::string_view kind = "circular_footprint";
  static constexpr std::string_view doc = "circular or elliptic detector footprint";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::detector;
  static constexpr bool is_footprint = true;

  AxisPair<S> diameter{};

  static constexpr auto fields() {
    return std::tuple{required(&CircularFootprint::diameter, "diameter", 0.0, 1e9, "\"15 um\"",
                               "diameter of the active area, per axis")};
  }
  Traits traits(const Context<S>& ctx) const {
    return {.radial = diameter.isotropic(ctx.frame), .even_x = true, .even_y = true};
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S r = radius(S(diameter.x_um(ctx.frame) * S(1e-3) * f.x), S(diameter.y_um(ctx.frame) * S(1e-3) * f.y));
    const ValueSlope h = jinc(kPi * value_of(r));
    return {lift({h.value, kPi * h.slope}, r), S(0)};
  }
  /// Falls monotonically to its deepest lobe, -0.13228 at pi r = 5.136.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double r = std::hypot(value_of(diameter.x_um(ctx.frame)) * fx, value_of(diameter.y_um(ctx.frame)) * fy);
    return kPi * 1e-3 * r < 5.1 ? 1.0 - jinc(kPi * 1e-3 * r).value : 1.1323;
  }
};

}  // namespace mtf
