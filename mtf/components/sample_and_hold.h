// SPDX-License-Identifier: Apache-2.0
#pragma once

// Each sample held for a length along one axis, as a video line or a row of display elements does.
//   otf = sinc(w f),  sinc(x) = sin(pi x)/(pi x)
// f = frequency along the axis, w = width of the hold. Real and signed: measured from the middle of the hold; the delay
// of w/2 of a causal hold is left out. Acts on what is shown, after sampling. (Holst, Electro-Optical Imaging System
// Performance.)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct SampleAndHold {
  static constexpr std::string_view kind = "sample_and_hold";
  static constexpr std::string_view doc = "samples held for a width along one axis";
  static constexpr Stages stages{.postsample = true};
  static constexpr SensorPart part = SensorPart::display;
  static constexpr bool is_reconstruction = true;

  AxisPair<S> width{};
  Choice axis{0, kAxisNames};

  static constexpr auto fields() {
    return std::tuple{
        required(&SampleAndHold::width, "width", 0.0, 1e9, "\"1 px\"", "width of the hold, at the focal plane"),
        Field{&SampleAndHold::axis, kAxisInfo}};
  }
  S width_mm(const Context<S>& ctx) const {
    return (axis.index == 0 ? width.x_um(ctx.frame) : width.y_um(ctx.frame)) * S(1e-3);
  }
  Traits traits(const Context<S>&) const { return axis_traits(axis, true); }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    return {sinc_of(S(width_mm(ctx) * along(f, axis_of(axis)))), S(0)};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    return sinc_deviation(value_of(width_mm(ctx)) * (axis.index == 0 ? fx : fy));
  }
  std::vector<Problem> check(const Context<S>&) const {
    if (width.split) return {{.field = "width", .text = "give one width and an axis instead of width_x, width_y"}};
    return {};
  }
};

}  // namespace mtf
