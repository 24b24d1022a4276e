// SPDX-License-Identifier: Apache-2.0
#pragma once

// Uncooled cameras: one whose noise is given by its NETD, one whose noise is that of the physics.

#include "tests/radiometry/chain_cases.h"

namespace radiometry::test {

/// F/1, 17 um, 8 to 14 um.
inline mtf::System<double> lwir_system() {
  mtf::System<double> system;
  system.name = "LWIR";
  system.frame = {18.0, 17.0, 17.0, 0.0, 0, 0};
  system.optics.f_number = 1.0;
  system.band = mtf::Band{8.0, 14.0};
  system.add(mtf::Stage::presample, mtf::test::footprint(17.0));
  return system;
}

inline Sensor sensor_of(const ThermalSettings& thermal) {
  Sensor sensor;
  sensor.curves.band = {8.0, 14.0};
  sensor.settings.thermal = thermal;
  sensor.settings.detector = pixel_settings(thermal);
  sensor.curves.flux = flux_of(sensor.settings);
  return sensor;
}

/// 50 mK at F/1 and 300 K.
inline ThermalSettings by_netd() {
  ThermalSettings thermal;
  thermal.absorptance = {0.8};
  thermal.responsivity_v_w = 1e5;
  thermal.netd_k = 0.05;
  thermal.netd_f_number = 1.0;
  thermal.netd_transmission = 1.0;
  thermal.netd_temperature_k = 300.0;
  return thermal;
}

inline ThermalSettings by_physics() {
  ThermalSettings thermal;
  thermal.absorptance = {0.8};
  thermal.bandwidth_hz = 8e3;
  thermal.readout_v = 10e-6;
  thermal.heat_capacity_j_k = 3e-10;
  thermal.conductance_w_k = 3e-8;
  thermal.temperature_k = 300.0;
  thermal.resistance_ohm = 1e5;
  thermal.tcr_per_k = -0.02;
  thermal.bias_v = 2.0;
  return thermal;
}

}  // namespace radiometry::test
