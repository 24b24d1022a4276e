// SPDX-License-Identifier: Apache-2.0
#include "radiometry/light/blackbody.h"

#include "radiometry/light/exponent.h"

namespace radiometry {
namespace {

/// From here on e^x - 1 = e^x, long before either overflows.
constexpr double kLargeExponent = 600.0;

struct SpectralLaw {
  double factor;  // 2 h c^2 or 2 c, for wavelengths in um
  int power;      // of the wavelength
};
SpectralLaw spectral_law(Flux flux) {
  return flux == Flux::watts ? SpectralLaw{119104297.2397188414, 5} : SpectralLaw{5.99584916e26, 4};
}

double prefactor(const SpectralLaw& law, double wavelength_um) {
  return law.factor * std::pow(wavelength_um, -law.power);
}

}  // namespace

SpectralSlopes planck_slopes(Flux flux, double wavelength_um, double temperature_k) {
  if (!(wavelength_um > 0.0)) return {std::nan(""), 0.0, std::nan("")};
  if (!radiates(temperature_k)) return {no_radiance(temperature_k), 0.0, no_radiance(temperature_k)};
  const SpectralLaw law = spectral_law(flux);
  const Exponent x = exponent(wavelength_um, temperature_k);
  const double factor = prefactor(law, wavelength_um), g = log_slope(x.x);
  const double log_by_wavelength = (g - law.power) / wavelength_um, log_by_temperature = g / temperature_k;
  if (x.x >= kLargeExponent)  // each product by itself, since a value that has underflowed gives no slopes
    return {times_exp(factor, x), times_exp(factor * log_by_wavelength, x), times_exp(factor * log_by_temperature, x)};
  const double e = std::expm1(x.x), value = factor / e * (1.0 - x.rest * (1.0 + 1.0 / e));
  return {value, value * log_by_wavelength, value * log_by_temperature};
}

SpectralSlopes planck_derivative_slopes(Flux flux, double wavelength_um, double temperature_k) {
  const SpectralSlopes p = planck_slopes(flux, wavelength_um, temperature_k);
  if (!(p.by_temperature > 0.0)) return {p.by_temperature, 0.0, 0.0};
  // d log g / d log x = 1 - h with h = x / (e^x - 1); g = x + h.
  const double x = exponent(wavelength_um, temperature_k).x, g = log_slope(x), h = g - x > 0.0 ? g - x : 0.0;
  const double value = p.by_temperature;
  return {value, value * (g + h - 1.0 - spectral_law(flux).power) / wavelength_um,
          value * (g + h - 2.0) / temperature_k};
}

SpectralSlopes log_planck_slopes(Flux flux, double wavelength_um, double temperature_k) {
  if (!(wavelength_um > 0.0)) return {std::nan(""), 0.0, 0.0};
  if (!radiates(temperature_k)) return {temperature_k == 0.0 ? -kInf : std::nan(""), 0.0, 0.0};
  const SpectralLaw law = spectral_law(flux);
  const double x = exponent(wavelength_um, temperature_k).x, g = log_slope(x);
  const double log_value = x < kLargeExponent ? std::log(planck_slopes(flux, wavelength_um, temperature_k).value)
                                              : std::log(law.factor) - law.power * std::log(wavelength_um) - x;
  return {log_value, (g - law.power) / wavelength_um, g / temperature_k};
}

TemperatureSlopes brightness_temperature_slopes(Flux flux, double wavelength_um, double radiance) {
  if (!(wavelength_um > 0.0) || !(radiance >= 0.0)) return {std::nan(""), 0.0, 0.0};
  if (radiance == 0.0) return {};
  const SpectralLaw law = spectral_law(flux);
  const double factor = prefactor(law, wavelength_um), ratio = factor / radiance;
  const double x = ratio < kInf ? std::log1p(ratio) : std::log(factor) - std::log(radiance);
  const double temperature_k = kSecondRadiation_um_k / (wavelength_um * x), g = log_slope(x);
  return {temperature_k, -temperature_k * (g - law.power) / (wavelength_um * g), temperature_k / (radiance * g)};
}

}  // namespace radiometry
