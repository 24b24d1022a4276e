// SPDX-License-Identifier: Apache-2.0
#pragma once

// Scenes of a few plates from text to temperatures, for the tests of whole runs.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "apps/scene/heat/read_thermal_scene.h"
#include "radiometry/light/constants.h"
#include "tests/apps/scene/weather_texts.h"
#include "tests/apps/study/temp_folder.h"

namespace apps::scene::test {

inline constexpr double kSigma = radiometry::kStefanBoltzmann_w_m2_k4;

/// A level plate of 1 m, facing up at a height of `z`.
inline std::string plate(double z, int first = 1, const std::string& group = "plate") {
  std::string text = "g " + group + "\n";
  for (const auto& [x, y] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{1, 1}, std::pair{0, 1}})
    text += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z) + "\n";
  text += "f";
  for (int i = 0; i < 4; ++i) text += " " + std::to_string(first + i);
  return text + "\n";
}

inline const std::string kSky = "[sky]\nlongwave = \"measured\"\n";
inline const std::string kDay = "[time]\nstart = 2016-03-20T00:00:00Z\nend = 2016-03-21T00:00:00Z\nstep = \"1 h\"\n";

inline std::string weather(double air_k, double wind, double direct, double diffuse, double longwave) {
  return "[weather]\nair_temperature = \"" + std::to_string(air_k) + " K\"\nwind_speed = \"" + std::to_string(wind) +
         " m/s\"\ndirect_normal = \"" + std::to_string(direct) + " W/m2\"\ndiffuse_horizontal = \"" +
         std::to_string(diffuse) + " W/m2\"\nlongwave_down = \"" + std::to_string(longwave) + " W/m2\"\n";
}

inline std::string material(const std::string& name, double absorptance, double emissivity,
                            const std::string& convection, const std::string& rest = "") {
  return "[[material]]\nname = \"" + name + "\"\nsolar_absorptance = " + std::to_string(absorptance) +
         "\nemissivity = " + std::to_string(emissivity) + "\nconvection = " + convection +
         "\nlayers = [{ conductivity = \"45 W/m/K\", density = \"7800 kg/m3\", heat_capacity = \"480 J/kg/K\", "
         "thickness = \"5 mm\" }]\n" +
         rest;
}

struct Outcome {
  HeatReport report;
  std::vector<double> times_s;
  std::vector<std::vector<double>> front, back;  ///< [output][facet]
};

class HeatRun : public testing::Test {
 protected:
  HeatScene prepare(const std::string& text, const std::string& obj, const HeatOptions& options = {}) {
    std::ofstream(folder_ / "plates.obj") << obj;
    std::ofstream(folder_ / "scene.toml") << "schema = 1\n[place]\nlatitude = \"0 deg\"\nlongitude = \"0 deg\"\n"
                                             "altitude = \"0 m\"\n"
                                          << text;
    return prepare_heat(load_scene((folder_ / "scene.toml").string()), options);
  }

  Outcome run(const std::string& text, const std::string& obj, const HeatOptions& options = {}) {
    const HeatScene scene = prepare(text, obj, options);
    Outcome outcome;
    outcome.report = run_heat(
        scene, options,
        [&](const HeatOutput& output) {
          outcome.times_s.push_back(output.time_s);
          outcome.front.emplace_back(output.front_k.begin(), output.front_k.end());
          outcome.back.emplace_back(output.back_k.begin(), output.back_k.end());
        },
        [](const std::string&, double) {});
    return outcome;
  }

  study_test::TempFolder folder_;
};

inline std::string region(const std::string& group, const std::string& rest) {
  return "[[region]]\nmesh = \"plates\"\n" + (group.empty() ? "" : "group = \"" + group + "\"\n") + rest + "\n";
}
inline const std::string kMesh = "[[mesh]]\nname = \"plates\"\nfile = \"plates.obj\"\nunit = \"1 m\"\n";

/// eps L + a D = eps sigma T^4 + h (T - air), by bisection.
inline double equilibrium(double absorbed, double emissivity, double h, double air_k) {
  double low = 1.0, high = 1000.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (absorbed > emissivity * kSigma * std::pow(middle, 4) + h * (middle - air_k) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace apps::scene::test
