// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sinusoidal line-of-sight vibration d sin(2 pi s/T + phase) along a direction, s = time from mid exposure.
//   many_cycles:  otf = J0(x),  x = 2 pi d.f
//   fixed_phase:  otf = sum over n of J_n(x) exp(-i n phase) sinc(n c)
//   rms:          otf = sqrt(sum over n of J_n(x)^2 sinc(n c)^2)
// d = amplitude (cos a, sin a), a = direction from +x (right) to +y (down); amplitude is the peak from the middle, rms
// displacement = amplitude/sqrt 2. c = exposure/T = cycles in one exposure, sinc(x) = sin(pi x)/(pi x). many_cycles,
// the default, is the limit of many cycles, and of whole ones; real, its negative lobes (contrast reversal) kept.
// fixed_phase is one exposure; complex. rms is the root mean square of |otf| over all phases: an expectation for
// budgets, not the otf of any one image; real, never negative, |J0| for whole cycles; from x = 2000 on it goes over
// into its leading term, within 2e-4. Separable only along an axis. (Hadar, Fisher, Kopeika, Opt. Eng. 31, 581 (1992);
// Kopeika, A System Engineering Approach to Imaging, ch. 14; Boreman, Modulation Transfer Function in Optical and
// Electro-Optical Systems, ch. 6.)

#include "mtf/components/field.h"
#include "mtf/components/motion_means.h"
#include "mtf/math/special.h"

namespace mtf {

inline constexpr std::array<std::string_view, 3> kVibrationNames{"many_cycles", "fixed_phase", "rms"};

template <class S>
struct Vibration {
  static constexpr std::string_view kind = "vibration";
  static constexpr std::string_view doc =
      "sinusoidal vibration, many cycles in the integration time or any part of them";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::motion;

  AxisPair<S> amplitude{};
  NumberIn<S, degrees> direction_deg{};
  Choice average{0, kVibrationNames};
  std::optional<S> cycles{};
  OptionalIn<S, seconds> period_s{};
  NumberIn<S, degrees> phase_deg{};

  static constexpr auto fields() {
    return std::tuple{
        required(&Vibration::amplitude, "amplitude", 0.0, 1e9, "\"5 um\"",
                 "peak displacement from the middle, half of peak to peak"),
        Field{&Vibration::direction_deg, kDirectionInfo},
        optional(&Vibration::average, "average", "\"fixed_phase\"",
                 "many_cycles, fixed_phase (one exposure) or rms (root mean square over all phases)"),
        excluding("period", optional(&Vibration::cycles, "cycles", 0.0, 1e3, "0.4",
                                     "exposure / period, for fixed_phase and rms; beyond 1000 use many_cycles")),
        excluding("cycles", optional(&Vibration::period_s, "period", "s", 1e-9, 1e9, "\"25 ms\"",
                                     "period of the vibration, with frame.integration_time, instead of cycles")),
        optional(&Vibration::phase_deg, "phase", "deg", -360.0, 360.0, "\"30 deg\"",
                 "fixed_phase: phase at mid exposure; 0: passing the middle towards the direction")};
  }
  bool fixed_phase() const { return average.index == 1; }
  bool many_cycles() const { return average.index == 0; }
  S cycles_in(const Context<S>& ctx) const {
    return cycles ? *cycles : S(ctx.frame.integration_time_s / period_s.value_or(S(1)));
  }
  Freq<S> displacement_mm(const Context<S>& ctx) const {
    const auto [cosine, sine] = unit_vector(direction_deg.value);
    return {amplitude.x_um(ctx.frame) * cosine * S(1e-3), amplitude.y_um(ctx.frame) * sine * S(1e-3)};
  }
  Traits traits(const Context<S>& ctx) const {
    const Freq<S> d = displacement_mm(ctx);
    return motion_traits(value_of(d.y) == 0.0, value_of(d.x) == 0.0, !fixed_phase());
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const Freq<S> d = displacement_mm(ctx);
    const S x = S(2.0 * kPi) * (d.x * f.x + d.y * f.y);
    if (many_cycles()) return {lift(bessel_j0(value_of(x)), x), S(0)};
    const S c = cycles_in(ctx);
    if (!fixed_phase()) {
      const SineRms r = sine_rms(value_of(x), value_of(c));
      return {lift({r.value, r.by_x}, x) + lift({0.0, r.by_cycles}, c), S(0)};
    }
    const S turns = phase_deg.value / S(360);
    const SineMean h = sine_mean(value_of(x), value_of(c), value_of(turns));
    return {lift({h.value.re, h.by_x.re}, x) + lift({0.0, h.by_cycles.re}, c) + lift({0.0, h.by_turns.re}, turns),
            lift({h.value.im, h.by_x.im}, x) + lift({0.0, h.by_cycles.im}, c) + lift({0.0, h.by_turns.im}, turns)};
  }
  /// J0 falls monotonically to its deepest lobe, -0.40276 at 3.83. Any one exposure: no phase beyond x. rms: its square
  /// is the mean cosine of phase differences, whose mean square is at most 2 x^2.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const Freq<S> d = displacement_mm(ctx);
    const double x = 2.0 * kPi * (std::abs(value_of(d.x)) * fx + std::abs(value_of(d.y)) * fy);
    if (many_cycles()) return x < 3.8 ? 1.0 - bessel_j0(x).value : 1.4028;
    if (!fixed_phase()) return std::min(1.0, x * x);
    return x < kPi ? 2.0 * std::sin(0.5 * x) : 2.0;
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    if (amplitude.split)
      return {{.field = "amplitude", .text = "give one amplitude and a direction instead of amplitude_x, amplitude_y"}};
    const char* const given = cycles ? "cycles" : "period";
    if (many_cycles() && (cycles || period_s))
      return {
          {.field = given, .text = "needs average = \"fixed_phase\" or \"rms\"; many_cycles has no number of them"}};
    if (!many_cycles() && cycles.has_value() == period_s.has_value())
      return {{.field = "cycles", .text = "average = \"fixed_phase\" and \"rms\" need either cycles or period"}};
    if (period_s && !(value_of(ctx.frame.integration_time_s) > 0.0))
      return {{.field = "period", .text = "needs frame.integration_time"}};
    if (period_s && value_of(cycles_in(ctx)) > 1e3)
      return {{.field = "period",
               .text = "more than 1000 periods in frame.integration_time: use average = \"many_cycles\""}};
    if (!fixed_phase() && value_of(phase_deg.value) != 0.0)
      return {{.field = "phase", .text = "belongs to average = \"fixed_phase\""}};
    return {};
  }
};

}  // namespace mtf
