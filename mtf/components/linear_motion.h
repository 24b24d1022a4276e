// SPDX-License-Identifier: Apache-2.0
#pragma once

// Constant-velocity image motion during the integration time, about its middle.
//   otf = sinc(d . f),  d = travel (cos a, sin a),  sinc(x) = sin(pi x)/(pi x)
// travel = path at the focal plane, given, or velocity x integration time; a = direction from +x (right) to +y (down).
// Real and signed: contrast reverses between the zeros at d . f = 1, 2, ... Even in d; separable only along an axis.
// Valid while velocity and exposure are constant over the integration time. (Boreman, Modulation Transfer Function in
// Optical and Electro-Optical Systems, ch. 6; Kopeika, A System Engineering Approach to Imaging, ch. 14.)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct LinearMotion {
  static constexpr std::string_view kind = "linear_motion";
  static constexpr std::string_view doc = "constant-velocity image motion during the integration time";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::motion;

  AxisPair<S> travel{};
  OptionalIn<S, micrometres_per_second> velocity_um_s{};
  OptionalIn<S, microradians_per_second> rate_urad_s{};
  NumberIn<S, degrees> direction_deg{};

  static constexpr auto fields() {
    return std::tuple{
        excluding("velocity rate", optional(&LinearMotion::travel, "travel", 0.0, 1e9, "\"10 um\"",
                                            "distance moved in one integration time")),
        excluding("travel rate",
                  optional(&LinearMotion::velocity_um_s, "velocity", "um/s", 0.0, 1e15, "\"2 mm/s\"",
                           "image velocity at the focal plane, times frame.integration_time, instead of travel")),
        excluding("travel velocity",
                  optional(&LinearMotion::rate_urad_s, "rate", "urad/s", 0.0, 1e15, "\"20 mrad/s\"",
                           "object angle per second, times frame.integration_time, instead of travel")),
        Field{&LinearMotion::direction_deg, kDirectionInfo}};
  }
  Freq<S> displacement_mm(const Context<S>& ctx) const {
    const auto [cosine, sine] = unit_vector(direction_deg.value);
    if (travel.given()) return {travel.x_um(ctx.frame) * cosine * S(1e-3), travel.y_um(ctx.frame) * sine * S(1e-3)};
    const S speed = velocity_um_s ? *velocity_um_s : ctx.frame.um_from_urad(rate_urad_s.value_or(S(0)));
    const S length = speed * ctx.frame.integration_time_s * S(1e-3);
    return {length * cosine, length * sine};
  }
  Traits traits(const Context<S>& ctx) const {
    const Freq<S> d = displacement_mm(ctx);
    return motion_traits(value_of(d.y) == 0.0, value_of(d.x) == 0.0, true);
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const Freq<S> d = displacement_mm(ctx);
    return {sinc_of(S(d.x * f.x + d.y * f.y)), S(0)};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const Freq<S> d = displacement_mm(ctx);
    return sinc_deviation(std::abs(value_of(d.x)) * fx + std::abs(value_of(d.y)) * fy);
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    if (travel.given() + velocity_um_s.has_value() + rate_urad_s.has_value() != 1)
      return {{.field = "travel", .text = "give exactly one of travel, velocity, rate"}};
    if (travel.split)
      return {{.field = "travel", .text = "give one travel and a direction instead of travel_x, travel_y"}};
    if (!travel.given() && !(value_of(ctx.frame.integration_time_s) > 0.0))
      return {{.field = velocity_um_s ? "velocity" : "rate", .text = "needs frame.integration_time"}};
    return {};
  }
};

}  // namespace mtf
