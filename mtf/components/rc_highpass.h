// SPDX-License-Identifier: Apache-2.0
#pragma once

// AC coupling of the electronics: a one-pole high-pass along the scan, 1 minus the low-pass of the same cutoff.
//   otf = i u/(1 + i u),  u = f/f0
// f = frequency along the axis, f0 = cutoff: a spatial frequency, or one in time together with the speed that makes
// place of it, scan velocity, scan rate or pixel clock. Complex, the phase is kept: behind a bright point every line
// drops below its mean and recovers with exp(-2 pi f0 x) towards +axis (droop, undershoot). What happens to the mean of
// a line, u = 0 exactly, is the field `dc`. keep: otf = 1 there, DC restoration gives every line its mean back; beside
// that line the otf tends to 0 all the same, i u + O(u^2) from both sides, and the slope at u = 0 is taken as that,
// i/f0. remove: otf = 0 there, the formula itself, and every line has the mean zero. (Lloyd, Thermal Imaging Systems;
// Holst, Electro-Optical Imaging System Performance.)

#include "mtf/components/electronics.h"

namespace mtf {

template <class S>
struct RcHighpass : ElectronicFilter<S> {
  static constexpr std::string_view kind = "rc_highpass";
  static constexpr std::string_view doc = "AC coupling: one-pole electronic high-pass with its phase";
  static constexpr Stages stages{.presample = true, .readout = true};
  static constexpr SensorPart part = SensorPart::electronics;

  static constexpr std::array<std::string_view, 2> kDcNames{"keep", "remove"};
  Choice dc{0, kDcNames};

  static constexpr auto fields() {
    return std::tuple_cat(ElectronicFilter<S>::fields(),
                          std::tuple{optional(&RcHighpass::dc, "dc", "\"keep\"",
                                              "mean of each line along the axis: keep (DC restoration) or remove")});
  }
  bool keeps_mean() const { return dc.index == 0; }
  Traits traits(const Context<S>&) const {
    const bool x = this->axis.index == 0, keep = keeps_mean();
    return {.separable = keep,
            .even_x = !x,
            .even_y = x,
            .flat_x = keep && !x,
            .flat_y = keep && x,
            .real = false,
            .gain = !keep,
            .dc = keep ? 1.0 : 0.0};
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const auto p = this->pair(f, ctx);
    if (p.below_f0()) {
      const S u = p.along / p.f0;
      if (keeps_mean() && value_of(p.along) == 0.0) return {S(1), u};
      const S scale = S(1) / (S(1) + u * u);
      return {S(u * u * scale), S(u * scale)};
    }
    const S v = p.f0 / p.along;  // the same without overflow
    const S scale = S(1) / (S(1) + v * v);
    return {scale, S(v * scale)};
  }
  /// |1 - otf| = 1/sqrt(1 + u^2) is largest beside the zero line.
  double deviation(double fx, double fy, const Context<S>&) const {
    return keeps_mean() && (this->axis.index == 0 ? fx : fy) == 0.0 ? 0.0 : 1.0;
  }
};

}  // namespace mtf
