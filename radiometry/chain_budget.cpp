// SPDX-License-Identifier: Apache-2.0

// The budget of a sensor file, from the same numbers as its chain.

#include <cmath>

#include "radiometry/chain.h"

namespace radiometry {
namespace {

double root_sum(std::initializer_list<double> rms) {
  double sum = 0.0;
  for (const double value : rms) sum += value * value;
  return std::sqrt(sum);
}

NoiseTerms<double> noise_terms(const Sensor& sensor, std::int64_t columns, std::int64_t rows) {
  const SensorSettings& s = sensor.settings;
  const DetectorSettings detector = s.detector.value_or(DetectorSettings{});
  const NoiseSettings lines = s.noise.value_or(NoiseSettings{});
  const Noise3d cube = s.noise_3d.value_or(Noise3d{});
  const NonuniformitySettings unequal = s.nonuniformity.value_or(NonuniformitySettings{});
  const double flicker_e = s.flicker ? std::sqrt(flicker_variance(*s.flicker, columns, rows)) : 0.0;
  return {.read_e = detector.read_e,
          .reset_e = reset_e_of(detector),
          .other_e =
              root_sum({detector.other_e, flicker_e, lines.row_e, lines.column_e, cube.t, cube.tv, cube.th, cube.tvh}),
          .step_e = s.adc ? adc_of(sensor).electrons_per_count : 0.0,
          .prnu = unequal.prnu,
          .dsnu_e = root_sum({unequal.dsnu_e, lines.fixed_row_e, lines.fixed_column_e, cube.v, cube.h, cube.vh})};
}

}  // namespace

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
  // Without a format, that of a common detector: 1/f noise grows with the logarithm of its size.
  const std::int64_t columns = system.frame.columns > 0 ? system.frame.columns : 640;
  const std::int64_t rows = system.frame.rows > 0 ? system.frame.rows : 512;
  return make_budget(pixel, electrons, noise_terms(sensor, columns, rows), per_k);
}

double dstar_of(const mtf::System<double>& system, const Sensor& sensor, const Budget<double>& budget) {
  Pixel<double> pixel = pixel_of(system, sensor);
  const double middle_um = 0.5 * (sensor.curves.band.lo_um + sensor.curves.band.hi_um);
  for (const Spectrum& curve : sensor.curves.quantum_efficiency) pixel.quantum_efficiency *= evaluate(curve, middle_um);
  return dstar_jones(pixel, budget.temporal_e, middle_um);
}

}  // namespace radiometry
