// SPDX-License-Identifier: Apache-2.0
#pragma once

// A measured or computed MTF as a table: radial (against |f|) or along one axis (list it twice, once per axis, for
// both).
//   otf = monotone cubic through the samples
// From 1 at f = 0 when the table starts later; beyond the last sample straight on to 0 along the last slope, or along
// the mean fall 1/(last frequency) where that is steeper, and 0 from there. Frequencies in cy/mm, cy/mrad or cy/px, as
// the file's header says; the latter two follow the frame. Real and even: signed values are allowed (contrast
// reversal), phase is not. As valid as its samples are dense, and as far as they go: where they end above 0 the
// straight end is a guess, off by no more than the last value, and said. (Fritsch and Carlson, SIAM J. Numer. Anal. 17,
// 238 (1980): monotone cubics.)

#include <algorithm>

#include "mtf/components/field.h"

namespace mtf {

inline constexpr std::array<std::string_view, 3> kCurveAxisNames{"radial", "x", "y"};

template <class S>
struct CurveOtf {
  static constexpr std::string_view kind = "curve";
  static constexpr std::string_view doc = "tabulated MTF from CSV lines, radial or along one axis";
  static constexpr Stages stages{.presample = true, .readout = true, .postsample = true};

  std::shared_ptr<const Curve> curve{};
  Choice axis{0, kCurveAxisNames};
  Choice part{0, kSensorPartNames};

  static constexpr auto fields() {
    return std::tuple{required(&CurveOtf::curve, "file", "\"lens.csv\"",
                               "CSV with two columns, frequency and MTF, the unit in the header: frequency_cy_mm,mtf; "
                               "or its lines themselves, in a text of several lines"),
                      optional(&CurveOtf::axis, "axis", "\"radial\"", "radial, or the one axis it acts along"),
                      Field{&CurveOtf::part, kPartInfo}};
  }
  Traits traits(const Context<S>& ctx) const {
    // A radial table in cycles per pixel of non-square pixels is elliptic.
    const bool round = curve->unit->name != "cy/px" || value_of(ctx.frame.pitch_x_um) == value_of(ctx.frame.pitch_y_um);
    const bool gain = std::any_of(curve->value.begin(), curve->value.end(), [](double v) { return std::abs(v) > 1.0; });
    return {
        .radial = axis.index == 0 && round, .separable = axis.index != 0, .even_x = true, .even_y = true, .gain = gain};
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const auto own_unit = [&](const S& along, Axis a) {
      if (curve->unit->name == "cy/mrad") return ctx.frame.cy_per_mrad(along);
      if (curve->unit->name == "cy/px") return ctx.frame.cy_per_px(along, a);
      return along;
    };
    const S u = axis.index == 0   ? radius(own_unit(f.x, Axis::x), own_unit(f.y, Axis::y))
                : axis.index == 1 ? own_unit(f.x, Axis::x)
                                  : own_unit(f.y, Axis::y);
    return {lift(evaluate(*curve, value_of(u)), u), S(0)};
  }
  /// Where a radial curve has come to 0; one along an axis leaves the other.
  double cutoff_cy_mm(const Context<S>& ctx) const { return axis.index == 0 ? value_of(end_cy_mm(ctx)) : kInfinity; }
  /// |f| from which a radial curve is 0; of pixels that are not square, along their shorter side.
  S end_cy_mm(const Context<S>& ctx) const {
    const auto end = static_cast<S>(end_of(*curve));
    if (curve->unit->name == "cy/mrad") return ctx.frame.cy_mm_from_mrad(end);
    if (curve->unit->name == "cy/px")
      return ctx.frame.cy_mm_from_px(end, ctx.frame.pitch_y_um < ctx.frame.pitch_x_um ? Axis::y : Axis::x);
    return end;
  }
  double deviation(double, double, const Context<S>&) const {
    double worst = 1.0;
    for (const double v : curve->value) worst = std::max(worst, std::abs(1.0 - v));
    return worst;
  }
  std::vector<Problem> check(const Context<S>&) const {
    if (curve == nullptr) return {{.field = "file", .text = "missing"}};
    if (std::abs(curve->value.back()) <= 1e-3) return {};
    return {{.error = false,
             .field = "file",
             .text = (curve->source.empty() ? std::string("the curve") : curve->source) + " ends at " +
                     format_double(curve->frequency.back()) + " " + std::string(curve->unit->name) + " with MTF " +
                     format_double(curve->value.back()) +
                     "; beyond it the curve goes straight on to 0, which it reaches at " +
                     format_double(end_of(*curve)) + ", so that its MTF there is off by up to " +
                     three_digits(std::abs(curve->value.back())) + "; measure it further out"}};
  }
};

}  // namespace mtf
