// SPDX-License-Identifier: Apache-2.0
#pragma once

// Element of a flat panel, evenly lit over its active width, or the three stripes of a colour LCD.
//   width:      otf = sinc(wx fx) sinc(wy fy),  sinc(x) = sin(pi x)/(pi x)
//   lcd_pitch:  otf = sinc(0.29 P fx) [0.68 + 0.32 cos(0.64 pi P fx)] sinc(0.85 P fy)
// w = active width per axis of a monochrome element; P = pitch of a colour LCD with three vertical stripes. The second
// is the luminance of a white element: stripes 0.29 P wide, the middle one with 0.68 of it, the outer ones at -0.32 P
// and +0.32 P with 0.16 each. It is 1 at f = 0; the form with a product, 0.68 x 0.32 cos(...), that is found in print
// is not. Sizes are given at the focal plane, which the panel shows magnified: "1 px" is one pixel of the image as
// shown. Real and signed; separable. (Holst, Electro-Optical Imaging System Performance; Vollmerhausen and Driggers,
// Analysis of Sampled Imaging Systems.)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct DisplayFlatPanel {
  static constexpr std::string_view kind = "display_flat_panel";
  static constexpr std::string_view doc = "active area of a flat-panel display, monochrome or colour LCD";
  static constexpr Stages stages{.postsample = true};
  static constexpr SensorPart part = SensorPart::display;
  static constexpr bool is_reconstruction = true;

  AxisPair<S> width{};
  AxisPair<S> lcd_pitch{};

  static constexpr auto fields() {
    return std::tuple{
        excluding("lcd_pitch", optional(&DisplayFlatPanel::width, "width", 0.0, 1e9, "\"0.9 px\"",
                                        "active width of an element, per axis; px are those of the image")),
        excluding("width", optional(&DisplayFlatPanel::lcd_pitch, "lcd_pitch", 0.0, 1e9, "\"1 px\"",
                                    "pitch of a colour LCD with vertical stripes, instead of width"))};
  }
  Traits traits(const Context<S>&) const { return {.separable = true, .even_x = true, .even_y = true}; }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const AxisPair<S>& size = width.given() ? width : lcd_pitch;
    const S x = size.x_um(ctx.frame) * S(1e-3) * f.x, y = size.y_um(ctx.frame) * S(1e-3) * f.y;
    if (width.given()) return {sinc_of(x) * sinc_of(y), S(0)};
    return {sinc_of(S(S(0.29) * x)) * stripes(x) * sinc_of(S(S(0.85) * y)), S(0)};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const AxisPair<S>& size = width.given() ? width : lcd_pitch;
    const double x = value_of(size.x_um(ctx.frame)) * 1e-3 * fx, y = value_of(size.y_um(ctx.frame)) * 1e-3 * fy;
    if (width.given()) return sinc_deviation(x) + sinc_deviation(y);
    const double s = sin_pi(std::min(0.32 * x, 0.5));
    return sinc_deviation(0.29 * x) + 0.64 * s * s + sinc_deviation(0.85 * y);
  }
  std::vector<Problem> check(const Context<S>&) const {
    if (width.given() == lcd_pitch.given()) return {{.field = "width", .text = "give exactly one of width, lcd_pitch"}};
    return {};
  }

 private:
  /// 0.68 + 0.32 cos(0.64 pi x), as 1 less a square.
  static S stripes(const S& x) {
    const double v = 0.32 * value_of(x), s = sin_pi(v);
    const bool steep = std::abs(v) < 1e15;  // beyond, neighbouring doubles are whole periods apart: no slope
    return lift({1.0 - 0.64 * s * s, steep ? -1.28 * 0.32 * kPi * s * cos_pi(v) : 0.0}, x);
  }
};

}  // namespace mtf
