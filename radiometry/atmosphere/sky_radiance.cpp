// SPDX-License-Identifier: Apache-2.0
#include "radiometry/atmosphere/sky_radiance.h"

#include <cmath>

#include "mtf/error.h"
#include "mtf/math/quadrature.h"
#include "mtf/units.h"
#include "radiometry/atmosphere/spectral_impl.h"
#include "radiometry/light/blackbody.h"
#include "radiometry/light/constants.h"

namespace radiometry::atmosphere {

SkyRadiance sky_radiance(const Air<double>& air, double altitude_m, double zenith_rad, double tolerance) {
  const SpectralOptions options{
      .band = {kShortestEmission_um, kLongest_um}, .components = false, .tolerance = tolerance};
  require_options(options);
  const Line<double> line = line_of(air, Sight<double>(ToSpace<double>{altitude_m, zenith_rad}));
  SpectralPath<double> path = SpectralLine<double>(line, options).whole();
  SkyRadiance sky;
  sky.lowest_layer_k = line.pieces.empty() ? line.at_sensor[kPressureDensity] / line.at_sensor[kMassDensity]
                                           : LineLayers<double>(line).layers.front().temperature_k;
  sky.below_650 = line.pieces.empty() ? 0.0
                                      : band_radiance(Flux::watts, kLongest_um, std::numeric_limits<double>::infinity(),
                                                      sky.lowest_layer_k);
  sky.wavenumber_cm = std::move(path.wavenumber_cm);
  sky.radiance = std::move(path.radiance);
  sky.whole = sky.below_650;
  for (std::size_t i = 1; i < sky.radiance.size(); ++i)
    sky.whole += 0.5 * (sky.wavenumber_cm[i] - sky.wavenumber_cm[i - 1]) * (sky.radiance[i] + sky.radiance[i - 1]);
  return sky;
}

SkyFlux sky_flux(const Air<double>& air, double altitude_m, int nodes) {
  if (nodes < 2 || nodes > 64)
    throw mtf::UsageError("sky: " + std::to_string(nodes) + " angles for the flux; give from 2 to 64");
  const auto flux = [&](int count) {
    const mtf::GaussRule rule = mtf::mean_rule(0.0, 1.0, count);
    SkyFlux out;
    for (std::size_t i = 0; i < rule.node.size(); ++i) {
      const double mu = rule.node[i], weight = 2.0 * mtf::kPi * rule.weight[i] * mu;
      const SkyRadiance sky = sky_radiance(air, altitude_m, std::acos(mu));
      out.total_w_m2 += weight * sky.whole;
      out.below_650_w_m2 += weight * sky.below_650;
    }
    return out;
  };
  SkyFlux out = flux(nodes);
  out.quadrature_error_w_m2 = std::abs(out.total_w_m2 - flux(nodes / 2).total_w_m2);
  return out;
}

namespace {

void require_cloud(double cloud_k) {
  if (!(cloud_k >= 150.0 && cloud_k <= 350.0))
    throw mtf::UsageError("sky: a cloud of " + mtf::format_double(cloud_k) + " K; it has to be from 150 to 350 K");
}

double mixed(double cover, double of_clear, double of_cloud) { return (1.0 - cover) * of_clear + cover * of_cloud; }

void require_clouds(const Clouds& clouds) {
  if (!(clouds.cover >= 0.0 && clouds.cover <= 1.0))
    throw mtf::UsageError("sky: a cloud cover of " + mtf::format_double(clouds.cover) + "; it has to be from 0 to 1");
  if (clouds.cover > 0.0) require_cloud(clouds.temperature_k);
}

}  // namespace

SkyRadiance under_clouds(SkyRadiance clear, const Clouds& clouds) {
  require_clouds(clouds);
  if (clouds.cover == 0.0) return clear;
  double change = 0.0, before = 0.0;
  for (std::size_t i = 0; i < clear.radiance.size(); ++i) {
    const double own = clear.radiance[i];
    clear.radiance[i] = mixed(clouds.cover, own, planck_per_cm(clear.wavenumber_cm[i], clouds.temperature_k).value);
    const double now = clear.radiance[i] - own;
    if (i > 0) change += 0.5 * (clear.wavenumber_cm[i] - clear.wavenumber_cm[i - 1]) * (now + before);
    before = now;
  }
  const double far =
      mixed(clouds.cover, clear.below_650,
            band_radiance(Flux::watts, kLongest_um, std::numeric_limits<double>::infinity(), clouds.temperature_k));
  clear.whole += change + far - clear.below_650;
  clear.below_650 = far;
  return clear;
}

SkyFlux under_clouds(SkyFlux clear, const Clouds& clouds) {
  require_clouds(clouds);
  if (clouds.cover == 0.0) return clear;
  clear.total_w_m2 =
      mixed(clouds.cover, clear.total_w_m2, kStefanBoltzmann_w_m2_k4 * std::pow(clouds.temperature_k, 4));
  clear.below_650_w_m2 = mixed(clouds.cover, clear.below_650_w_m2,
                               mtf::kPi * band_radiance(Flux::watts, kLongest_um,
                                                        std::numeric_limits<double>::infinity(), clouds.temperature_k));
  clear.quadrature_error_w_m2 *= 1.0 - clouds.cover;
  return clear;
}

double cloud_cover(double measured_w_m2, double clear_w_m2, double cloud_k) {
  require_cloud(cloud_k);
  if (!(measured_w_m2 >= 0.0) || !(clear_w_m2 >= 0.0))
    throw mtf::UsageError("sky: fluxes of " + mtf::format_double(measured_w_m2) + " and " +
                          mtf::format_double(clear_w_m2) + " W/m2; they have to be 0 or more");
  const double covered = kStefanBoltzmann_w_m2_k4 * std::pow(cloud_k, 4);
  if (measured_w_m2 <= clear_w_m2) return 0.0;
  if (measured_w_m2 >= covered) return 1.0;
  return (measured_w_m2 - clear_w_m2) / (covered - clear_w_m2);
}

}  // namespace radiometry::atmosphere
