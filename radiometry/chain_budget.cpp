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

NoiseTerms<double> noise_terms(const Sensor& sensor) {
  const SensorSettings& s = sensor.settings;
  const DetectorSettings detector = s.detector.value_or(DetectorSettings{});
  const NoiseSettings lines = s.noise.value_or(NoiseSettings{});
  const Noise3d cube = s.noise_3d.value_or(Noise3d{});
  const NonuniformitySettings unequal = s.nonuniformity.value_or(NonuniformitySettings{});
  return {.read_e = detector.read_e,
          .reset_e = reset_e_of(detector),
          .other_e = root_sum({detector.other_e, lines.row_e, lines.column_e, cube.t, cube.tv, cube.th, cube.tvh}),
          .step_e = s.adc ? adc_of(sensor).electrons_per_count : 0.0,
          .prnu = unequal.prnu,
          .dsnu_e = root_sum({unequal.dsnu_e, lines.fixed_row_e, lines.fixed_column_e, cube.v, cube.h, cube.vh})};
}

}  // namespace

Budget<double> budget_of(const mtf::System<double>& system, const Sensor& sensor, double temperature_k) {
  const Camera<double> camera = camera_of(system, sensor);
  const Pixel<double> pixel = pixel_of(system, sensor);
  const OpticsSettings warm = sensor.settings.optics.value_or(OpticsSettings{});
  const double surroundings_k = sensor.settings.scene ? sensor.settings.scene->surroundings_k.value_or(0.0) : 0.0;
  const Surface surface{temperature_k, sensor.emissivity, surroundings_k};
  const BandRadiances<double> radiances =
      band_radiances(sensor.curves, surface, sensor.path, {warm.temperature_k, warm.stop_temperature_k});
  const double per_k = electrons_per_radiance(camera, pixel) * scene_derivative(sensor.curves, surface, sensor.path);
  return make_budget(pixel, signal(camera, pixel, radiances), noise_terms(sensor), per_k);
}

}  // namespace radiometry
