// SPDX-License-Identifier: Apache-2.0
#pragma once

// Constant-velocity image motion during the integration time, about its middle.
//   linear_motion: otf = sinc(d . f),  d = travel (cos a, sin a),  sinc(u) = sin(pi u)/(pi u)
//   flow: otf = sinc(d . f),  d = zoom (x, y) + rotation (-y, x) + shift,  sinc(u) = sin(pi u)/(pi u)
// travel = path at the focal plane, given, or velocity x integration time; a = direction from +x (right) to +y (down).
// flow is that of a sensor that approaches or zooms, turns about its optical axis, and moves: (x, y) = place of the
// pixel from the optical axis on the focal plane; zoom = share by which the image grows, rotation = angle by which it
// turns, from +x to +y, both small against 1; shift = path on the axis, or at each place by an image of the detector,
// displacements = "flow.exr" (mtf/README.md). Real and signed: contrast reverses between the zeros at d . f = 1, 2, ...
// Even in d; separable only along an axis. Valid while velocity and exposure are constant over the integration time.
// (Boreman, Modulation Transfer Function in Optical and Electro-Optical Systems, ch. 6; Kopeika, A System Engineering
// Approach to Imaging, ch. 14; Longuet-Higgins and Prazdny, Proc. R. Soc. Lond. B 208, 385 (1980): fields of image
// motion.)

#include "mtf/components/field.h"

namespace mtf {

/// Of uniform motion by d, and how far from 1 it may be at +-fx, +-fy.
template <class S>
Complex<S> uniform_motion_otf(const Freq<S>& d, const Freq<S>& f) {
  return {sinc_of(S(d.x * f.x + d.y * f.y)), S(0)};
}
template <class S>
double uniform_motion_deviation(const Freq<S>& d, double fx, double fy) {
  return sinc_deviation(std::abs(value_of(d.x)) * fx + std::abs(value_of(d.y)) * fy);
}

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
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const { return uniform_motion_otf(displacement_mm(ctx), f); }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    return uniform_motion_deviation(displacement_mm(ctx), fx, fy);
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

template <class S>
struct Flow {
  static constexpr std::string_view kind = "flow";
  static constexpr std::string_view doc = "image motion that varies over the field: zoom, rotation, shift";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::motion;

  std::optional<S> zoom{};
  OptionalIn<S, microradians> rotation_urad{};
  AxisPair<S> shift{};

  static constexpr auto fields() {
    return std::tuple{
        optional(&Flow::zoom, "zoom", -1.0, 1.0, "0.004", "share by which the image grows in one integration time"),
        optional(&Flow::rotation_urad, "rotation", "urad", -1e6, 1e6, "\"2 mrad\"",
                 "turn about the optical axis in one integration time, from +x (right) to +y (down)"),
        optional(&Flow::shift, "shift", -1e9, 1e9, "\"2 px\"", "shift in one integration time, along each axis")};
  }
  Freq<S> displacement_mm(const Context<S>& ctx) const {
    const S x = ctx.place.x_um * S(1e-3), y = ctx.place.y_um * S(1e-3), grown = zoom.value_or(S(0)),
            turned = rotation_urad.value_or(S(0)) * S(1e-6);
    Freq<S> d{grown * x - turned * y, grown * y + turned * x};
    if (shift.given()) d = {d.x + shift.x_um(ctx.frame) * S(1e-3), d.y + shift.y_um(ctx.frame) * S(1e-3)};
    return d;
  }
  Traits traits(const Context<S>& ctx) const {
    const Freq<S> d = displacement_mm(ctx);
    Traits traits = motion_traits(value_of(d.y) == 0.0, value_of(d.x) == 0.0, true);
    traits.placed = value_of(zoom.value_or(S(0))) != 0.0 || value_of(rotation_urad.value_or(S(0))) != 0.0;
    return traits;
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const { return uniform_motion_otf(displacement_mm(ctx), f); }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    return uniform_motion_deviation(displacement_mm(ctx), fx, fy);
  }
  std::vector<Problem> check(const Context<S>&) const {
    if (zoom || rotation_urad || shift.given()) return {};
    return {{.field = "zoom", .text = "give one of zoom, rotation, shift at least"}};
  }
};

}  // namespace mtf
