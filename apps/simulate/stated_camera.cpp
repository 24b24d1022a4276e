// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/stated_camera.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/words.h"

namespace apps {

std::optional<StatedCamera> stated_camera(const std::map<std::string, std::string>& attributes) {
  const auto read = [&](const char* name, double& value) {
    const auto found = attributes.find(name);
    if (found == attributes.end()) return false;
    value = mtf::io::cell_number(found->second.substr(0, found->second.find(' '))).value_or(std::nan(""));
    return true;
  };
  StatedCamera stated;
  auto& [camera, assumed, left_out, no_emissivity] = stated;
  if (!(read("camera_counts.R1", camera.r1) && read("camera_counts.B", camera.b_k) &&
        read("camera_counts.F", camera.f) && read("camera_counts.O", camera.o) && read("camera_counts.R2", camera.r2)))
    return std::nullopt;
  const auto take = [&](const char* name, const std::string& words, double most, double& to, std::string& out) {
    double value = to;
    if (!read(name, value)) return;
    if (value > 0.0 && value <= most)
      to = value;
    else
      out += "; the file's " + words + " " + attributes.at(name) + ", outside of (0, " + mtf::significant(most, 3) +
             "], is left out";
  };
  constexpr double hottest_k = 1e5;
  take("scene.emissivity", "emissivity", 1.0, assumed.emissivity, no_emissivity);
  take("scene.surroundings", "temperature of the surroundings", hottest_k, assumed.reflected_k, left_out);
  take("flir.window_transmission", "transmission of the window", 1.0, assumed.window_transmission, left_out);
  take("flir.window_temperature", "temperature of the window", hottest_k, assumed.window_k, left_out);
  take("flir.air_temperature", "temperature of the air", hottest_k, assumed.air_k, left_out);
  radiometry::CountAir air;
  if (read("flir.distance", air.distance_m) && read("flir.air_temperature", air.air_k) &&
      read("flir.relative_humidity", air.humidity) && read("flir.alpha1", air.alpha1) &&
      read("flir.alpha2", air.alpha2) && read("flir.beta1", air.beta1) && read("flir.beta2", air.beta2) &&
      read("flir.X", air.x)) {
    const double t = air.humidity >= 0.0 && air.humidity <= 1.0 ? transmission_of(air) : std::nan("");
    if (std::isnan(t))
      left_out += "; the file's air, of distance " + attributes.at("flir.distance") + ", temperature " +
                  attributes.at("flir.air_temperature") + " and humidity " + attributes.at("flir.relative_humidity") +
                  ", has no transmission in (0, 1] and is left out";
    else
      assumed.transmission = t;
  }
  return stated;
}

void require_camera(const std::string& file, const radiometry::CountCamera& camera) {
  try {
    radiometry::require_valid(file + ": camera_counts", camera);
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError(std::string(error.what()) +
                          "; give the camera's constants in [camera_counts] of the sensor file");
  }
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

std::string clipped_counts(const mtf::io::FileInfo& info, const std::string& name, mtf::ImageView<const float> counts,
                           const mtf::io::IntegerScaling& scaling) {
  const auto channel = std::ranges::find(info.channels, name, &mtf::io::ChannelInfo::name);
  if (channel == info.channels.end() || channel->type != "uint16") return "";
  const auto scaled = [&](double stored) { return static_cast<float>(scaling.gain * stored + scaling.offset); };
  const float least = scaled(0.0), most = scaled(info.largest > 0.0 ? info.largest : 65535.0);
  std::int64_t clipped = 0;
  for (std::int64_t y = 0; y < counts.height; ++y)
    for (std::int64_t x = 0; x < counts.width; ++x) clipped += counts.at(x, y) == least || counts.at(x, y) == most;
  if (clipped == 0) return "";
  return std::to_string(clipped) + " of " + std::to_string(counts.width * counts.height) +
         " counts stand at an end of the scale (" + mtf::significant(least, 6) + " or " + mtf::significant(most, 6) +
         "): what they saw lies beyond the temperatures that they become; take the image in a range of the camera that "
         "holds the scene, or leave these pixels out";
}

}  // namespace apps
