// SPDX-License-Identifier: Apache-2.0
#pragma once

// Time delay and integration: N stages along one axis whose charge does not quite keep up with the image.
//   otf = sin(N pi f d) / (N sin(pi f d)) x sinc(f p / M),  sinc(x) = sin(pi x)/(pi x)
// f = frequency along the axis, d = slip of image against charge per stage, p = pitch. The last factor is the stepwise
// motion of the charge, M clock phases a pitch, under an image that moves evenly; clock_phases = 0 leaves it out. Real
// and signed: measured from the middle of the stages. One stage without clock phases is 1. Valid for a slip that is the
// same at every stage. (Johnson, Appl. Opt. 32, 6503 (1993); Holst, CMOS/CCD Sensors and Camera Systems.)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct Tdi {
  static constexpr std::string_view kind = "tdi";
  static constexpr std::string_view doc = "time delay and integration with slip and clock phases";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::detector;

  int stage_count = 0;
  AxisPair<S> slip{};
  int clock_phases = 0;
  Choice axis{0, kAxisNames};

  static constexpr auto fields() {
    return std::tuple{
        required(&Tdi::stage_count, "stages", 1.0, 1e5, "32", "number of stages"),
        required(&Tdi::slip, "slip", 0.0, 1e9, "\"0.34 um\"", "displacement of the image against the charge per stage"),
        optional(&Tdi::clock_phases, "clock_phases", 0.0, 100.0, "3",
                 "charge steps per pitch; 0: motion of the charge taken as even"),
        Field{&Tdi::axis, kAxisInfo}};
  }
  S slip_mm(const Context<S>& ctx) const {
    return (axis.index == 0 ? slip.x_um(ctx.frame) : slip.y_um(ctx.frame)) * S(1e-3);
  }
  S step_mm(const Context<S>& ctx) const {
    return clock_phases == 0 ? S(0) : S(ctx.frame.pitch_um(axis_of(axis)) * S(1e-3 / clock_phases));
  }
  Traits traits(const Context<S>&) const { return axis_traits(axis, true); }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S& u = along(f, axis_of(axis));
    const S x = slip_mm(ctx) * u;
    return {dirichlet_of(stage_count, x) * sinc_of(S(step_mm(ctx) * u)), S(0)};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double f = axis.index == 0 ? fx : fy;
    return std::min(
        2.0, dirichlet_deviation(stage_count, value_of(slip_mm(ctx)) * f) + sinc_deviation(value_of(step_mm(ctx)) * f));
  }
  std::vector<Problem> check(const Context<S>&) const {
    if (slip.split) return {{.field = "slip", .text = "give one slip and an axis instead of slip_x, slip_y"}};
    return {};
  }
};

}  // namespace mtf
