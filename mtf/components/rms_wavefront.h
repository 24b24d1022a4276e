// SPDX-License-Identifier: Apache-2.0
#pragma once

// Aberrations known only by their rms wavefront error W (waves): the empirical factor of Hufnagel and Shannon beside
// `diffraction`.
//   otf = max(0, 1 - (W/0.18)^2 [1 - 4 (nu - 1/2)^2]),  nu = |f| lambda N in 0..1;  1 beyond the cutoff
// lambda = wavelength, N = f-number. Real, not negative, radial. W is at `wavelength_reference`: W(lambda) = W x
// reference / lambda in a band. A budget curve for W <= 0.1: measured against exact pupils its error reaches 0.07 (W =
// 0.07, defocus 0.05), 0.15 (W = 0.1, coma) and 0.47 (W = 0.25, astigmatism); from 0.18 on it clips at zero. Use a
// wavefront by coefficients when they are known. (Shannon, The Art and Science of Optical Design, 1997.)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct RmsWavefront {
  static constexpr std::string_view kind = "rms_wavefront";
  static constexpr std::string_view doc = "aberrations by rms wavefront error (Hufnagel/Shannon factor)";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::optics;
  static constexpr double kLimit = 0.18;

  S rms_waves{};
  OptionalIn<S, micrometres> wavelength_reference_um{};
  std::optional<S> f_number{};
  OptionalIn<S, micrometres> wavelength_um{};

  static constexpr auto fields() {
    return std::tuple{required(&RmsWavefront::rms_waves, "rms", 0.0, 1.0, "0.07", "rms wavefront error in waves"),
                      Field{&RmsWavefront::wavelength_reference_um, kWavelengthReferenceInfo},
                      Field{&RmsWavefront::f_number, kFNumberInfo},
                      Field{&RmsWavefront::wavelength_um, kWavelengthInfo}};
  }
  Traits traits(const Context<S>&) const {
    return {.radial = true, .even_x = true, .even_y = true, .chromatic = !wavelength_um};
  }
  S wavelength(const Context<S>& ctx) const { return wavelength_um.value_or(ctx.wavelength_um); }
  S rms_at(const Context<S>& ctx) const { return waves_at(rms_waves, wavelength_reference_um, wavelength(ctx)); }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S nu = relative_frequency(radius(f.x, f.y), wavelength(ctx), f_number_of(f_number, ctx));
    if (!(value_of(nu) < 1.0)) return {S(1), S(0)};
    const S w = rms_at(ctx) / S(kLimit);
    const S factor = S(1) - S(4) * w * w * nu * (S(1) - nu);
    return {value_of(factor) > 0.0 ? factor : S(0), S(0)};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double w = value_of(rms_at(ctx)) / kLimit;
    const double nu = value_of(relative_frequency(S(std::hypot(fx, fy)), wavelength(ctx), f_number_of(f_number, ctx)));
    const double worst = std::min(nu, 0.5);  // nu (1 - nu) is largest at 1/2
    return std::min(1.0, 4.0 * w * w * worst * (1.0 - worst));
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    const double w = value_of(rms_at(ctx));
    if (w <= 0.1) return {};
    return {
        {.error = false,
         .field = "rms",
         .text =
             "rms wavefront error " + format_double(w) +
             " waves is beyond the validity of the Hufnagel/Shannon factor (0.1); its error there exceeds 0.1 in MTF" +
             (w > kLimit ? ", and it is clipped at zero" : "")}};
  }
};

}  // namespace mtf
