// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sensor file of an uncooled camera, and commands that read it.

#include "tests/apps/chain_sensor.h"

namespace apps_test {

inline const std::string kUncooled = R"(schema = 1
name = "uncooled"
[frame]
focal_length = "18 mm"
pitch = "17 um"
frame_time = "20 ms"
[scene]
sample = "17 um"
quantity = "temperature"
[optics]
f_number = 1.0
transmission = 0.9
emissivity = 0.1
temperature = "295 K"
stop_temperature = "295 K"
[band]
wavelength = ["8 um", "14 um"]
[[presample]]
kind = "footprint"
fill_factor = 1.0
[detector]
kind = "thermal"
absorptance = 0.8
responsivity = 1e5
shutter_temperature = "295 K"
netd = "50 mK"
netd_f_number = 1.0
netd_transmission = 1.0
netd_temperature = "300 K"
)";
inline const std::string kConverter = "[adc]\nbits = 14\nvolts_per_count = \"0.5 uV\"\noffset = 4000\n";

class ThermalSensor : public ChainSensor {
 protected:
  void camera(const std::string& more, const std::string& from = "", const std::string& to = "") const {
    std::string text = kUncooled + more;
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    write_file(scratch / "s.toml", text);
  }
};

}  // namespace apps_test
