// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pixels summed n by m into one sample, the gaps between their active areas kept.
//   otf = C(n, px fx) C(m, py fy),  C(n, x) = (1/n) sum over i = 0 ... n-1 of cos(2 pi x (i - (n-1)/2))
// p = spacing of the native pixels; the response of one of them is its own component (`footprint` of a width up to p).
// frame.pitch is the pitch of the binned output, at which the image is sampled; the spacing defaults to pitch_x/n and
// pitch_y/m. Real and signed; separable; n = m = 1 is 1. Without gaps, a footprint of width p times the binning of n is
// one footprint of width n p. (Holst and Lomheim, CMOS/CCD Sensors and Camera Systems.)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct Binning {
  static constexpr std::string_view kind = "binning";
  static constexpr std::string_view doc = "pixels summed n by m into one sample, gaps kept";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::detector;

  int columns = 0;
  int rows = 0;
  AxisPair<S> spacing{};

  static constexpr auto fields() {
    return std::tuple{required(&Binning::columns, "columns", 1.0, 1000.0, "2", "native pixels summed along x"),
                      required(&Binning::rows, "rows", 1.0, 1000.0, "2", "native pixels summed along y"),
                      optional(&Binning::spacing, "spacing", 0.0, 1e9, "\"2.5 um\"",
                               "pitch of the native pixels; frame.pitch / columns and / rows when absent")};
  }
  int count(Axis axis) const { return axis == Axis::x ? columns : rows; }
  S spacing_mm(Axis axis, const Context<S>& ctx) const {
    if (spacing.given()) return (axis == Axis::x ? spacing.x_um(ctx.frame) : spacing.y_um(ctx.frame)) * S(1e-3);
    return ctx.frame.pitch_um(axis) * S(1e-3 / count(axis));
  }
  Traits traits(const Context<S>& ctx) const {
    const bool alike = value_of(spacing_mm(Axis::x, ctx)) == value_of(spacing_mm(Axis::y, ctx));
    return {.separable = true, .even_x = true, .even_y = true, .square = columns == rows && alike};
  }
  S factor(Axis axis, const S& f, const Context<S>& ctx) const {
    const S x = spacing_mm(axis, ctx) * f;
    return dirichlet_of(count(axis), x);
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    return {factor(Axis::x, f.x, ctx) * factor(Axis::y, f.y, ctx), S(0)};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    return std::min(2.0, dirichlet_deviation(columns, value_of(spacing_mm(Axis::x, ctx)) * fx) +
                             dirichlet_deviation(rows, value_of(spacing_mm(Axis::y, ctx)) * fy));
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    for (const Axis axis : {Axis::x, Axis::y})
      if (value_of(spacing_mm(axis, ctx)) * count(axis) > value_of(ctx.frame.pitch_um(axis)) * 1e-3 * (1.0 + 1e-6))
        return {
            {.error = false,
             .field = "spacing",
             .text = std::string(axis == Axis::x ? "columns" : "rows") +
                     " x spacing exceeds frame.pitch, which is the pitch of the binned output: the samples overlap"}};
    return {};
  }
};

}  // namespace mtf
