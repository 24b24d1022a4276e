// SPDX-License-Identifier: Apache-2.0
#pragma once

// A plate on level ground by day, and a small uncooled camera, as texts of files.

#include <string>

namespace apps_test {

/// Place, time and weather; `time`: the keys of [time]. Meshes and what follows are the test's.
inline std::string place_and_weather(const std::string& time) {
  return R"(schema = 1
[place]
latitude = "40 deg"
longitude = "0 deg"
altitude = "0 m"
[time]
)" + time +
         R"([weather]
air_temperature = "288 K"
wind_speed = "2 m/s"
direct_normal = "700 W/m2"
diffuse_horizontal = "80 W/m2"
longwave_down = "320 W/m2"
vapour_pressure = "10 hPa"
)";
}

/// The mesh of the plates and its two regions; soil of 290 K, `soil` and `target`: further keys of each.
inline std::string soil_and_target(const std::string& soil, const std::string& target) {
  return R"([[mesh]]
name = "plates"
file = "plates.obj"
[[region]]
mesh = "plates"
group = "soil"
temperature = "290 K"
)" + soil +
         R"([[region]]
mesh = "plates"
group = "target"
)" + target;
}

/// Groups `soil` and `target`.
inline const std::string kGroundAndTarget =
    "v -4 -4 0\nv 4 -4 0\nv 4 4 0\nv -4 4 0\nv -0.5 0 0.2\nv 0.5 0 0.2\nv 0.5 0 1.2\nv -0.5 0 1.2\n"
    "g soil\nf 1 2 3 4\ng target\nf 5 6 7 8\n";

/// `more`: tables of the sensor file before its last one, [adc].
inline std::string uncooled(const std::string& more) {
  return R"(schema = 1
name = "uncooled"
[frame]
focal_length = "12.5 mm"
pitch = "12 um"
format = [64, 48]
[optics]
f_number = 1.2
stop_temperature = "293 K"
[band]
wavelength = ["8 um", "13 um"]
[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
fill_factor = 0.85
[detector]
kind = "thermal"
absorptance = 0.8
responsivity = 1e5
shutter_temperature = "293 K"
netd = "30 mK"
netd_f_number = 1.0
netd_transmission = 1.0
netd_temperature = "300 K"
)" + more +
         R"([adc]
bits = 14
volts_per_count = "0.05 uV"
offset = 4000
)";
}

}  // namespace apps_test
