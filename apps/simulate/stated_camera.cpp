// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/stated_camera.h"

#include <algorithm>
#include <cmath>

#include "mtf/components/field_access.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace apps {
namespace {

using radiometry::FieldInfo;

/// "+- 2 K" as well as "293 K"; throws UsageError without a word on the key.
double number_of(const FieldInfo& info, std::string_view text, bool is_sd) {
  double value = std::nan("");
  if (info.dimension == mtf::Dimension::none) {
    value = mtf::io::cell_number(text).value_or(std::nan(""));
    if (!std::isfinite(value)) throw mtf::UsageError("'" + mtf::printable(text, 40) + "' is no number");
  } else {
    const bool kelvin = info.dimension == mtf::Dimension::temperature;
    value = mtf::convert(
        mtf::parse_quantity(text, is_sd && kelvin ? mtf::Dimension::temperature_difference : info.dimension),
        info.unit);
  }
  if (is_sd && !(value > 0.0)) throw mtf::UsageError("a standard deviation is above 0");
  if (!is_sd && !in_range(info, value)) throw mtf::UsageError(outside_text(info, value, info.unit));
  return value;
}

/// Takes the words of one key; false where it is of none.
bool take_number(StatedCamera& stated, std::string_view key, std::string_view text) {
  std::size_t i = 0;
  bool found = false;
  for_each_field(stated.told, [&](const FieldInfo& info, double& number) {
    double& sd = stated.sd[i++];
    if (info.name != key) return;
    found = true;
    const std::size_t sign = text.find("+-");
    const std::string_view value = mtf::trimmed(text.substr(0, sign));
    if (!value.empty() || sign == std::string_view::npos) number = number_of(info, value, false);
    if (sign != std::string_view::npos) sd = number_of(info, mtf::trimmed(text.substr(sign + 2)), true);
  });
  return found;
}

}  // namespace

std::optional<StatedCamera> stated_camera(const std::map<std::string, std::string>& attributes) {
  const auto read = [&](const char* name, double& value) {
    const auto found = attributes.find(name);
    if (found == attributes.end()) return false;
    value = mtf::io::cell_number(found->second.substr(0, found->second.find(' '))).value_or(std::nan(""));
    return true;
  };
  StatedCamera stated;
  auto& [camera, told, air, sd, left_out, no_emissivity] = stated;
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
  take("scene.emissivity", "emissivity", 1.0, told.emissivity, no_emissivity);
  take("scene.surroundings", "temperature of the surroundings", hottest_k, told.surroundings_k, left_out);
  take("flir.window_transmission", "transmission of the window", 1.0, told.window_transmission, left_out);
  take("flir.window_temperature", "temperature of the window", hottest_k, told.window_k, left_out);
  take("flir.air_temperature", "temperature of the air", hottest_k, told.air_k, left_out);
  radiometry::CountAir stored;
  if (read("flir.distance", stored.distance_m) && read("flir.air_temperature", stored.air_k) &&
      read("flir.relative_humidity", stored.humidity) && read("flir.alpha1", stored.alpha1) &&
      read("flir.alpha2", stored.alpha2) && read("flir.beta1", stored.beta1) && read("flir.beta2", stored.beta2) &&
      read("flir.X", stored.x)) {
    const bool possible = stored.humidity >= 0.0 && stored.humidity <= 1.0 && stored.air_k == told.air_k;
    if (!possible || std::isnan(transmission_of(stored))) {
      left_out += "; the file's air, of distance " + attributes.at("flir.distance") + ", temperature " +
                  attributes.at("flir.air_temperature") + " and humidity " + attributes.at("flir.relative_humidity") +
                  ", has no transmission in (0, 1] and is left out";
    } else {
      air = stored;
      told.distance_m = stored.distance_m, told.humidity = stored.humidity;
    }
  }
  return stated;
}

void assume(StatedCamera& stated, std::span<const std::string> words) {
  for (const std::string& word : words) {
    const std::size_t equals = std::min(word.find('='), word.size());
    const std::string key(mtf::trimmed(word.substr(0, equals)));
    try {
      const bool of_air = key == "distance" || key == "air_temperature" || key == "relative_humidity";
      if (of_air && !stated.air)
        throw mtf::UsageError("the file has no constants of an air that can be, which counts nothing; leave it out");
      if (equals == word.size() || !take_number(stated, key, std::string_view(word).substr(equals + 1))) {
        std::string names;
        for_each_field(stated.told, [&](const FieldInfo& info, double&) { names += " " + std::string(info.name); });
        throw mtf::UsageError(
            "write KEY=VALUE, KEY=VALUE +- SD or KEY=+- SD, such as \"surroundings=293 K +- 2 K\", KEY one of" + names);
      }
      if (std::isnan(stated.assumed().transmission))
        throw mtf::UsageError("such air has no transmission in (0, 1]; give another distance or humidity");
    } catch (const mtf::UsageError& error) {
      throw mtf::UsageError("assumed " + mtf::printable(word, 80) + ": " + error.what());
    }
  }
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
