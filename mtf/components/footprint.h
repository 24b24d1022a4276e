// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rectangular detector footprint of uniform response.
//   otf = sinc(wx fx) sinc(wy fy),  sinc(x) = sin(pi x)/(pi x)
// w = active width per axis, given, or from the area fill factor: w = pitch x sqrt(fill_factor). Real and signed:
// negative between its zeros, the first at f = 1/w. Separable. (Boreman, Modulation Transfer Function in Optical and
// Electro-Optical Systems, ch. 2.)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct Footprint {
  static constexpr std::string_view kind = "footprint";
  static constexpr std::string_view doc = "rectangular detector footprint";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::detector;
  static constexpr bool is_footprint = true;

  AxisPair<S> width{};
  std::optional<S> fill_factor{};

  static constexpr auto fields() {
    return std::tuple{
        excluding("fill_factor", optional(&Footprint::width, "width", 0.0, 1e9, "\"15 um\"", "active width, per axis")),
        excluding("width", optional(&Footprint::fill_factor, "fill_factor", 1e-9, 1.0, "0.9",
                                    "active area / cell area, instead of width"))};
  }
  S width_mm(Axis axis, const Context<S>& ctx) const {
    using std::sqrt;
    if (width.given()) return (axis == Axis::x ? width.x_um(ctx.frame) : width.y_um(ctx.frame)) * S(1e-3);
    return ctx.frame.pitch_um(axis) * S(1e-3) * sqrt(fill_factor.value_or(S(1)));
  }
  Traits traits(const Context<S>& ctx) const {
    return {.separable = true,
            .even_x = true,
            .even_y = true,
            .square = value_of(width_mm(Axis::x, ctx)) == value_of(width_mm(Axis::y, ctx))};
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    return {sinc_of(S(width_mm(Axis::x, ctx) * f.x)) * sinc_of(S(width_mm(Axis::y, ctx) * f.y)), S(0)};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    return std::min(1.2173, sinc_deviation(value_of(width_mm(Axis::x, ctx)) * fx) +
                                sinc_deviation(value_of(width_mm(Axis::y, ctx)) * fy));
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    if (width.given() == fill_factor.has_value())
      return {{.field = "width", .text = "give either width or fill_factor"}};
    std::vector<Problem> problems;
    for (const Axis axis : {Axis::x, Axis::y})
      if (value_of(width_mm(axis, ctx)) > value_of(ctx.frame.pitch_um(axis)) * 1e-3 * (1.0 + 1e-9))
        problems.push_back(
            {.error = false,
             .field = "width",
             .text = std::string("active width exceeds the pitch along ") + (axis == Axis::x ? "x" : "y")});
    return problems;
  }
};

}  // namespace mtf
