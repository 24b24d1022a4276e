// SPDX-License-Identifier: Apache-2.0
#include "radiometry/weather/sky.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/units.h"
#include "radiometry/light/constants.h"

namespace radiometry::heat {
namespace {

constexpr double kMagnusPressure_pa = 611.2, kMagnusFactor = 17.62, kMagnusOffset_k = 243.12;
constexpr double kCloudGain = 0.22, kCloudExponent = 2.75;

}  // namespace

double saturation_pressure_pa(double temperature_k) {
  const double t = temperature_k - mtf::kZeroCelsius_k;
  return kMagnusPressure_pa * std::exp(kMagnusFactor * t / (kMagnusOffset_k + t));
}

double dew_point_k(double vapour_pressure_pa) {
  const double x = std::log(vapour_pressure_pa / kMagnusPressure_pa);
  return mtf::kZeroCelsius_k + kMagnusOffset_k * x / (kMagnusFactor - x);
}

double clear_sky_longwave_w_m2(SkyModel model, double air_temperature_k, double vapour_pressure_pa) {
  const double t = air_temperature_k, e_hpa = vapour_pressure_pa / 100.0;
  if (!(t > 0.0 && e_hpa >= 0.0))
    throw mtf::UsageError(
        "clear_sky_longwave: the air temperature has to be above 0 K and the vapour pressure not below 0");
  const double black = kStefanBoltzmann_w_m2_k4 * t * t * t * t;
  if (model == SkyModel::brunt) return black * (0.52 + 0.065 * std::sqrt(e_hpa));
  if (model == SkyModel::brutsaert) return black * 1.24 * std::pow(e_hpa / t, 1.0 / 7.0);
  return 5.31e-13 * std::pow(t, 6);
}

double cloud_factor(double cover) {
  if (!(cover >= 0.0 && cover <= 1.0)) throw mtf::UsageError("cloud_factor: the cover has to be from 0 to 1");
  return 1.0 + kCloudGain * std::pow(cover, kCloudExponent);
}

double cloud_cover_from_longwave(double measured_w_m2, double clear_w_m2) {
  const double excess = (measured_w_m2 / clear_w_m2 - 1.0) / kCloudGain;
  return std::pow(std::clamp(excess, 0.0, 1.0), 1.0 / kCloudExponent);
}

double blackbody_w_m2(double temperature_k) { return kStefanBoltzmann_w_m2_k4 * std::pow(temperature_k, 4); }

double sky_temperature_k(double longwave_w_m2) { return std::pow(longwave_w_m2 / kStefanBoltzmann_w_m2_k4, 0.25); }

}  // namespace radiometry::heat
