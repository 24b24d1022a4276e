// SPDX-License-Identifier: Apache-2.0
#pragma once

// The exponent x = c2 / (lambda T) of Planck's law, to twice the digits of a double: its rounding error times x would
// be the relative error of e^-x.

#include <cmath>
#include <limits>

#include "radiometry/light/blackbody.h"
#include "radiometry/light/constants.h"

namespace radiometry {

/// About the largest temperature whose fourth power a double can hold.
inline constexpr double kHottest_k = 1e77;
inline constexpr double kInf = std::numeric_limits<double>::infinity();

struct Exponent {
  double x = 0.0, rest = 0.0;  ///< c2 / (lambda T) = x + rest
};

inline Exponent exponent(double wavelength_um, double temperature_k) {
  const double product = wavelength_um * temperature_k;
  const double product_rest = std::fma(wavelength_um, temperature_k, -product);
  const double x = kSecondRadiation_um_k / product;
  if (!std::isfinite(x) || x == 0.0) return {x, 0.0};
  const double remainder = std::fma(-x, product, kSecondRadiation_um_k);
  return {x, (remainder + (kSecondRadiationRest_um_k - x * product_rest)) / product};
}

/// The product factor e^-x, which underflows only where the product itself does.
inline double times_exp(double factor, const Exponent& x) {
  const double half = std::exp(-0.5 * x.x);
  return half == 0.0 ? 0.0 : factor * half * half * (1.0 - x.rest);
}

/// x / (1 - e^-x), which is d log L / d log T.
inline double log_slope(double x) { return x == 0.0 ? 1.0 : x / -std::expm1(-x); }

/// 2 k^4 / (h^3 c^2) in W m^-2 sr^-1 K^-4, or 2 k^3 / (h^3 c^2) in s^-1 m^-2 sr^-1 K^-3.
inline double band_factor(Flux flux) {
  return flux == Flux::watts ? 2.779416505426625384960e-9 : 2.013123180059975696183e14;
}

/// True for T > 0. At 0 K every radiance is 0; below it, and for NaN, it is NaN.
inline bool radiates(double temperature_k) { return temperature_k > 0.0; }
inline double no_radiance(double temperature_k) { return temperature_k == 0.0 ? 0.0 : std::nan(""); }

}  // namespace radiometry
