// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/stated_camera.h"

#include <cmath>

#include "mtf/io/csv/csv_cells.h"
#include "mtf/words.h"

namespace apps {

std::optional<StatedCamera> stated_camera(const std::map<std::string, std::string>& attributes) {
  const auto read = [&](const char* name, double& value) {
    const auto found = attributes.find(name);
    if (found == attributes.end()) return false;
    const auto number = mtf::io::cell_number(found->second.substr(0, found->second.find(' ')));
    if (number) value = *number;
    return number.has_value();
  };
  StatedCamera stated;
  auto& [camera, assumed] = stated;
  if (!(read("camera_counts.R1", camera.r1) && read("camera_counts.B", camera.b_k) &&
        read("camera_counts.F", camera.f) && read("camera_counts.O", camera.o) && read("camera_counts.R2", camera.r2)))
    return std::nullopt;
  read("scene.emissivity", assumed.emissivity);
  read("scene.surroundings", assumed.reflected_k);
  if (double w = 1.0; read("flir.window_transmission", w) && w > 0.0 && w <= 1.0) assumed.window_transmission = w;
  read("flir.window_temperature", assumed.window_k);
  radiometry::CountAir air;
  const bool known = read("flir.distance", air.distance_m) && read("flir.air_temperature", air.air_k) &&
                     read("flir.relative_humidity", air.humidity) && read("flir.alpha1", air.alpha1) &&
                     read("flir.alpha2", air.alpha2) && read("flir.beta1", air.beta1) &&
                     read("flir.beta2", air.beta2) && read("flir.X", air.x);
  assumed.air_k = air.air_k;
  if (const double t = known ? transmission_of(air) : 1.0; !std::isnan(t)) assumed.transmission = t;
  return stated;
}

std::string thermometry_words(const radiometry::Thermometry& assumed) {
  const auto number = [](double value) { return mtf::significant(value, 6); };
  std::string text = "emissivity " + number(assumed.emissivity) + ", reflected " + number(assumed.reflected_k) +
                     " K, transmission of the air " + number(assumed.transmission) + " at " + number(assumed.air_k) +
                     " K";
  if (assumed.window_transmission != 1.0)
    text += ", of the window " + number(assumed.window_transmission) + " at " + number(assumed.window_k) + " K";
  return text;
}

}  // namespace apps
