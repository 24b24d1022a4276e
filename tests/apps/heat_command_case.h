// SPDX-License-Identifier: Apache-2.0
#pragma once

// A scene of two plates in a scratch folder, for the tests of `mtf scene` and `mtf heat`.

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "tests/apps/command.h"

namespace apps_test {

inline const std::string kScene = R"(schema = 1
[place]
latitude = "40 deg"
longitude = "0 deg"
altitude = "0 m"
[time]
start = 2026-06-21T00:00:00Z
end = 2026-06-22T00:00:00Z
step = "2 h"
[weather]
air_temperature = "15 degC"
wind_speed = "2 m/s"
direct_normal = "800 W/m2"
diffuse_horizontal = "80 W/m2"
longwave_down = "320 W/m2"
[[material]]
name = "steel"
solar_absorptance = 0.7
emissivity = 0.9
convection = "mcadams"
layers = [{ conductivity = "45 W/m/K", density = "7800 kg/m3", heat_capacity = "480 J/kg/K", thickness = "5 mm" }]
[[mesh]]
name = "plates"
file = "plates.obj"
unit = "1 m"
[[region]]
mesh = "plates"
material = "steel"
[camera]
position = ["4 m", "-3 m", "3 m"]
look_at = ["0.5 m", "0.5 m", "0.5 m"]
)";
inline const std::string kPlates =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 1 2 3 4\nf 5 6 7 8\n";

class HeatCommand : public testing::Test {
 protected:
  HeatCommand() {
    write_file(scratch_ / "scene.toml", kScene);
    write_file(scratch_ / "plates.obj", kPlates);
  }
  Scratch scratch_;
};

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> all;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) all.push_back(line);
  return all;
}

}  // namespace apps_test
