// SPDX-License-Identifier: Apache-2.0
#pragma once

// Light that spreads in a substrate before it is collected: its mean path to the side is l, in any direction.
//   otf = (1 + (2 pi l f)^2)^(-3/2)                psf exp(-r/l)
// Real, positive, radial. A component of this project: the toolkit does not know it.

#include "mtf/components/field.h"

template <class S>
struct SubstrateSpread {
  static constexpr std::string_view kind = "substrate_spread";
  static constexpr std::string_view doc = "light that spreads in the substrate";
  static constexpr mtf::Stages stages{.presample = true};
  static constexpr mtf::SensorPart part = mtf::SensorPart::detector;

  mtf::AxisPair<S> length{};

  static constexpr auto fields() {
    return std::tuple{
        mtf::required(&SubstrateSpread::length, "length", 0.0, 1e6, "\"2 um\"", "the 1/e radius of the point spread")};
  }
  mtf::Traits traits(const mtf::Context<S>& ctx) const {
    return {.radial = length.isotropic(ctx.frame), .even_x = true, .even_y = true};
  }
  mtf::Complex<S> otf(const mtf::Freq<S>& f, const mtf::Context<S>& ctx) const {
    using std::pow;
    const S q = mtf::radius(S(length.x_um(ctx.frame) * S(1e-3) * f.x), S(length.y_um(ctx.frame) * S(1e-3) * f.y));
    const S t = S(2.0 * mtf::kPi) * q;
    return {S(1) / pow(S(1) + t * t, S(1.5)), S(0)};
  }
  double deviation(double fx, double fy, const mtf::Context<S>& ctx) const {
    const mtf::Complex<S> h = otf({S(fx), S(fy)}, ctx);  // it falls monotonically
    return 1.0 - mtf::value_of(h.re);
  }
};
