// SPDX-License-Identifier: Apache-2.0
#pragma once

// Filters of the electronics behind a scanned or serially read detector act in time, along the scan: in the image, on
// the frequency along one axis. Their cutoff f0 is given as a spatial frequency, or in time together with what makes
// place of it,
//   f_t = f x scan velocity (at the focal plane) = f x focal length x scan rate = f x pitch x pixel clock.
// Time runs towards +axis. (Lloyd, Thermal Imaging Systems; Holst, Electro-Optical Imaging System Performance.)

#include "mtf/components/field.h"

namespace mtf {

/// The fields and the argument u = f/f0 of every such filter.
template <class S>
struct ElectronicFilter {
  SpatialFrequency<S> cutoff{};
  OptionalIn<S, micrometres_per_second> scan_velocity_um_s{};
  OptionalIn<S, microradians_per_second> scan_rate_urad_s{};
  OptionalIn<S, hertz> pixel_clock_hz{};
  Choice axis{0, kAxisNames};

  static constexpr auto fields() {
    using T = ElectronicFilter;
    return std::tuple{
        required(&T::cutoff, "cutoff", Dimension::cutoff, "", 1e-9, 1e9, "\"40 cy/mm\"",
                 "frequency where the modulus is 1/sqrt(2); in time (\"400 kHz\") with one of scan_velocity, "
                 "scan_rate, pixel_clock"),
        excluding("scan_rate pixel_clock", optional(&T::scan_velocity_um_s, "scan_velocity", "um/s", 1e-3, 1e15,
                                                    "\"10 m/s\"", "speed of the scan over the focal plane")),
        excluding("scan_velocity pixel_clock", optional(&T::scan_rate_urad_s, "scan_rate", "urad/s", 1e-3, 1e15,
                                                        "\"100 rad/s\"", "object angle scanned per second")),
        excluding("scan_velocity scan_rate", optional(&T::pixel_clock_hz, "pixel_clock", "Hz", 1e-3, 1e15, "\"10 MHz\"",
                                                      "pixels read per second along the axis, one after the other")),
        Field{&T::axis, kAxisInfo}};
  }

  /// Frequency along the axis, and f0 there, both in cy/mm.
  struct Pair {
    S along;
    S f0;
    bool below_f0() const { return std::abs(value_of(along)) <= value_of(f0); }
    double ratio() const { return std::abs(value_of(along)) / value_of(f0); }
  };
  Pair pair(const Freq<S>& f, const Context<S>& ctx) const {
    const Axis a = axis_of(axis);
    return {along(f, a), cutoff.cy_mm(ctx.frame, a, {scan_velocity_um_s, scan_rate_urad_s, pixel_clock_hz})};
  }
  std::vector<Problem> check(const Context<S>&) const {
    const Scan<S> scan{scan_velocity_um_s, scan_rate_urad_s, pixel_clock_hz};
    const char* given = scan_velocity_um_s ? "scan_velocity" : scan_rate_urad_s ? "scan_rate" : "pixel_clock";
    if (cutoff.temporal() && scan.given() == 0)
      return {{.field = "cutoff",
               .text = "in " + std::string(cutoff.unit->name) +
                       ", a frequency in time; give also one of scan_velocity, scan_rate, pixel_clock, or write the "
                       "cutoff as a spatial frequency such as \"40 cy/mm\""}};
    if (scan.given() > 1)
      return {{.field = given, .text = "give exactly one of scan_velocity, scan_rate, pixel_clock"}};
    if (!cutoff.temporal() && scan.given() == 1)
      return {{.field = given,
               .text = "without use, because the cutoff is a spatial frequency; remove it, or write the cutoff as a "
                       "frequency in time such as \"400 kHz\""}};
    return {};
  }
};

}  // namespace mtf
