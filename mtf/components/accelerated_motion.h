// SPDX-License-Identifier: Apache-2.0
#pragma once

// Image motion of constant acceleration during the integration time t, about mid exposure.
//   otf = (1/t) integral over s = -t/2 ... t/2 of exp(-2 pi i f.x(s)) ds,  x(s) = v s + a s^2/2
// v = velocity of the image at mid exposure, a = its acceleration, both at the focal plane and along one direction,
// from +x (right) to +y (down). A negative acceleration slows the image. Complex: the mean shift a t^2/24 and the
// asymmetry are kept in the phase; a = 0 is `linear_motion`. Separable only along an axis. Valid while the acceleration
// is constant over the integration time. In closed form by Fresnel integrals; the phases pi f.v t and pi f.a t^2/4
// carry the rounding of their products, a few 2^-53 of themselves. (Hadar, Dror, Kopeika, Opt. Eng. 33, 566 (1994).)

#include "mtf/components/field.h"
#include "mtf/components/motion_means.h"

namespace mtf {

template <class S>
struct AcceleratedMotion {
  static constexpr std::string_view kind = "accelerated_motion";
  static constexpr std::string_view doc = "image motion of constant acceleration during the integration time";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::motion;

  OptionalIn<S, micrometres_per_second> velocity_um_s{};
  OptionalIn<S, micrometres_per_second2> acceleration_um_s2{};
  OptionalIn<S, microradians_per_second> rate_urad_s{};
  OptionalIn<S, microradians_per_second2> angular_acceleration_urad_s2{};
  NumberIn<S, degrees> direction_deg{};

  static constexpr auto fields() {
    return std::tuple{
        excluding("rate", optional(&AcceleratedMotion::velocity_um_s, "velocity", "um/s", 0.0, 1e15, "\"0.5 mm/s\"",
                                   "image velocity at the focal plane at mid exposure")),
        optional(&AcceleratedMotion::acceleration_um_s2, "acceleration", "um/s^2", -1e15, 1e15, "\"60 mm/s^2\"",
                 "image acceleration at the focal plane, with velocity; 0 when absent"),
        excluding("velocity", optional(&AcceleratedMotion::rate_urad_s, "rate", "urad/s", 0.0, 1e15, "\"5 mrad/s\"",
                                       "object angle per second at mid exposure, instead of velocity")),
        optional(&AcceleratedMotion::angular_acceleration_urad_s2, "angular_acceleration", "urad/s^2", -1e15, 1e15,
                 "\"600 mrad/s^2\"", "object angle per second squared, with rate; 0 when absent"),
        Field{&AcceleratedMotion::direction_deg, kDirectionInfo}};
  }
  /// v t and a t^2/2, mm.
  struct Lengths {
    S velocity_part, acceleration_part;
  };
  Lengths lengths_mm(const Context<S>& ctx) const {
    const S speed = rate_urad_s ? ctx.frame.um_from_urad(*rate_urad_s) : velocity_um_s.value_or(S(0));
    const S acceleration = rate_urad_s ? ctx.frame.um_from_urad(angular_acceleration_urad_s2.value_or(S(0)))
                                       : acceleration_um_s2.value_or(S(0));
    const S t = ctx.frame.integration_time_s;
    return {speed * t * S(1e-3), acceleration * t * t * S(0.5e-3)};
  }
  Traits traits(const Context<S>& ctx) const {
    const auto [cosine, sine] = unit_vector(direction_deg.value);
    return motion_traits(value_of(sine) == 0.0, value_of(cosine) == 0.0, !accelerated(ctx));
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const auto [cosine, sine] = unit_vector(direction_deg.value);
    const Lengths length = lengths_mm(ctx);
    const S along = cosine * f.x + sine * f.y;
    const S d = along * length.velocity_part, b = along * length.acceleration_part;
    const ChirpMean h = chirp_mean(value_of(d), value_of(b));
    return {lift({h.value.re, h.by_d.re}, d) + lift({0.0, h.by_b.re}, b),
            lift({h.value.im, h.by_d.im}, d) + lift({0.0, h.by_b.im}, b)};
  }
  /// That of sinc(d), and |h(d, b) - sinc(d)| <= mean of 2 pi b s^2 = pi b/6.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const auto [cosine, sine] = unit_vector(direction_deg.value);
    const Lengths length = lengths_mm(ctx);
    const double along = std::abs(value_of(cosine)) * fx + std::abs(value_of(sine)) * fy;
    const double d = along * value_of(length.velocity_part), b = along * std::abs(value_of(length.acceleration_part));
    return std::min(2.0, sinc_deviation(d) + kPi * b / 6.0);
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    if (velocity_um_s.has_value() == rate_urad_s.has_value())
      return {{.field = "velocity", .text = "give either velocity or rate (0 for motion from rest)"}};
    if (rate_urad_s && acceleration_um_s2)
      return {{.field = "acceleration", .text = "belongs to velocity; with rate give angular_acceleration"}};
    if (velocity_um_s && angular_acceleration_urad_s2)
      return {{.field = "angular_acceleration", .text = "belongs to rate; with velocity give acceleration"}};
    if (!(value_of(ctx.frame.integration_time_s) > 0.0))
      return {{.field = velocity_um_s ? "velocity" : "rate", .text = "needs frame.integration_time"}};
    return {};
  }

 private:
  bool accelerated(const Context<S>& ctx) const { return value_of(lengths_mm(ctx).acceleration_part) != 0.0; }
};

}  // namespace mtf
