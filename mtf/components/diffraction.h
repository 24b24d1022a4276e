// SPDX-License-Identifier: Apache-2.0
#pragma once

// Diffraction of an aberration-free circular or annular pupil in incoherent light.
//   otf = M(nu, e),  nu = |f| lambda N;  0 from |f| = 1/(lambda N) on
//   M(nu, 0) = (2/pi) [acos nu - nu sqrt(1 - nu^2)]
//   M(nu, e) = [A(1, 1) - 2 A(1, e) + A(e, e)] / (pi (1 - e^2))
// A(R, r) = overlap area of circles of radius R and r with centres 2 nu apart, e = central obscuration (inner / outer
// diameter), lambda = wavelength of the band's node, or the component's own, N = f-number, focal length / aperture.
// Real, not negative, radial. Valid in the paraxial, isoplanatic image of a distant scene. (Goodman, Introduction to
// Fourier Optics, ch. 6; O'Neill, J. Opt. Soc. Am. 46, 285 (1956).)

#include "mtf/components/field.h"
#include "mtf/components/pupil/pupil.h"

namespace mtf {

template <class S>
struct Diffraction {
  static constexpr std::string_view kind = "diffraction";
  static constexpr std::string_view doc = "diffraction of a clear circular or annular pupil";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::optics;
  static constexpr bool is_pupil = true;

  std::optional<S> f_number{};
  std::optional<S> obscuration{};
  OptionalIn<S, micrometres> wavelength_um{};

  static constexpr auto fields() {
    return std::tuple{Field{&Diffraction::f_number, kFNumberInfo}, Field{&Diffraction::obscuration, kObscurationInfo},
                      Field{&Diffraction::wavelength_um, kWavelengthInfo}};
  }
  Traits traits(const Context<S>&) const {
    return {.radial = true, .even_x = true, .even_y = true, .chromatic = !wavelength_um};
  }
  S nu(const S& f_cy_mm, const Context<S>& ctx) const {
    return relative_frequency(f_cy_mm, wavelength_um.value_or(ctx.wavelength_um), f_number_of(f_number, ctx));
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S v = nu(radius(f.x, f.y), ctx);
    const S e = obscuration_of(obscuration, ctx);
    const PupilMtf m = annular_pupil_mtf(value_of(v), value_of(e));
    return {lift(m.value, m.d_nu, v, m.d_obscuration, e), S(0)};
  }
  double cutoff_cy_mm(const Context<S>& ctx) const { return 1.0 / value_of(nu(S(1), ctx)); }
  std::vector<double> kinks_cy_mm(const Context<S>& ctx) const {
    return pupil_kinks(value_of(obscuration_of(obscuration, ctx)), cutoff_cy_mm(ctx));
  }
  /// Clear pupil: the MTF falls monotonically. Annular: |1 - M| <= 1 is all that is cheap and true.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    if (value_of(obscuration_of(obscuration, ctx)) > 0.0) return 1.0;
    return 1.0 - circular_pupil_mtf(value_of(nu(S(std::hypot(fx, fy)), ctx))).value;
  }
};

}  // namespace mtf
