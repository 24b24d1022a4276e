// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/scene_file/demo_scene_text.h"

#include <cmath>
#include <numbers>

#include "apps/scene/weather/weather_csv.h"
#include "radiometry/weather/demo_weather.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;

constexpr double kDegree = std::numbers::pi / 180.0;
const heat::Place kPlace{37.70 * kDegree, -105.92 * kDegree, 2317.0};
constexpr heat::CalendarDate kFirstDay{2026, 6, 21};
constexpr double kHours = 48.0;

/// To so many decimals: the model is no better, and the file stays readable.
double rounded(double value, double decimals) { return std::round(value * decimals) / decimals; }

}  // namespace

std::string demo_scene_text() {
  return R"(# A tracked vehicle on bare soil, two clear days of June in a high valley. All of it is made by this program: mesh,
# weather and schedule. Material properties are typical values: steel and rubber after Incropera and DeWitt, Fundamentals of
# Heat and Mass Transfer, appendix A; dry sandy soil after Oke, Boundary Layer Climates, table 2.1; dark matt paint after
# Howell, Menguc and Siegel, Thermal Radiation Heat Transfer, appendix B.
schema = 1

[place]
latitude = "37.70 deg"
longitude = "-105.92 deg"           # east positive
altitude = "2317 m"
north = "0 deg"                     # azimuth of +y; x east, z up

[time]
start = 2026-06-21T00:00:00Z
end = 2026-06-23T00:00:00Z
step = "10 min"

[weather]
file = "weather.csv"
stamp = "instant"

[sky]
longwave = "measured"
cloud = "from_longwave"

[atmosphere]                        # the air of pictures; the weather says how warm and moist it is near the ground
model = "mid_latitude_summer"
haze = "rural"

# Rolled armour with paint; behind it the fighting compartment, whose air does not move heat away.
[[material]]
name = "armour"
solar_absorptance = 0.75
emissivity = 0.92
convection = "mcadams"
layers = [{ conductivity = "45 W/m/K", density = "7800 kg/m3", heat_capacity = "480 J/kg/K", thickness = "20 mm" }]
inside = { kind = "adiabatic" }

# The same steel, thinner, above the engine: its air follows the schedule.
[[material]]
name = "engine_deck"
solar_absorptance = 0.75
emissivity = 0.92
convection = "mcadams"
layers = [{ conductivity = "45 W/m/K", density = "7800 kg/m3", heat_capacity = "480 J/kg/K", thickness = "8 mm" }]
inside = { kind = "film", h = "25 W/m2/K", temperature = "engine.csv" }

# Gun and turret: a thicker wall.
[[material]]
name = "turret"
solar_absorptance = 0.75
emissivity = 0.92
convection = "mcadams"
layers = [{ conductivity = "45 W/m/K", density = "7800 kg/m3", heat_capacity = "480 J/kg/K", thickness = "40 mm" }]
inside = { kind = "adiabatic" }

# Tracks and wheels: steel with a rubber coat, dusty.
[[material]]
name = "track"
solar_absorptance = 0.85
emissivity = 0.94
convection = "mcadams"
layers = [
  { conductivity = "0.16 W/m/K", density = "1150 kg/m3", heat_capacity = "2000 J/kg/K", thickness = "10 mm" },
  { conductivity = "45 W/m/K", density = "7800 kg/m3", heat_capacity = "480 J/kg/K", thickness = "30 mm" },
]
inside = { kind = "adiabatic" }

# Dry soil, twelve times as deep as the day's temperature wave.
[[material]]
name = "soil"
solar_absorptance = 0.78
emissivity = 0.95
convection = "mcadams"
layers = [{ conductivity = "0.3 W/m/K", density = "1600 kg/m3", heat_capacity = "800 J/kg/K", thickness = "1 m" }]
inside = { kind = "adiabatic" }

[[mesh]]
name = "vehicle"
file = "vehicle.obj"
unit = "1 m"

[[mesh]]
name = "terrain"
file = "terrain.obj"
unit = "1 m"

[[region]]
mesh = "vehicle"
group = "firing_part"
material = "turret"

[[region]]
mesh = "vehicle"
group = "driving_part"
material = "track"

[[region]]
mesh = "vehicle"
group = "power_top"
material = "engine_deck"

[[region]]
mesh = "vehicle"
group = "others"
material = "armour"

[[region]]
mesh = "terrain"
material = "soil"

[ground]
material = "soil"

[camera]
position = ["54 m", "-46 m", "14 m"]
look_at = ["0 m", "0 m", "1.2 m"]
)";
}

std::string demo_mwir_text() {
  return R"(# A cooled MWIR camera: InSb behind an F/4 cold stop. Typical numbers, not those of a product.
schema = 2
name = "MWIR cooled"

[frame]
focal_length = "120 mm"
pitch = "24 um"
format = [512, 320]
integration_time = "6 ms"

[optics]
f_number = 4.0
transmission = 0.85
emissivity = 0.1
temperature = "285 K"
stop_temperature = "77 K"       # the cold shield: it gives next to nothing

[band]
wavelength = ["3.7 um", "4.8 um"]

[[presample]]
kind = "diffraction"

[[presample]]
kind = "rms_wavefront"
rms = 0.07
wavelength_reference = "4 um"

[[presample]]
kind = "footprint"
fill_factor = 0.9

[[presample]]
kind = "jitter"
rms = "40 urad"

[detector]
quantum_efficiency = 0.8
full_well = "12 Me-"
dark_current = "5 Me-/s"
read_noise = "600 e-"

[nonuniformity]
prnu = 0.0005                   # what the two-point correction leaves
dsnu = "500 e-"

[noise]
seed = 1

[adc]
bits = 14
)";
}

std::string demo_lwir_text() {
  return R"(# An uncooled LWIR camera of the same field of view: microbolometers behind an F/1.2 lens. Typical numbers.
schema = 2
name = "LWIR uncooled"

[frame]
focal_length = "85 mm"
pitch = "17 um"
format = [512, 320]

[optics]
f_number = 1.2
transmission = 0.85
emissivity = 0.1
temperature = "285 K"
stop_temperature = "285 K"      # no cold shield: the housing is seen around the lens

[band]
wavelength = ["8 um", "13 um"]

[[presample]]
kind = "diffraction"

[[presample]]
kind = "rms_wavefront"
rms = 0.07
wavelength_reference = "10 um"

[[presample]]
kind = "footprint"
fill_factor = 0.85

[[presample]]
kind = "jitter"
rms = "40 urad"

[detector]
kind = "thermal"
absorptance = 0.8
responsivity = 1e5              # V/W of incident power
shutter_temperature = "285 K"   # offsets are taken from it
netd = "40 mK"
netd_f_number = 1.0
netd_transmission = 1.0
netd_temperature = "300 K"

[nonuniformity]
prnu = 1e-3
dsnu = "100 nV"

[noise]
seed = 1

[adc]
bits = 14
volts_per_count = "0.1 uV"
offset = 4000
)";
}

std::string demo_weather_text() {
  const double start = heat::instant_of(kFirstDay);
  heat::Weather weather = heat::demo_weather(kPlace, start, start + 3600.0 * kHours, 600.0);
  for (auto& values : weather.values)
    for (double& value : values) value = rounded(value, 100.0);
  return weather_csv(weather,
                     {"Two clear days by a model, not measured: Bird and Hulstrom's clear sky, a daily wave of",
                      "temperature and wind, constant vapour, Brutsaert's long wave."});
}

std::string demo_engine_text() {
  return R"(# Air in the engine bay: cold, two runs of the engine a day (11 to 13 h and 17 to 18 h UTC), slow cooling between them.
time (h),temperature (degC)
0,18
11,15
11.5,70
13,85
14,50
17,30
17.5,75
18,85
20,40
24,18
35,15
35.5,70
37,85
38,50
41,30
41.5,75
42,85
44,40
48,18
)";
}

}  // namespace apps::scene
