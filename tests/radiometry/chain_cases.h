// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "radiometry/chain/chain.h"
#include "tests/mtf/builders.h"
#include "tests/radiometry/frames.h"

namespace radiometry::test {

/// An MWIR sensor: 3 to 5 um, F/2.5, 15 um pixels all active, 2 ms.
inline mtf::System<double> mwir_system() {
  mtf::System<double> system = mtf::test::mwir();
  system.optics.f_number = 2.5;
  system.optics.wavelength_um.reset();
  system.band = mtf::Band{3.0, 5.0};
  system.frame.integration_time_s = 2e-3;
  return system;
}

inline Sensor mwir_sensor() {
  Sensor sensor;
  sensor.curves.band = {3.0, 5.0};
  sensor.settings.optics = OpticsSettings{.transmission = {0.85}};
  sensor.settings.detector = DetectorSettings{.quantum_efficiency = {0.75}, .full_well_e = 7e6};
  return sensor;
}

/// The same with noise, non-uniformity and converter.
inline Sensor noisy_sensor() {
  Sensor sensor = mwir_sensor();
  sensor.settings.detector->dark_e_s = 5e6;
  sensor.settings.detector->read_e = 600.0;
  sensor.settings.noise = NoiseSettings{.seed = 11, .row_e = 40.0, .column_e = 60.0};
  sensor.settings.nonuniformity = NonuniformitySettings{.prnu = 2e-3, .dsnu_e = 300.0};
  sensor.settings.adc = AdcSettings{.bits = 14, .electrons_per_count = 450.0, .offset_counts = 100.0};
  return sensor;
}

/// The chain for scenes of that size in samples of `step_um`.
inline Chain make_chain(const mtf::System<double>& system, const Sensor& sensor, std::int64_t width,
                        std::int64_t height, double step_um, Origin origin = {},
                        mtf::Border border = mtf::Border::reflect, double tolerance = 1e-4) {
  mtf::PlanOptions options;
  options.tolerance = tolerance;
  options.border = border;
  options.separate_readout = true;
  return {mtf::compile_sensor(system, {width, height, step_um, step_um}, options, samples_a_pitch(sensor)), system,
          sensor, origin};
}

}  // namespace radiometry::test
