// SPDX-License-Identifier: Apache-2.0
#include "radiometry/weather/clear_sky.h"

#include <cmath>
#include <numbers>
#include <string>

#include "mtf/error.h"

namespace radiometry::heat {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kLargestZenith_rad = 89.0 * kDegree;
constexpr double kReferencePressure_pa = 101300.0;

void require_air(const ClearSkyAir& air) {
  const auto refuse = [](bool good, const char* what) {
    if (!good) throw mtf::UsageError(std::string("clear_sky: ") + what);
  };
  refuse(air.pressure_pa >= 100.0 && air.pressure_pa <= 120e3, "the pressure has to be from 100 to 120000 Pa");
  refuse(air.ozone_cm >= 0.0 && air.ozone_cm <= 2.0, "the ozone column has to be from 0 to 2 cm");
  refuse(air.water_cm >= 0.0 && air.water_cm <= 20.0, "the precipitable water has to be from 0 to 20 cm");
  refuse(air.aerosol_depth_500nm >= 0.0 && air.aerosol_depth_500nm <= 5.0 && air.aerosol_depth_380nm >= 0.0 &&
             air.aerosol_depth_380nm <= 5.0,
         "the aerosol's optical depths have to be from 0 to 5");
  refuse(air.forward_scatter_ratio >= 0.0 && air.forward_scatter_ratio <= 1.0,
         "the forward scatter ratio has to be from 0 to 1");
  refuse(air.albedo >= 0.0 && air.albedo <= 1.0, "the albedo has to be from 0 to 1");
}

}  // namespace

double relative_air_mass(double zenith_rad) {
  return 1.0 / (std::cos(zenith_rad) + 0.15 * std::pow(93.885 - zenith_rad / kDegree, -1.25));
}

SolarIrradiance clear_sky(const ClearSkyAir& air, double zenith_rad, double extraterrestrial_w_m2) {
  require_air(air);
  if (!(zenith_rad < kLargestZenith_rad)) return {};
  const double up = std::cos(zenith_rad), e0 = extraterrestrial_w_m2;
  const double m = relative_air_mass(zenith_rad), mp = m * air.pressure_pa / kReferencePressure_pa;

  const double rayleigh = std::exp(-0.0903 * std::pow(mp, 0.84) * (1.0 + mp - std::pow(mp, 1.01)));
  const double x = m * air.ozone_cm;
  const double ozone =
      1.0 - 0.1611 * x * std::pow(1.0 + 139.48 * x, -0.3034) - 0.002715 * x / (1.0 + 0.044 * x + 0.0003 * x * x);
  const double gases = std::exp(-0.0127 * std::pow(mp, 0.26));
  const double w = m * air.water_cm;
  const double water = 1.0 - 2.4959 * w / (std::pow(1.0 + 79.034 * w, 0.6828) + 6.385 * w);
  const double tau = 0.27583 * air.aerosol_depth_380nm + 0.35 * air.aerosol_depth_500nm;
  const double aerosol = std::exp(-std::pow(tau, 0.873) * (1.0 + tau - std::pow(tau, 0.7088)) * std::pow(m, 0.9108));
  const double absorbed = 1.0 - 0.1 * (1.0 - m + std::pow(m, 1.06)) * (1.0 - aerosol);

  const double clean = ozone * gases * water;
  const double beam = 0.9662 * e0 * aerosol * clean * rayleigh;
  const double scattered = 0.79 * e0 * up * clean * absorbed *
                           (0.5 * (1.0 - rayleigh) + air.forward_scatter_ratio * (1.0 - aerosol / absorbed)) /
                           (1.0 - m + std::pow(m, 1.02));
  const double sky_albedo = 0.0685 + (1.0 - air.forward_scatter_ratio) * (1.0 - aerosol / absorbed);
  const double global = (beam * up + scattered) / (1.0 - air.albedo * sky_albedo);
  return {beam, global - beam * up, global};
}

double standard_pressure_pa(double altitude_m) {
  if (!(altitude_m >= -1000.0 && altitude_m <= 11000.0))
    throw mtf::UsageError("standard_pressure: the altitude has to be from -1000 to 11000 m");
  return 101325.0 * std::pow(1.0 - 2.25577e-5 * altitude_m, 5.25588);
}

}  // namespace radiometry::heat
