// SPDX-License-Identifier: Apache-2.0
#pragma once

// A camera and studies of its ranges.

#include <array>
#include <map>
#include <string>

#include "radiometry/light/blackbody.h"
#include "tests/apps/study/evaluated.h"

namespace study_test {

inline const std::string kFog = R"([atmosphere]
model = "mid_latitude_summer"
haze = "advection_fog"
visibility = "300 m"
)";
inline const std::string kConditions = R"([conditions]
contrast = "1 K"
target_size = "2.3 m"
frame_rate = "60 Hz"
magnification = 5.0
)";
inline const std::array<std::string, 6> kRanges{"johnson_range_detect",   "johnson_range_recognise",
                                                "johnson_range_identify", "ttp_range_detect",
                                                "ttp_range_recognise",    "ttp_range_identify"};

/// An MWIR camera at f/2, whose read noise stands for a converter of 14 bits that noise dithers; `air`: tables after
/// the others.
inline std::string camera(const std::string& air) {
  return R"(schema = 1
[frame]
focal_length = "150 mm"
pitch = "15 um"
integration_time = "5 ms"
format = [640, 512]
[scene]
quantity = "temperature"
emissivity = 0.95
surroundings = "280 K"
[optics]
f_number = 2.0
transmission = 0.85
emissivity = 0.1
temperature = "293 K"
stop_temperature = "77 K"
obscuration = 0.2
[band]
wavelength = ["3.4 um", "4.8 um"]
[detector]
quantum_efficiency = 0.7
full_well = "400 Me-"
dark_current = "1 Me-/s"
read_noise = "7054.544717 e-"
[nonuniformity]
prnu = 0.0005
dsnu = "100 e-"
[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
fill_factor = 0.9
[[presample]]
kind = "jitter"
rms_x = "15 urad"
rms_y = "10 urad"
)" + air;
}

inline std::string study_of(const std::string& axes, const std::string& conditions = kConditions,
                            const std::string& tolerance = "1e-6", const std::string& metrics = "") {
  std::string list = metrics;
  if (list.empty())
    for (const std::string& name : kRanges) list += (list.empty() ? "\"" : ", \"") + name + "\"";
  return "schema = 1\nname = \"ranges\"\nsensor = \"camera.toml\"\ntolerance = " + tolerance + "\n" + axes +
         "[metrics]\nlist = [" + list + "]\n" + conditions;
}

inline std::string axis(const std::string& parameter, const std::string& values) {
  return "[[axis]]\nparameter = \"" + parameter + "\"\nvalues = [" + values + "]\n";
}
inline const std::string kTime = axis("frame.integration_time", R"("5 ms")");

inline std::map<std::string, double> ranges_of(const Folder& folder, const std::string& text, std::int64_t design = 0) {
  Evaluated e = evaluated(folder, text);
  e.at(design);
  EXPECT_EQ(e.evaluator->last_problem(), "");
  std::map<std::string, double> found{{"error", e["error"]}};
  for (const std::string& name : kRanges) found[name] = e[name];
  return found;
}

/// A table of paths that obey Beer's law and radiate as a black scene of 300 K would through what they absorb.
inline std::string beer_table(double per_km, const std::vector<double>& ranges_m, bool radiates) {
  std::string text = "range_m,wavelength_um,transmission,radiance_W_m-2_sr-1_um-1\n";
  for (const double range : ranges_m)
    for (int i = 0; i <= 160; ++i) {
      const double um = 3.3 + 0.01 * i, tau = std::exp(-1e-3 * per_km * range);
      const double planck = radiometry::planck(radiometry::Flux::watts, um, 300.0);
      text += mtf::format_double(range) + "," + mtf::format_double(um) + "," + mtf::format_double(tau) + "," +
              mtf::format_double(radiates ? (1.0 - tau) * planck : 0.0) + "\n";
    }
  return text;
}

}  // namespace study_test
