// SPDX-License-Identifier: Apache-2.0
#pragma once

// Gaussian blur.
//   otf = exp(-2 pi^2 (sx^2 fx^2 + sy^2 fy^2))
// s = standard deviation of the point spread per axis. Real, positive, separable; radial when sx = sy. A stand-in for
// blur that is known only by its size (geometric aberrations, diffusion, display spot), best where many small causes
// add up. (Boreman, Modulation Transfer Function in Optical and Electro-Optical Systems.)

#include "mtf/components/field.h"

namespace mtf {

/// Shared by every component whose OTF is a Gaussian of a size per axis.
template <class S>
struct GaussianOtf {
  static Complex<S> otf(const AxisPair<S>& sigma, const Freq<S>& f, const Context<S>& ctx) {
    const S sx = sigma.x_um(ctx.frame) * S(1e-3);
    const S sy = sigma.y_um(ctx.frame) * S(1e-3);
    return {gaussian_of(S(sx * f.x)) * gaussian_of(S(sy * f.y)), S(0)};
  }
  static Traits traits(const AxisPair<S>& sigma, const Context<S>& ctx) {
    return {.radial = sigma.isotropic(ctx.frame), .separable = true, .even_x = true, .even_y = true};
  }
  static double deviation(const AxisPair<S>& sigma, double fx, double fy, const Context<S>& ctx) {
    const double x = value_of(sigma.x_um(ctx.frame)) * 1e-3 * fx, y = value_of(sigma.y_um(ctx.frame)) * 1e-3 * fy;
    return -std::expm1(-2.0 * kPi * kPi * (x * x + y * y));
  }
};

template <class S>
struct Gaussian {
  static constexpr std::string_view kind = "gaussian";
  static constexpr std::string_view doc = "Gaussian blur of given standard deviation";
  static constexpr Stages stages{.presample = true, .readout = true, .postsample = true};

  AxisPair<S> sigma{};
  Choice part{0, kSensorPartNames};

  static constexpr auto fields() {
    return std::tuple{
        required(&Gaussian::sigma, "sigma", 0.0, 1e9, "\"3 um\"", "standard deviation of the point spread, per axis"),
        Field{&Gaussian::part, kPartInfo}};
  }
  Traits traits(const Context<S>& ctx) const { return GaussianOtf<S>::traits(sigma, ctx); }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const { return GaussianOtf<S>::otf(sigma, f, ctx); }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    return GaussianOtf<S>::deviation(sigma, fx, fy, ctx);
  }
};

}  // namespace mtf
