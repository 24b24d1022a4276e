// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random line-of-sight motion, Gaussian.
//   otf = exp(-2 pi^2 (sx^2 fx^2 + sy^2 fy^2 + a^2 (x fy - y fx)^2))
// s = rms displacement of one axis (one sigma), at the focal plane; a = rms angle of the roll about the optical axis,
// (x, y) = place of the pixel from that axis, whose displacement grows with the distance and is at right angles to it.
// Real, positive; separable without roll, radial when also sx = sy. Valid for many independent positions in one
// integration time. (Kopeika, A System Engineering Approach to Imaging, ch. 14.)

#include "mtf/components/gaussian.h"

namespace mtf {

template <class S>
struct Jitter {
  static constexpr std::string_view kind = "jitter";
  static constexpr std::string_view doc = "random line-of-sight motion, rms per axis";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::motion;

  AxisPair<S> rms{};
  OptionalIn<S, microradians> roll_urad{};

  static constexpr auto fields() {
    return std::tuple{required(&Jitter::rms, "rms", 0.0, 1e9, "\"8 urad\"", "rms displacement of one axis, one sigma"),
                      optional(&Jitter::roll_urad, "roll", "urad", 0.0, 1e6, "\"300 urad\"",
                               "rms angle of the roll about the optical axis, one sigma")};
  }
  Traits traits(const Context<S>& ctx) const {
    Traits traits = GaussianOtf<S>::traits(rms, ctx);
    if (!roll_urad || value_of(*roll_urad) == 0.0) return traits;
    traits.placed = true;
    const bool on_x = value_of(ctx.place.y_um) == 0.0, on_y = value_of(ctx.place.x_um) == 0.0;
    if (on_x && on_y) return traits;
    traits.radial = false;
    traits.separable = traits.even_x = traits.even_y = on_x || on_y;
    return traits;
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const Complex<S> h = GaussianOtf<S>::otf(rms, f, ctx);
    if (!roll_urad) return h;
    const Freq<S> arm = roll_mm(ctx);
    return {h.re * gaussian_of(S(arm.x * f.y - arm.y * f.x)), S(0)};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double shift = GaussianOtf<S>::deviation(rms, fx, fy, ctx);
    if (!roll_urad) return shift;
    const Freq<S> arm = roll_mm(ctx);
    const double t = std::abs(value_of(arm.x)) * fy + std::abs(value_of(arm.y)) * fx;
    return shift - std::expm1(-2.0 * kPi * kPi * t * t) * (1.0 - shift);
  }

 private:
  /// rms displacement by the roll, turned by a right angle, in mm.
  Freq<S> roll_mm(const Context<S>& ctx) const {
    const S angle = *roll_urad * S(1e-6);
    return {angle * ctx.place.x_um * S(1e-3), angle * ctx.place.y_um * S(1e-3)};
  }
};

}  // namespace mtf
