// SPDX-License-Identifier: Apache-2.0
#pragma once

// Charge-transfer inefficiency of a CCD read along one axis: each of N transfers leaves a fraction e of the packet to
// the next one behind it.
//   otf = exp(-N e (1 - exp(-2 pi i f p)))
// f = frequency along the axis, p = its pitch. N counts clock phases: pixels x phases (+ TDI stages). Complex: what is
// left behind trails towards +axis (the output lies towards -axis); the phase, a mean shift of N e pixels, is kept.
// Periodic in the sampling frequency. The leading term of a binomial spread, ((1 - e)/(1 - e exp(-2 pi i f p)))^N, for
// e << 1: what it leaves out changes the otf by at most N e^2, in parts of itself. (Boreman, Modulation Transfer
// Function in Optical and Electro-Optical Systems, ch. 2.)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct ChargeTransfer {
  static constexpr std::string_view kind = "charge_transfer";
  static constexpr std::string_view doc = "charge-transfer inefficiency of a CCD, with its phase";
  static constexpr Stages stages{.readout = true};
  static constexpr SensorPart part = SensorPart::detector;

  S inefficiency{};
  int transfers = 0;
  Choice axis{0, kAxisNames};

  static constexpr auto fields() {
    return std::tuple{required(&ChargeTransfer::inefficiency, "inefficiency", 0.0, 0.1, "1e-5",
                               "fraction of the charge left behind by one transfer, 1 - CTE"),
                      required(&ChargeTransfer::transfers, "transfers", 0.0, 1e6, "1000",
                               "number of transfers to the output: pixels x clock phases"),
                      Field{&ChargeTransfer::axis, kAxisInfo}};
  }
  Traits traits(const Context<S>&) const { return axis_traits(axis, false); }
  S loss() const { return inefficiency * S(static_cast<double>(transfers)); }
  /// 1 - exp(-i t) = 2 sin^2(t/2) + i sin t, without cancellation at small t.
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S x = ctx.frame.cy_per_px(along(f, axis_of(axis)), axis_of(axis));
    const auto [s, c] = sin_cos_pi(value_of(x));
    const double sin_2 = 2.0 * s * c, cos_2 = (c - s) * (c + s);
    const S lost = lift({2.0 * s * s, 2.0 * kPi * sin_2}, x) * loss();
    const double modulus = std::exp(-value_of(lost));
    const Complex<S> phase = phase_of(S(lift({sin_2 / kPi, 2.0 * cos_2}, x) * loss()));
    const S scale = lift({modulus, -modulus}, lost);
    return {scale * phase.re, scale * phase.im};
  }
  /// |1 - exp(-z)| <= |z| where Re z >= 0.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double x = (axis.index == 0 ? fx : fy) * value_of(ctx.frame.pitch_um(axis_of(axis))) * 1e-3;
    return std::min(2.0, 2.0 * value_of(loss()) * sin_pi(std::min(x, 0.5)));
  }
  std::vector<Problem> check(const Context<S>&) const {
    const double left_out = value_of(loss() * inefficiency);
    if (left_out <= 1e-3) return {};
    return {{.error = false,
             .field = "inefficiency",
             .text = "the formula holds for a small inefficiency; at this one its OTF is off by up to " +
                     three_digits(left_out) + " of itself (transfers x inefficiency^2)"}};
  }
};

}  // namespace mtf
