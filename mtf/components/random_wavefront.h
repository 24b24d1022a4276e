// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random wavefront error, Gaussian with a Gaussian correlation, averaged over its realisations.
//   otf = exp(-s^2 [1 - exp(-(lambda u / L)^2)]),  s = 2 pi W
// W = rms wavefront error in waves at lambda, lambda = wavelength, lambda u = separation in the pupil, u = |f| x focal
// length in cycles/rad, L = correlation length, as a length in the pupil or as a fraction of the aperture. Real,
// positive, radial; multiplies `diffraction`. It does not go to 0: the fraction exp(-s^2) of the light stays in the
// sharp core. W is at `wavelength_reference`: W(lambda) = W x reference / lambda. Valid for L well below the aperture
// (polishing errors, boundary layers), say a quarter of it: of the variance of longer waves much is piston, which blurs
// nothing; a budget of known aberrations is `rms_wavefront`. (O'Neill, Introduction to
// Statistical Optics; equation 3-31 of the IBSM as pyBSM quotes it.)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct RandomWavefront {
  static constexpr std::string_view kind = "random_wavefront";
  static constexpr std::string_view doc = "random wavefront error by rms and correlation length";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::optics;

  S rms_waves{};
  OptionalIn<S, micrometres> wavelength_reference_um{};
  std::optional<S> correlation{};
  OptionalIn<S, millimetres> correlation_length_mm{};
  OptionalIn<S, millimetres> aperture_mm{};
  OptionalIn<S, micrometres> wavelength_um{};

  static constexpr auto fields() {
    return std::tuple{
        required(&RandomWavefront::rms_waves, "rms", 0.0, 10.0, "0.1", "rms wavefront error in waves"),
        optional(&RandomWavefront::wavelength_reference_um, "wavelength_reference", "um", 0.01, 1e5, "\"3.39 um\"",
                 "wavelength at which rms is stated; without it rms holds at every wavelength"),
        excluding("correlation_length", optional(&RandomWavefront::correlation, "correlation", 1e-6, 1e6, "0.2",
                                                 "correlation length as a fraction of the aperture")),
        excluding("correlation",
                  optional(&RandomWavefront::correlation_length_mm, "correlation_length", "mm", 1e-6, 1e9, "\"8 mm\"",
                           "correlation length in the entrance pupil, instead of correlation")),
        shared(&RandomWavefront::aperture_mm, "aperture", "mm", 1e-3, 1e6, "\"50 mm\"",
               "entrance pupil diameter, for correlation; otherwise focal length / f_number"),
        Field{&RandomWavefront::wavelength_um, kWavelengthInfo}};
  }
  Traits traits(const Context<S>&) const {
    return {.radial = true, .even_x = true, .even_y = true, .chromatic = !wavelength_um};
  }
  S wavelength(const Context<S>& ctx) const { return wavelength_um.value_or(ctx.wavelength_um); }
  S phase_rad(const Context<S>& ctx) const {
    return S(2.0 * kPi) * waves_at(rms_waves, wavelength_reference_um, wavelength(ctx));
  }
  S length_mm(const Context<S>& ctx) const {
    return correlation_length_mm ? *correlation_length_mm
                                 : S(correlation.value_or(S(1)) * aperture_of(aperture_mm, ctx));
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S s = phase_rad(ctx),
            q = radius(f.x, f.y) * (ctx.frame.focal_length_mm * wavelength(ctx) * S(1e-3)) / length_mm(ctx);
    const double sv = value_of(s), qv = value_of(q), far = qv < 27.0 ? std::exp(-qv * qv) : 0.0;
    const double lost = qv < 27.0 ? -std::expm1(-qv * qv) : 1.0, h = std::exp(-sv * sv * lost);
    return {lift({h, -2.0 * sv * lost * h}, s) + lift({0.0, far == 0.0 ? 0.0 : -2.0 * sv * sv * qv * far * h}, q),
            S(0)};
  }
  /// The otf falls monotonically.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double s = value_of(phase_rad(ctx));
    const double q = std::hypot(fx, fy) * value_of(ctx.frame.focal_length_mm) * value_of(wavelength(ctx)) * 1e-3 /
                     value_of(length_mm(ctx));
    return -std::expm1(s * s * std::expm1(-q * q));
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    if (correlation.has_value() == correlation_length_mm.has_value())
      return {{.field = "correlation", .text = "give either correlation or correlation_length"}};
    if (correlation && !(value_of(aperture_of(aperture_mm, ctx)) > 0.0))
      return {{.field = "aperture", .text = "missing; correlation needs it here or in [optics]"}};
    const double share = value_of(length_mm(ctx)) / value_of(aperture_of(aperture_mm, ctx));
    if (!(share > 0.25 && share < kInfinity)) return {};  // infinite: the aperture is not known
    return {{.error = false,
             .field = correlation ? "correlation" : "correlation_length",
             .text = "a correlation length of " + three_digits(share) +
                     " of the aperture is beyond the validity of the formula, which is for lengths well below it (a "
                     "quarter at most); much of such an error is piston and tilt, which do not blur"}};
  }
};

}  // namespace mtf
