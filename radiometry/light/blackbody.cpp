// SPDX-License-Identifier: Apache-2.0
#include "radiometry/light/blackbody.h"

#include <algorithm>
#include <limits>

#include "mtf/math/quadrature.h"
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

constexpr double kSmallestNormal = std::numeric_limits<double>::min();

/// The band in x: it begins at `from` (the longest wavelength) and is `width` wide, which is formed without a
/// difference of the two.
struct Span {
  Exponent from;
  double width;
};

Span span_of(double lo_um, double hi_um, double temperature_k) {
  const double inverse = hi_um == kInf ? 1.0 / lo_um : lo_um == 0.0 ? kInf : (hi_um - lo_um) / lo_um / hi_um;
  return {hi_um == kInf ? Exponent{} : exponent(hi_um, temperature_k),
          lo_um == hi_um ? 0.0 : inverse * (kSecondRadiation_um_k / temperature_k)};
}

// Below, p is the power of t; `derivative` stands for the integrand t^(p+1) e^t / (e^t - 1)^2 of d/dT instead of
// t^p / (e^t - 1). Everything is scaled by e^x with x the lower limit.

/// The integral from x over a width of at most 2. The integrand is analytic to 2 pi i; 16 nodes err by less than 1e-20.
double short_integral(int p, bool derivative, double x, double width) {
  const mtf::GaussRule& rule = mtf::gauss_legendre(16);
  double sum = 0.0;
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    const double s = 0.5 * width * (1.0 - rule.node[i]), t = x + s, lost = -std::expm1(-t);
    const double power = p == 3 ? t * t * t : t * t;
    sum += rule.weight[i] * std::exp(-s) * (derivative ? power * t / (lost * lost) : power / lost);
  }
  return 0.5 * width * sum;
}

/// The integral from x >= 1 to infinity, by the series.
double tail(int p, bool derivative, double x) {
  double sum = 0.0;
  for (int n = 1; n < 64; ++n) {
    const double r = 1.0 / n, inner = p == 3 ? x * (x * (x + 3.0 * r) + 6.0 * r * r) + 6.0 * r * r * r
                                             : x * (x + 2.0 * r) + 2.0 * r * r;
    const double term = std::exp(-(n - 1) * x) * r * inner;
    sum += term;
    if (term < 1e-18 * sum) break;
  }
  if (!derivative) return sum;
  const double power = p == 3 ? x * x * x : x * x;
  return (p + 1) * sum + power * x / -std::expm1(-x);  // by parts
}

double scaled_integral(int p, bool derivative, double x, double width) {
  if (width <= 2.0) return short_integral(p, derivative, x, width);
  if (x < 1.0)
    return short_integral(p, derivative, x, 1.0 - x) +
           std::exp(x - 1.0) * scaled_integral(p, derivative, 1.0, width - (1.0 - x));
  const double rest = width < 800.0 ? std::exp(-width) * tail(p, derivative, x + width) : 0.0;
  return tail(p, derivative, x) - rest;
}

bool is_band(double lo_um, double hi_um) { return lo_um >= 0.0 && hi_um >= lo_um && lo_um < kInf && hi_um > 0.0; }

struct BandLaw {
  double factor;
  int p;  // of Bp; the radiance has the factor T^(p + 1)
};
BandLaw band_law(Flux flux) { return {band_factor(flux), flux == Flux::watts ? 3 : 2}; }

double radiance(Flux flux, bool derivative, double lo_um, double hi_um, double temperature_k) {
  if (!is_band(lo_um, hi_um)) return std::nan("");
  if (!radiates(temperature_k)) return no_radiance(temperature_k);
  const BandLaw law = band_law(flux);
  const Span span = span_of(lo_um, hi_um, temperature_k);
  const double t3 = temperature_k * temperature_k * temperature_k;
  // T^(p + 1) and, of the derivative, T^p.
  const double power =
      law.p == 3 ? (derivative ? t3 : t3 * temperature_k) : (derivative ? temperature_k * temperature_k : t3);
  return times_exp(law.factor * power * scaled_integral(law.p, derivative, span.from.x, span.width), span.from);
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

BandSlopes band_radiance_slopes(Flux flux, double lo_um, double hi_um, double temperature_k) {
  const double value = radiance(flux, false, lo_um, hi_um, temperature_k);
  if (!(value > 0.0) && !(lo_um == hi_um && temperature_k > 0.0)) return {value, 0.0, 0.0, 0.0};
  return {value, lo_um > 0.0 ? -planck_slopes(flux, lo_um, temperature_k).value : 0.0,
          hi_um < kInf ? planck_slopes(flux, hi_um, temperature_k).value : 0.0,
          radiance(flux, true, lo_um, hi_um, temperature_k)};
}

BandSlopes band_derivative_slopes(Flux flux, double lo_um, double hi_um, double temperature_k) {
  const double value = radiance(flux, true, lo_um, hi_um, temperature_k);
  if (!(value > 0.0)) return {value, 0.0, 0.0, 0.0};
  const double at_lo = lo_um > 0.0 ? planck_slopes(flux, lo_um, temperature_k).by_temperature : 0.0;
  const double at_hi = hi_um < kInf ? planck_slopes(flux, hi_um, temperature_k).by_temperature : 0.0;
  const double ends = (hi_um < kInf ? hi_um * at_hi : 0.0) - lo_um * at_lo;
  return {value, -at_lo, at_hi, (band_law(flux).p * value + ends) / temperature_k};
}

double log_band_radiance(Flux flux, double lo_um, double hi_um, double temperature_k) {
  if (!is_band(lo_um, hi_um)) return std::nan("");
  if (!radiates(temperature_k)) return temperature_k == 0.0 ? -kInf : std::nan("");
  const double value = radiance(flux, false, lo_um, hi_um, temperature_k);
  if (value >= kSmallestNormal) return std::log(value);
  const BandLaw law = band_law(flux);
  const Span span = span_of(lo_um, hi_um, temperature_k);
  return std::log(law.factor) + (law.p + 1) * std::log(temperature_k) +
         std::log(scaled_integral(law.p, false, span.from.x, span.width)) - span.from.x;
}

double band_temperature(Flux flux, double lo_um, double hi_um, double wanted) {
  if (!(lo_um > 0.0) || !(hi_um > lo_um) || !(hi_um < kInf) || !(wanted >= 0.0)) return std::nan("");
  if (wanted == 0.0 || wanted == kInf) return wanted;
  // log L is a convex, falling function of 1/T, nearly a line: Newton's iteration on it, from the middle wavelength.
  double t = brightness_temperature_slopes(flux, 0.5 * (lo_um + hi_um), wanted / (hi_um - lo_um)).value;
  for (int step = 0; step < 60; ++step) {
    const BandLaw law = band_law(flux);
    const Span span = span_of(lo_um, hi_um, t);
    const double slope = scaled_integral(law.p, true, span.from.x, span.width) /
                         scaled_integral(law.p, false, span.from.x, span.width);  // d log L / d log T
    const double value = radiance(flux, false, lo_um, hi_um, t);
    const double log_ratio = value >= kSmallestNormal && value < kInf
                                 ? std::log(value / wanted)
                                 : log_band_radiance(flux, lo_um, hi_um, t) - std::log(wanted);
    const double excess = log_ratio / slope;
    const double next = t / std::clamp(1.0 + excess, 0.25, 4.0);
    const bool done = std::abs(next - t) <= 1e-15 * t;
    t = next;
    if (done) break;
  }
  return t;
}

}  // namespace radiometry
