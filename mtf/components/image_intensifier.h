// SPDX-License-Identifier: Apache-2.0
#pragma once

// Image intensifier or fibre-optic plate, by the two numbers to which Johnson reduced photoelectronic devices.
//   otf = exp(-u^n),  u = |f| / f0
// f0 = frequency at which the MTF is 1/e, n = device index: 1 for long tails of scattered light, 2 for a Gaussian; his
// tables go from 1.0 to 2.0. Frequencies are at the focal plane of the detector: a relay lens or taper of magnification
// M after the device divides f0 by M. Devices in cascade are listed one by one. Real, positive, radial. A fit of two
// numbers to a measured MTF, as good as that fit is; the light that spreads over the whole screen is not in it (list a
// `halo`, or the veiling glare of the radiometry). (Johnson, Appl. Opt. 12, 1031 (1973).)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct ImageIntensifier {
  static constexpr std::string_view kind = "image_intensifier";
  static constexpr std::string_view doc = "image intensifier or fibre-optic plate by frequency and device index";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::detector;

  SpatialFrequency<S> frequency{};
  S index{1};

  static constexpr auto fields() {
    return std::tuple{
        required(&ImageIntensifier::frequency, "frequency", 1e-9, 1e9, "\"30 cy/mm\"",
                 "frequency f0 at which the MTF is 1/e"),
        required(&ImageIntensifier::index, "index", 1.0, 4.0, "1.4", "device index n, 1.0 to 2.0 in Johnson's tables")};
  }
  /// Cycles per pixel of pixels that are not square make circles into ellipses.
  Traits traits(const Context<S>& ctx) const {
    return {.radial = value_of(frequency.cy_mm(ctx.frame, Axis::x)) == value_of(frequency.cy_mm(ctx.frame, Axis::y)),
            .even_x = true,
            .even_y = true};
  }
  /// Value and slopes in double: at f = 0 and at the smallest frequencies 1/u is infinite, u^(n-1) is not.
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S ratio = relative(f, ctx);
    const double u = value_of(ratio), n = value_of(index), power = std::pow(u, n);
    if (u == 0.0) return {S(1), S(0)};
    if (!(power < 1e3)) return {S(0), S(0)};  // exp(-1000) is 0, and so are the slopes
    const double h = std::exp(-power);
    return {lift(h, -n * std::pow(u, n - 1.0) * h, ratio, -power * std::log(u) * h, index), S(0)};
  }
  /// It falls monotonically.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    return -std::expm1(-std::pow(value_of(relative({S(fx), S(fy)}, ctx)), value_of(index)));
  }
  std::vector<Problem> check(const Context<S>&) const {
    if (value_of(index) <= 2.0) return {};
    return {{.error = false,
             .field = "index",
             .text = "a device index of " + three_digits(value_of(index)) +
                     " is beyond those of Johnson's tables, 1.0 to 2.0: no measured device stands behind this MTF"}};
  }

 private:
  S relative(const Freq<S>& f, const Context<S>& ctx) const {
    return radius(S(f.x / frequency.cy_mm(ctx.frame, Axis::x)), S(f.y / frequency.cy_mm(ctx.frame, Axis::y)));
  }
};

}  // namespace mtf
