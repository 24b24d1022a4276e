// SPDX-License-Identifier: Apache-2.0
#pragma once

// Analog boost (aperture correction) of the video signal along one axis.
//   otf = 1 + (K - 1)/2 (1 - cos(pi f/fm))
// f = frequency along the axis, K = gain at its peak, fm = frequency of the peak. Real, at least 1: raises contrast,
// and noise with it; the mean stays. Periodic in 2 fm: it is the filter that adds the difference of the signal to its
// neighbours 1/(2 fm) away; meant for f <= fm. (Holst, Electro-Optical Imaging System Performance.)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct Boost {
  static constexpr std::string_view kind = "boost";
  static constexpr std::string_view doc = "analog boost of high frequencies along one axis";
  static constexpr Stages stages{.readout = true, .postsample = true};
  static constexpr SensorPart part = SensorPart::electronics;

  std::optional<S> gain{};
  SpatialFrequency<S> peak{};
  Choice axis{0, kAxisNames};

  static constexpr auto fields() {
    return std::tuple{required(&Boost::gain, "gain", 1.0, 100.0, "2.0", "otf at the peak frequency"),
                      required(&Boost::peak, "peak", 1e-9, 1e9, "\"0.5 cy/px\"", "frequency of the largest gain"),
                      Field{&Boost::axis, kAxisInfo}};
  }
  Traits traits(const Context<S>&) const {
    const bool x = axis.index == 0;
    return {.separable = true, .even_x = true, .even_y = true, .flat_x = !x, .flat_y = x, .gain = true};
  }
  S extra() const { return gain.value_or(S(1)) - S(1); }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S half_turns = S(0.5) * along(f, axis_of(axis)) / peak.cy_mm(ctx.frame, axis_of(axis));
    const auto [s, c] = sin_cos_pi(value_of(half_turns));
    const bool steep = std::abs(value_of(half_turns)) < 1e15;  // beyond, doubles are whole periods apart: no slope
    return {S(1) + extra() * lift({s * s, steep ? 2.0 * kPi * s * c : 0.0}, half_turns), S(0)};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double x = 0.5 * (axis.index == 0 ? fx : fy) / value_of(peak.cy_mm(ctx.frame, axis_of(axis)));
    const double s = sin_pi(std::min(x, 0.5));
    return value_of(extra()) * s * s;
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    const double nyquists = value_of(ctx.frame.cy_per_px(peak.cy_mm(ctx.frame, axis_of(axis)), axis_of(axis))) / 0.5;
    if (nyquists >= 1.0) return {};
    return {{.error = false,
             .field = "peak",
             .text = "the filter is meant up to its peak, which lies at " + three_digits(nyquists) +
                     " of Nyquist; beyond it the gain falls again"}};
  }
};

}  // namespace mtf
