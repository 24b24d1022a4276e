// SPDX-License-Identifier: Apache-2.0
#pragma once

// Light scattered into a wide halo around every point: a part h of it leaves the core, which stays as sharp as it is.
//   otf = (1 - h) + h G,  q = sqrt((wx fx)^2 + (wy fy)^2)
//   gaussian     G = exp(-2 pi^2 q^2)              psf exp(-r^2/(2 w^2))
//   exponential  G = (1 + (2 pi q)^2)^(-3/2)       psf exp(-r/w)
//   lorentz      G = exp(-2 pi q)                  psf (1 + (r/w)^2)^(-3/2)
// h = fraction, w = width per axis: the standard deviation, the 1/e radius, the radius at which it has fallen to 0.354.
// Real, positive, even; radial when wx = wy. It falls to 1 - h at frequencies of 1/w and stays there: contrast lost at
// all but the coarsest detail. Scatter of polished surfaces falls as a power of r, near the Lorentz halo's r^-3.
// Light spread evenly over the image is the veiling glare of the radiometry. (Bennett and Mattsson, Introduction to
// Surface Roughness and Scattering; transforms: Bracewell, The Fourier Transform and Its Applications.)

#include "mtf/components/field.h"

namespace mtf {

inline constexpr std::array<std::string_view, 3> kHaloNames{"gaussian", "exponential", "lorentz"};

template <class S>
struct Halo {
  static constexpr std::string_view kind = "halo";
  static constexpr std::string_view doc = "light scattered into a wide halo around every point";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::optics;

  S fraction{};
  AxisPair<S> width{};
  Choice profile{0, kHaloNames};

  static constexpr auto fields() {
    return std::tuple{required(&Halo::fraction, "fraction", 0.0, 1.0, "0.05", "part of the light in the halo"),
                      required(&Halo::width, "width", 1e-6, 1e9, "\"200 um\"", "width w of the halo, per axis"),
                      optional(&Halo::profile, "profile", "\"lorentz\"", "gaussian, exponential or lorentz")};
  }
  Traits traits(const Context<S>& ctx) const {
    return {.radial = width.isotropic(ctx.frame), .even_x = true, .even_y = true};
  }
  /// 1 - G at q, and its slope; no digits are lost where G is close to 1.
  ValueSlope lost(double q) const {
    const double t = 2.0 * kPi * q;
    if (!(t < 1e100)) return {1.0, 0.0};
    if (profile.index == 0) {
      const double half = 0.5 * t * t;
      return {-std::expm1(-half), 2.0 * kPi * t * std::exp(-half)};
    }
    if (profile.index == 1) {
      const double u = std::log1p(t * t);
      return {-std::expm1(-1.5 * u), 6.0 * kPi * t * std::exp(-2.5 * u)};
    }
    return {-std::expm1(-t), 2.0 * kPi * std::exp(-t)};
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S q = radius(S(width.x_um(ctx.frame) * S(1e-3) * f.x), S(width.y_um(ctx.frame) * S(1e-3) * f.y));
    return {S(1) - fraction * lift(lost(value_of(q)), q), S(0)};
  }
  /// G falls monotonically.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double x = value_of(width.x_um(ctx.frame)) * 1e-3 * fx, y = value_of(width.y_um(ctx.frame)) * 1e-3 * fy;
    return value_of(fraction) * lost(std::hypot(x, y)).value;
  }
};

}  // namespace mtf
