// SPDX-License-Identifier: Apache-2.0
#pragma once

// Thermal time constant of a bolometer under an image that moves at constant speed: its signal is the past of the
// image, weighted with exp(-t/tau)/tau.
//   otf = 1/(1 - 2 pi i f v tau)
// f = frequency along the axis, v = velocity of the image towards +axis (negative: the other way), tau = time constant.
// Complex: the tail lies behind the moving image, towards -axis for v > 0; the phase, a mean lag of v tau, is kept.
// Steady motion only; the sampling of the frame readout in time is not part of it. (Kruse and Skatrud, Uncooled
// Infrared Imaging Arrays and Systems.)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct Bolometer {
  static constexpr std::string_view kind = "bolometer";
  static constexpr std::string_view doc = "thermal time constant of a bolometer under image motion";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::detector;

  NumberIn<S, seconds> time_constant_s{};
  OptionalIn<S, micrometres_per_second> velocity_um_s{};
  OptionalIn<S, microradians_per_second> rate_urad_s{};
  Choice axis{0, kAxisNames};

  static constexpr auto fields() {
    return std::tuple{
        required(&Bolometer::time_constant_s, "time_constant", "s", 0.0, 1e3, "\"10 ms\"", "thermal time constant"),
        excluding("rate", optional(&Bolometer::velocity_um_s, "velocity", "um/s", -1e12, 1e12, "\"0.5 mm/s\"",
                                   "velocity of the image on the focal plane towards +axis")),
        excluding("velocity", optional(&Bolometer::rate_urad_s, "rate", "urad/s", -1e12, 1e12, "\"20 mrad/s\"",
                                       "object angle per second towards +axis, instead of velocity")),
        Field{&Bolometer::axis, kAxisInfo}};
  }
  Traits traits(const Context<S>&) const { return axis_traits(axis, false); }
  S lag_mm(const Context<S>& ctx) const {
    const S speed = velocity_um_s ? *velocity_um_s : ctx.frame.um_from_urad(rate_urad_s.value_or(S(0)));
    return speed * time_constant_s.value * S(1e-3);
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S x = lag_mm(ctx) * along(f, axis_of(axis));
    const double u = 2.0 * kPi * value_of(x);
    if (!(std::abs(u) < 1e150)) return {S(0), S(std::isfinite(u) ? 1.0 / u : 0.0)};
    const double scale = 1.0 / (1.0 + u * u);
    return {lift({scale, -4.0 * kPi * (u * scale) * scale}, x),
            lift({u * scale, 2.0 * kPi * ((1.0 - u) * scale) * ((1.0 + u) * scale)}, x)};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double u = 2.0 * kPi * std::abs(value_of(lag_mm(ctx))) * (axis.index == 0 ? fx : fy);
    return u < 1e150 ? u / std::sqrt(1.0 + u * u) : 1.0;
  }
  std::vector<Problem> check(const Context<S>&) const {
    if (velocity_um_s.has_value() == rate_urad_s.has_value())
      return {{.field = "velocity", .text = "give either velocity or rate"}};
    return {};
  }
};

}  // namespace mtf
