// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/eye_fits.h"

#include <cmath>
#include <numbers>

namespace mtf {
namespace {

constexpr double kFootLambert = 1.0 / (std::numbers::pi * 0.3048 * 0.3048);  // cd/m^2
constexpr double kEndOfSight = 1e4;  // cy/deg and cy/mrad: every model is below the smallest double from here on

/// (1 - exp(-q))/q and its slope, q >= 0.
ValueSlope mean_decay(double q) {
  if (q < 0.5) {
    double value = 0.0, slope = 0.0, term = 1.0;  // (-q)^(k-1)/k!
    for (int k = 1; k <= 16; ++k) {
      value += term;
      slope -= term * k / (k + 1.0);
      term *= -q / (k + 1.0);
    }
    return {value, slope};
  }
  const double value = -std::expm1(-q) / q;
  return {value, (std::exp(-q) - value) / q};
}

ContrastSensitivity barten_2003(double u, double luminance, double field) {
  const double glare = 1.0 + 100.0 / luminance, spread = 0.0016 * std::pow(glare, 0.08);
  const double noise = 63.0 * std::pow(luminance, -0.83), q = 0.02 * u * u;
  const ValueSlope g = mean_decay(q);
  const double seen = q * g.value;  // 1 - exp(-q): lateral inhibition
  const double size = 1.0 + 144.0 / (field * field) + 0.64 * u * u, threshold = 1.0 + noise * seen;
  const double per_u = 5200.0 * std::exp(-spread * u * u) * std::sqrt(0.02 * g.value / (size * threshold));
  const double s = per_u * u;
  const double log_slope =  // of per_u
      -2.0 * spread * u + 0.02 * u * g.slope / g.value - 0.64 * u / size - 0.02 * noise * u * std::exp(-q) / threshold;
  const double by_spread = -u * u * s, by_noise = -0.5 * seen / threshold * s;
  return {s, per_u * (1.0 + u * log_slope),
          by_spread * spread * 0.08 / glare * -100.0 / (luminance * luminance) + by_noise * -0.83 * noise / luminance,
          144.0 / (field * field * field * size) * s};
}

ContrastSensitivity barten_short(int power, double u, double luminance, double field) {
  const double glare = 1.0 + 100.0 / luminance, b = 0.3 * std::pow(glare, 0.15), decay = std::exp(-b * u);
  const double area = field * std::pow(1.0 + u / 3.0, power);
  const double a = 540.0 * std::pow(1.0 + 0.7 / luminance, -0.2) * area / (area + 12.0);
  // exp(-b u) sqrt(1 + 0.06 exp(b u)) without its overflow
  const double per_u = a * std::exp(-0.5 * b * u) * std::sqrt(decay + 0.06), s = per_u * u;
  const double by_exponent = -0.5 - 0.5 * decay / (decay + 0.06), by_area = 12.0 / (area + 12.0);
  return {s, per_u * (1.0 + u * (b * by_exponent + by_area * power / (3.0 + u))),
          s * (0.14 / (luminance * (luminance + 0.7)) +
               u * by_exponent * b * 0.15 / glare * -100.0 / (luminance * luminance)),
          s * by_area / field};
}

}  // namespace

ValueSlope pupil_diameter_mm(double luminance_cd_m2, int eyes) {
  const double closing = 13.23 * std::exp(-std::log10(luminance_cd_m2 / kFootLambert) / 21.082);
  return {closing - 9.011 - (eyes == 2 ? 0.5 : 0.0), -closing / (21.082 * std::numbers::ln10 * luminance_cd_m2)};
}

EyeOptics eye_optics(double pupil_mm) {
  const double d = pupil_mm, root = 0.7155 + 0.277 / std::sqrt(d), f0 = std::exp(3.663 - 0.0216 * d * d * std::log(d));
  return {{f0, -0.0216 * d * (2.0 * std::log(d) + 1.0) * f0}, {root * root, -0.277 * root * std::pow(d, -1.5)}};
}

EyeMtf eye_mtf(double f_cy_mrad, double pupil_mm) {
  const double f = f_cy_mrad;
  if (f == 0.0) return {1.0, 0.0, 0.0};
  if (!(f < kEndOfSight)) return {};
  const EyeOptics o = eye_optics(pupil_mm);
  const double log_x = std::log(43.69 * f / o.f0.value), blur = std::exp(o.i0.value * log_x);
  const double retina = 0.375 * std::pow(f, 1.21), tremor = 0.4441 * f * f;
  const double value = std::exp(-blur - retina - tremor);
  return {value, -value * (o.i0.value * blur + 1.21 * retina + 2.0 * tremor) / f,
          -value * blur * (o.i0.slope * log_x - o.i0.value * o.f0.slope / o.f0.value)};
}

ContrastSensitivity contrast_sensitivity(ContrastModel model, double u_cy_deg, double luminance_cd_m2,
                                         double field_deg) {
  if (!(u_cy_deg < kEndOfSight)) return {};
  if (model == ContrastModel::barten_2003) return barten_2003(u_cy_deg, luminance_cd_m2, field_deg);
  return barten_short(model == ContrastModel::barten_short ? 1 : 2, u_cy_deg, luminance_cd_m2, field_deg);
}

double peak_frequency_cy_deg(ContrastModel model, double luminance_cd_m2, double field_deg) {
  // Every model rises like u and falls to 0: the sign of its slope, halved in log u to the last digits that matter (the
  // value at a peak is flat).
  double lo = 1e-3, hi = 60.0;
  while (hi / lo > 1.0 + 1e-12) {
    const double u = std::sqrt(lo * hi);
    (contrast_sensitivity(model, u, luminance_cd_m2, field_deg).by_frequency > 0.0 ? lo : hi) = u;
  }
  return std::sqrt(lo * hi);
}

}  // namespace mtf
