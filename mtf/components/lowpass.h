// SPDX-License-Identifier: Apache-2.0
#pragma once

// Low-pass filters of the electronics behind a scanned or serially read detector, in time, along the scan.
//   rc_lowpass:   otf = 1/(1 + i f/f0)
//   butterworth:  otf = 1/sqrt(1 + (f/f0)^(2n))
// f = frequency along the axis, f0 = cutoff: a spatial frequency, or one in time together with the speed that makes
// place of it, scan velocity, scan rate or pixel clock; n = number of poles. rc_lowpass is causal and complex: the tail
// of a point trails towards +axis, where time runs, and the phase is kept. butterworth is real and positive: the
// modulus of an n-pole filter, its phase taken out (linear-phase reading). (Lloyd, Thermal Imaging Systems; Holst,
// Electro-Optical Imaging System Performance.)

#include "mtf/components/electronics.h"

namespace mtf {

template <class S>
struct RcLowpass : ElectronicFilter<S> {
  static constexpr std::string_view kind = "rc_lowpass";
  static constexpr std::string_view doc = "one-pole electronic low-pass with its phase";
  static constexpr Stages stages{.presample = true, .readout = true};
  static constexpr SensorPart part = SensorPart::electronics;

  Traits traits(const Context<S>&) const { return axis_traits(this->axis, false); }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const auto p = this->pair(f, ctx);
    if (p.below_f0()) {
      const S u = p.along / p.f0;
      const S scale = S(1) / (S(1) + u * u);
      return {scale, S(-u * scale)};
    }
    const S v = p.f0 / p.along;  // the same without overflow
    const S scale = S(1) / (S(1) + v * v);
    return {S(v * v * scale), S(-v * scale)};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double u = this->pair({S(fx), S(fy)}, ctx).ratio();
    return u < 1e150 ? u / std::sqrt(1.0 + u * u) : 1.0;
  }
};

template <class S>
struct Butterworth : ElectronicFilter<S> {
  static constexpr std::string_view kind = "butterworth";
  static constexpr std::string_view doc = "Butterworth low-pass of n poles, modulus only";
  static constexpr Stages stages{.presample = true, .readout = true};
  static constexpr SensorPart part = SensorPart::electronics;

  int poles = 0;

  static constexpr auto fields() {
    return std::tuple_cat(ElectronicFilter<S>::fields(),
                          std::tuple{required(&Butterworth::poles, "poles", 1.0, 20.0, "3", "number of poles")});
  }
  Traits traits(const Context<S>&) const { return axis_traits(this->axis, true); }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const auto p = this->pair(f, ctx);
    if (!(p.ratio() < 1e100)) return {S(std::pow(p.ratio(), -1.0 * poles)), S(0)};  // no slope left that matters
    const S ratio = p.along / p.f0;
    return {lift(modulus(value_of(ratio)), ratio), S(0)};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    return 1.0 - modulus(this->pair({S(fx), S(fy)}, ctx).ratio()).value;
  }

 private:
  ValueSlope modulus(double u) const {
    if (u == 0.0) return {1.0, 0.0};
    const double power = std::pow(std::abs(u), 2.0 * poles);
    if (!(power < kInfinity)) return {std::pow(std::abs(u), -1.0 * poles), 0.0};
    const double value = 1.0 / std::sqrt(1.0 + power);
    return {value, -poles * (power / (1.0 + power)) * value / u};
  }
};

}  // namespace mtf
