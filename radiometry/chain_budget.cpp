// SPDX-License-Identifier: Apache-2.0

// The budget of a sensor file, from the same numbers as its chain.

#include <cmath>

#include "radiometry/chain.h"
#include "radiometry/sensor_numbers.h"

namespace radiometry {
Budget<double> budget_of(const mtf::System<double>& system, const Sensor& sensor, double temperature_k) {
  require_consistent(system, sensor);
  const Camera<double> camera = camera_of(system, sensor);
  const Pixel<double> pixel = pixel_of(system, sensor);
  const OpticsSettings warm = sensor.settings.optics.value_or(OpticsSettings{});
  const double surroundings_k = sensor.settings.scene ? sensor.settings.scene->surroundings_k.value_or(0.0) : 0.0;
  const Surface surface{temperature_k, sensor.emissivity, surroundings_k};
  const BandRadiances<double> radiances =
      band_radiances(sensor.curves, surface, sensor.path, {warm.temperature_k, warm.stop_temperature_k});
  const double per_k = electrons_per_radiance(camera, pixel) * scene_derivative(sensor.curves, surface, sensor.path);
  Signal<double> electrons = signal(camera, pixel, radiances);
  if (const auto& narcissus = sensor.settings.narcissus) {
    electrons.optics_e *= 1.0 - narcissus->depth;
    electrons.stop_e *= 1.0 - narcissus->depth;
  }
  return make_budget(pixel, electrons, noise_numbers(sensor.settings, pixel, flicker_rms_e(system, sensor.settings)),
                     per_k);
}

double flicker_rms_e(const mtf::System<double>& system, const SensorSettings& settings) {
  if (!settings.flicker) return 0.0;
  // Without a format, that of a common detector: 1/f noise grows with the logarithm of its size.
  const std::int64_t columns = system.frame.columns > 0 ? system.frame.columns : 640;
  const std::int64_t rows = system.frame.rows > 0 ? system.frame.rows : 512;
  return std::sqrt(flicker_variance(*settings.flicker, columns, rows));
}

double dstar_of(const mtf::System<double>& system, const Sensor& sensor, const Budget<double>& budget) {
  Pixel<double> pixel = pixel_of(system, sensor);
  const double middle_um = 0.5 * (sensor.curves.band.lo_um + sensor.curves.band.hi_um);
  for (const Spectrum& curve : sensor.curves.quantum_efficiency) pixel.quantum_efficiency *= evaluate(curve, middle_um);
  return dstar_jones(pixel, budget.temporal_e, middle_um);
}

}  // namespace radiometry
