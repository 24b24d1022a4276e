// SPDX-License-Identifier: Apache-2.0

// The budget of a sensor file, from the same numbers as its chain.

#include <algorithm>
#include <cmath>

#include "mtf/survey/statistics.h"
#include "radiometry/performance/sensor_budget.h"

namespace radiometry {

bool is_spectral(std::string_view path) {
  constexpr std::array<std::string_view, 7> paths{"optics.temperature", "optics.stop_temperature", "path.transmission",
                                                  "path.radiance",      "path.air_temperature",    "scene.emissivity",
                                                  "scene.surroundings"};
  return std::find(paths.begin(), paths.end(), path) != paths.end();
}

SpectralNumbers<double> spectral_numbers(const Sensor& sensor, double temperature_k, double warmer_k,
                                         const Overrides<double>& numbers) {
  const SensorSettings& settings = sensor.settings;
  const double given = settings.scene ? settings.scene->surroundings_k.value_or(0.0) : 0.0;
  Surface surface{temperature_k, sensor.emissivity, numbers("scene.surroundings", given)};
  Path path = sensor.path;
  const auto constant = [&](std::string_view name, Spectrum& spectrum, double most) {
    if (const double* value = numbers.find(name)) spectrum = constant_spectrum(std::string(name), *value, most);
  };
  constant("scene.emissivity", surface.emissivity, 1.0);
  constant("path.transmission", path.transmission, 1.0);
  constant("path.radiance", path.radiance, std::numeric_limits<double>::max());
  const double* air = numbers.find("path.air_temperature");
  if (settings.path && (air != nullptr || settings.path->air_temperature_k)) {  // air emits what it absorbs
    const Path absorbing = absorbing_path(path.transmission, air != nullptr ? *air : *settings.path->air_temperature_k);
    path.emissivity = absorbing.emissivity;
    path.air_temperature_k = absorbing.air_temperature_k;
  }
  CameraEmission emission = emission_of(settings.optics.value_or(OpticsSettings{}));
  emission.optics_k = numbers("optics.temperature", emission.optics_k);
  emission.stop_k = numbers("optics.stop_temperature", emission.stop_k);
  return {.radiances = band_radiances(sensor.curves, surface, path, emission),
          .per_k = scene_derivative(sensor.curves, surface, path),
          .contrast = warmer_k == 0.0 ? 0.0 : scene_difference(sensor.curves, surface, path, warmer_k),
          .quantum_efficiency = mean_quantum_efficiency(sensor.curves, surface, path)};
}

SensorSettings budget_settings(const Sensor& sensor) {
  SensorSettings settings = sensor.settings;
  if (!settings.nonuniformity) return settings;
  if (sensor.responsivity) settings.nonuniformity->prnu = mtf::statistics(sensor.responsivity->view()).std;
  if (sensor.offset) settings.nonuniformity->dsnu_e = mtf::statistics(sensor.offset->view()).std;
  return settings;
}

namespace {

/// True where the mean of a map is the expected one: within 1e-3 of `scale`, or within the sampling error that the mean
/// of so many independent pixels has.
bool has_mean(const mtf::Image& map, const mtf::Statistics& measured, double expected, double scale) {
  constexpr double kSigmas = 4.0;
  const double sampling = kSigmas * measured.std / std::sqrt(static_cast<double>(map.size()));
  return std::abs(measured.mean - expected) <= std::max(1e-3 * scale, sampling);
}

}  // namespace

std::vector<std::string> budget_notes(const Sensor& sensor) {
  std::vector<std::string> notes;
  if (const auto& noise = sensor.settings.noise; noise && !noise->shot)
    notes.emplace_back(
        "[noise] shot = false leaves shot noise out of simulated frames; the budget counts it, as light and dark "
        "current have it whatever is simulated");
  if (sensor.responsivity) {
    const mtf::Statistics factors = mtf::statistics(sensor.responsivity->view());
    if (!has_mean(*sensor.responsivity, factors, 1.0, 1.0))
      notes.push_back("the mean of nonuniformity.responsivity is " + three_digits(factors.mean) +
                      "; the budget is that of a pixel whose factor is 1, and its prnu is the standard deviation of "
                      "the factors, " +
                      three_digits(factors.std) + ", not divided by their mean");
  }
  if (sensor.offset) {
    const mtf::Statistics offset = mtf::statistics(sensor.offset->view());
    if (!has_mean(*sensor.offset, offset, 0.0, offset.std))
      notes.push_back("the mean of nonuniformity.offset is " + three_digits(offset.mean) +
                      " e-, which the budget leaves out of the mean signal at the converter");
  }
  return notes;
}

Budget<double> budget_of(const mtf::System<double>& system, const Sensor& sensor, double temperature_k) {
  require_consistent(system, sensor);
  pixel_of(system, sensor);  // throws where there is no [detector]
  return sensor_budget(system, budget_settings(sensor), spectral_numbers(sensor, temperature_k),
                       flicker_rms_e(system, sensor.settings));
}

double flicker_rms_e(const mtf::System<double>& system, const SensorSettings& settings) {
  if (!settings.flicker) return 0.0;
  // A sensor without a format gets that of a common detector: 1/f noise grows with the logarithm of the size only.
  const std::int64_t columns = system.frame.columns > 0 ? system.frame.columns : 640;
  const std::int64_t rows = system.frame.rows > 0 ? system.frame.rows : 512;
  return std::sqrt(flicker_variance(*settings.flicker, columns, rows));
}

namespace {
double middle_um(const Sensor& sensor) { return 0.5 * (sensor.curves.band.lo_um + sensor.curves.band.hi_um); }
}  // namespace

double dstar_of(const mtf::System<double>& system, const Sensor& sensor, const Budget<double>& budget) {
  Pixel<double> pixel = pixel_of(system, sensor);
  const double wavelength_um = middle_um(sensor);
  for (const Spectrum& curve : sensor.curves.quantum_efficiency)
    pixel.quantum_efficiency *= evaluate(curve, wavelength_um);
  return dstar_jones(pixel, budget.temporal_e, wavelength_um);
}

BudgetRow dstar_row(const mtf::System<double>& system, const Sensor& sensor, const Budget<double>& budget) {
  const double dstar = dstar_of(system, sensor, budget);
  return {"dstar",
          "cm Hz^1/2 W^-1",
          dstar,
          "D* at " + mtf::format_double(middle_um(sensor)) + " um, the middle of the band, temporal noise",
          refusal_of(budget, dstar),
          is_saturated(budget, dstar)};
}

}  // namespace radiometry
