// SPDX-License-Identifier: Apache-2.0
#pragma once

// A folder with a scene file and the small tables that it names.

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "apps/scene/scene_file/scene_file.h"
#include "tests/apps/scene/weather_texts.h"

namespace apps::scene::test {

class SceneFolder {
 public:
  SceneFolder() : path_(std::filesystem::temp_directory_path() / ("mtfkit_scene_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_);
    write("paint.csv", "wavelength_um,emissivity\n3,0.6\n8,0.9\n14,0.95\n");
    write("bands.csv", "from_um,to_um,emissivity\n3,5,0.5\n8,14,0.95\n");
    write("engine.csv", "time (h),temperature (degC)\n0,20\n6,80\n");
    write("heater.csv", "time,flux (W/m2)\n2016-01-01T00:00:00Z,0\n2016-01-01T06:00:00Z,100\n");
    write("facets.csv", "facet,temperature_K\n0,300\n");
    write("weather.csv", csv_text(72));
  }
  ~SceneFolder() { std::filesystem::remove_all(path_); }
  SceneFolder(const SceneFolder&) = delete;
  SceneFolder& operator=(const SceneFolder&) = delete;

  void write(const std::string& name, const std::string& text) const { std::ofstream(path_ / name) << text; }
  std::string file(const std::string& name) const { return (path_ / name).string(); }
  SceneResult parse(const std::string& text) const { return parse_scene(text, file("scene.toml")); }

 private:
  std::filesystem::path path_;
};

/// One scene that has every table and every kind of key.
inline std::string scene_text() {
  return R"toml(schema = 1
[place]
latitude = "37.70 deg"
longitude = "-105.92 deg"
altitude = "2317 m"
north = "10 deg"
[time]
start = 2016-01-01T00:00:00Z
end = 2016-01-03T00:00:00Z
step = "10 min"
[weather]
file = "weather.csv"
stamp = "instant"
repeat = "none"
[sky]
longwave = "measured"
cloud = "from_longwave"
[[material]]
name = "armour"
solar_absorptance = 0.7
emissivity = "paint.csv"
convection = "mcadams"
layers = [{ conductivity = "45 W/m/K", density = "7800 kg/m3", heat_capacity = "480 J/kg/K", thickness = "20 mm" }]
inside = { kind = "film", h = "10 W/m2/K", temperature = "engine.csv" }
[[material]]
name = "soil"
solar_absorptance = "78 %"
emissivity = 0.95
convection = { h0 = "5 W/m2/K", h1 = "3.8 W/m2/K/(m/s)" }
layers = [
  { conductivity = "0.5 W/m/K", density = "1.6 g/cm3", heat_capacity = "0.9 kJ/kg/K", thickness = "1 m" },
  { conductivity = "2 W/m/K", density = "2600 kg/m3", heat_capacity = "800 J/kg/K", thickness = "2 m", source = "1e-6 W/m3" },
]
[[material]]
name = "canvas"
solar_absorptance = 0.6
emissivity = "bands.csv"
convection = "tarp"
wet_fraction = 0.1
layers = [{ conductivity = "0.2 W/m/K", density = "600 kg/m3", heat_capacity = "1500 J/kg/K", thickness = "0.5 mm" }]
inside = { kind = "sheet", solar_absorptance = 0.3 }
[[mesh]]
name = "vehicle"
file = "vehicle.obj"
unit = "1 mm"
[[mesh]]
name = "terrain"
file = "/data/terrain.ply"
[[region]]
mesh = "vehicle"
group = "power_top"
material = "armour"
[[region]]
mesh = "vehicle"
name = "tent"
mesh_material = "cloth"
material = "canvas"
[[region]]
mesh = "vehicle"
group = "others"
temperature = "30 degC"
[[region]]
mesh = "terrain"
material = "soil"
temperature = "facets.csv"
[ground]
material = "soil"
[camera]
position = ["14 m", "-12 m", "5 m"]
look_at = ["0 m", "0 m", "120 cm"]
)toml";
}

}  // namespace apps::scene::test
