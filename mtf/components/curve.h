// SPDX-License-Identifier: Apache-2.0
#pragma once

// A measured or computed MTF as a table: radial (against |f|) or along one axis (list it twice, once per axis, for
// both).
//   otf = monotone cubic through the samples
//   otf(q) = sum of the weights w_i(q) times the curves at the positions i of the field, where the file has several
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

  CurveSum<S> curve{};
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
    const bool round = unit() != "cy/px" || value_of(ctx.frame.pitch_x_um) == value_of(ctx.frame.pitch_y_um);
    double most = 0.0;
    each([&](const Curve& one, const S& weight) {
      const auto size = [](double v) { return std::abs(v); };
      most += std::abs(value_of(weight)) * size(std::ranges::max(one.value, {}, size));
    });
    return {.radial = axis.index == 0 && round,
            .separable = axis.index != 0,
            .even_x = true,
            .even_y = true,
            .gain = most > 1.0 + 1e-12};
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const auto own_unit = [&](const S& along, Axis a) {
      if (unit() == "cy/mrad") return ctx.frame.cy_per_mrad(along);
      if (unit() == "cy/px") return ctx.frame.cy_per_px(along, a);
      return along;
    };
    const S u = axis.index == 0   ? radius(own_unit(f.x, Axis::x), own_unit(f.y, Axis::y))
                : axis.index == 1 ? own_unit(f.x, Axis::x)
                                  : own_unit(f.y, Axis::y);
    if (curve.weight.empty()) return {lift(evaluate(*curve.curves.front(), value_of(u)), u), S(0)};
    S sum(0), all(0);  // so that it is 1 at zero to the last digit
    each([&](const Curve& one, const S& weight) {
      sum += weight * lift(evaluate(one, value_of(u)), u);
      all += weight;
    });
    return {sum / all, S(0)};
  }
  /// Where a radial curve has come to 0; one along an axis leaves the other.
  double cutoff_cy_mm(const Context<S>& ctx) const { return axis.index == 0 ? value_of(end_cy_mm(ctx)) : kInfinity; }
  /// |f| from which a radial curve is 0; of pixels that are not square, along their shorter side.
  S end_cy_mm(const Context<S>& ctx) const {
    double last = 0.0;
    each([&](const Curve& one, const S&) { last = std::max(last, end_of(one)); });
    const auto end = static_cast<S>(last);
    if (unit() == "cy/mrad") return ctx.frame.cy_mm_from_mrad(end);
    if (unit() == "cy/px")
      return ctx.frame.cy_mm_from_px(end, ctx.frame.pitch_y_um < ctx.frame.pitch_x_um ? Axis::y : Axis::x);
    return end;
  }
  /// The weights have the sum 1.
  double deviation(double, double, const Context<S>&) const {
    double bound = 0.0;
    each([&](const Curve& one, const S& weight) {
      double worst = 1.0;
      for (const double v : one.value) worst = std::max(worst, std::abs(1.0 - v));
      bound += std::abs(value_of(weight)) * worst;
    });
    return bound;
  }
  std::vector<Problem> check(const Context<S>&) const {
    if (curve.curves.empty() || curve.curves.front() == nullptr) return {{.field = "file", .text = "missing"}};
    const Curve& last = **std::ranges::max_element(curve.curves, {}, [](auto& c) { return std::abs(c->value.back()); });
    if (std::abs(last.value.back()) <= 1e-3) return {};
    return {{.error = false,
             .field = "file",
             .text = (last.source.empty() ? std::string("the curve") : last.source) + " ends at " +
                     format_double(last.frequency.back()) + " " + std::string(last.unit->name) + " with MTF " +
                     format_double(last.value.back()) +
                     "; beyond it the curve goes straight on to 0, which it reaches at " + format_double(end_of(last)) +
                     ", so that its MTF there is off by up to " + three_digits(std::abs(last.value.back())) +
                     "; measure it further out"}};
  }

 private:
  std::string_view unit() const { return curve.curves.front()->unit->name; }
  void each(const auto& take) const {
    for (std::size_t i = 0; i < curve.curves.size(); ++i)
      take(*curve.curves[i], curve.weight.empty() ? S(1) : curve.weight[i]);
  }
};

}  // namespace mtf
