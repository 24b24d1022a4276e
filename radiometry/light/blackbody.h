// SPDX-License-Identifier: Apache-2.0
#pragma once

// Thermal radiation of a blackbody, with x = c2 / (lambda T), c2 = h c / k:
//   spectral radiance   L  = 2 h c^2 / lambda^5 / (e^x - 1)        W m^-2 sr^-1 um^-1
//   photon radiance     Lq = 2 c / lambda^4 / (e^x - 1)            s^-1 m^-2 sr^-1 um^-1
//   derivative by T     dL/dT = L x / T / (1 - e^-x)
//   in a band           integral of L over the wavelengths [lo, hi]
//     = 2 k^4 T^4 / (h^3 c^2) [B3(x_hi) - B3(x_lo)],   photons 2 k^3 T^3 / (h^3 c^2) [B2(x_hi) - B2(x_lo)],
//       Bp(x) = integral from x to infinity of t^p / (e^t - 1) dt
//         = sum over n >= 1 of e^-nx (x^p/n + p x^(p-1)/n^2 + ... + p!/n^(p+1))
//     (Widger and Woodall, Bull. Am. Meteorol. Soc. 57, 1217 (1976)).
// x is carried in two doubles and nothing cancels, so that the relative error stays below 2e-15 whatever x is, for
// 1 K to 1e9 K and 0.1 um to 1 m. Radiances below the smallest double are 0; the log forms have no such limit.
//
// Temperatures are in kelvin, wavelengths in um. At 0 K every radiance is 0 and its log -infinity; a negative or NaN
// temperature or wavelength gives NaN. The radiance functions carry derivatives by their arguments for ceres::Jet.

#include "mtf/math/special.h"

namespace radiometry {

enum class Flux { watts, photons };

/// A value with its two partial derivatives; what the templates below lift to S.
struct SpectralSlopes {
  double value = 0.0, by_wavelength = 0.0, by_temperature = 0.0;
};
SpectralSlopes planck_slopes(Flux flux, double wavelength_um, double temperature_k);
SpectralSlopes planck_derivative_slopes(Flux flux, double wavelength_um, double temperature_k);
SpectralSlopes log_planck_slopes(Flux flux, double wavelength_um, double temperature_k);

struct BandSlopes {
  double value = 0.0, by_lo = 0.0, by_hi = 0.0, by_temperature = 0.0;
};
BandSlopes band_radiance_slopes(Flux flux, double lo_um, double hi_um, double temperature_k);
BandSlopes band_derivative_slopes(Flux flux, double lo_um, double hi_um, double temperature_k);

struct TemperatureSlopes {
  double value = 0.0, by_wavelength = 0.0, by_radiance = 0.0;
};
TemperatureSlopes brightness_temperature_slopes(Flux flux, double wavelength_um, double radiance);

/// Spectral radiance, W or photons per second, m^-2 sr^-1 um^-1.
template <class S>
S planck(Flux flux, const S& wavelength_um, const S& temperature_k) {
  const auto p = planck_slopes(flux, mtf::value_of(wavelength_um), mtf::value_of(temperature_k));
  return mtf::lift(p.value, p.by_wavelength, wavelength_um, p.by_temperature, temperature_k);
}

/// Its derivative by the temperature, per K.
template <class S>
S planck_derivative(Flux flux, const S& wavelength_um, const S& temperature_k) {
  const auto p = planck_derivative_slopes(flux, mtf::value_of(wavelength_um), mtf::value_of(temperature_k));
  return mtf::lift(p.value, p.by_wavelength, wavelength_um, p.by_temperature, temperature_k);
}

/// Natural logarithm of the spectral radiance.
template <class S>
S log_planck(Flux flux, const S& wavelength_um, const S& temperature_k) {
  const auto p = log_planck_slopes(flux, mtf::value_of(wavelength_um), mtf::value_of(temperature_k));
  return mtf::lift(p.value, p.by_wavelength, wavelength_um, p.by_temperature, temperature_k);
}

/// The temperature in K of the blackbody of that spectral radiance: the inverse of planck. 0 for no radiance, where its
/// derivatives are given as 0; NaN for a negative one.
template <class S>
S brightness_temperature(Flux flux, const S& wavelength_um, const S& radiance) {
  const auto t = brightness_temperature_slopes(flux, mtf::value_of(wavelength_um), mtf::value_of(radiance));
  return mtf::lift(t.value, t.by_wavelength, wavelength_um, t.by_radiance, radiance);
}

/// Radiance in the band [lo, hi], W or photons per second, m^-2 sr^-1. 0 <= lo <= hi; lo may be 0, hi infinite, NaN for
/// others.
template <class S>
S band_radiance(Flux flux, const S& lo_um, const S& hi_um, const S& temperature_k) {
  const auto b = band_radiance_slopes(flux, mtf::value_of(lo_um), mtf::value_of(hi_um), mtf::value_of(temperature_k));
  return mtf::lift(b.value, b.by_lo, lo_um, b.by_hi, hi_um) + mtf::lift({0.0, b.by_temperature}, temperature_k);
}

/// Its derivative by the temperature, per K.
template <class S>
S band_derivative(Flux flux, const S& lo_um, const S& hi_um, const S& temperature_k) {
  const auto b = band_derivative_slopes(flux, mtf::value_of(lo_um), mtf::value_of(hi_um), mtf::value_of(temperature_k));
  return mtf::lift(b.value, b.by_lo, lo_um, b.by_hi, hi_um) + mtf::lift({0.0, b.by_temperature}, temperature_k);
}

/// Natural logarithm of the radiance in a band.
double log_band_radiance(Flux flux, double lo_um, double hi_um, double temperature_k);

/// The temperature in K of the blackbody of that radiance in the band [lo, hi], 0 < lo < hi: the inverse of
/// band_radiance. 0 for no radiance, NaN for a negative one.
double band_temperature(Flux flux, double lo_um, double hi_um, double radiance);

}  // namespace radiometry
