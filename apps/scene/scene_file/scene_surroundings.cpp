// SPDX-License-Identifier: Apache-2.0

// [place], [time], [weather] and [sky] of a scene file.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/scene/scene_file/scene_fields.h"
#include "apps/scene/scene_file/scene_reader.h"
#include "mtf/io/file_checks.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace cfg = mtf::io::cfg;
namespace heat = radiometry::heat;
using cfg::Node;
using cfg::Section;
using heat::WeatherQuantity;
using mtf::FieldInfo;
using enum WeatherQuantity;

/// An instant as a TOML date and time, or the same in quotes.
std::optional<double> read_instant(const Section& section, std::string_view key) {
  const Node* node = section.find(key);
  const std::string example = "write for example " + std::string(key) + " = 2016-01-01T00:00:00Z";
  if (node == nullptr) {
    section.error(key, "missing; " + example);
    return std::nullopt;
  }
  if (node->kind != Node::Kind::date && node->kind != Node::Kind::string) {
    section.error(key, std::string(cfg::kind_word(node->kind)) + " where a date and time belongs; " + example);
    return std::nullopt;
  }
  heat::InstantError error;
  const auto instant = heat::parse_instant(node->text, error);
  if (!instant) section.error(key, mtf::io::printable(node->text, 60) + ": " + error.text);
  return instant;
}

std::vector<std::string_view> constant_keys() {
  std::vector<std::string_view> keys{kHumidity.name};
  for (const FieldInfo& field : kConstants) keys.push_back(field.name);
  return keys;
}

/// Changes of a file's records; what stands there beside constant values is refused.
void read_weather_change(SceneReader& s, const Section& section, bool has_file) {
  const auto& [air, wind, sun, sky] = kWeatherChanges;
  for (const FieldInfo& field : kWeatherChanges)
    if (!has_file && section.find(field.name) != nullptr)
      section.error(field.name, "changes the records of a file; of constant weather change the values themselves");
  WeatherChange& change = s.scene.weather.change;
  change.air_temperature_offset_k = read_si(section, air).value_or(change.air_temperature_offset_k);
  change.wind_speed_factor = read_si(section, wind).value_or(change.wind_speed_factor);
  change.solar_factor = read_si(section, sun).value_or(change.solar_factor);
  change.longwave_down_offset_w_m2 = read_si(section, sky).value_or(change.longwave_down_offset_w_m2);
}

/// One record of the values; the relative humidity becomes the vapour pressure.
void read_constant_weather(SceneReader& s, const Section& section) {
  heat::Weather& weather = s.scene.weather.constant;
  weather.source = s.scene.file;
  weather.time_s = {s.scene.time.start_s};
  for (std::size_t q = 0; q < kConstants.size(); ++q)
    if (const auto value = read_si(section, kConstants[q])) weather.values[q] = {*value};
  const auto humidity = read_si(section, kHumidity);
  if (!humidity) return;
  if (weather.has(vapour_pressure))
    section.error(kHumidity.name, "given together with vapour_pressure; remove one of them");
  else if (!weather.has(air_temperature))
    section.error(kHumidity.name, "needs air_temperature = \"15 degC\" beside it");
  else
    weather[vapour_pressure] = {*humidity * heat::saturation_pressure_pa(weather[air_temperature].front())};
}

}  // namespace

void read_place(SceneReader& s) {
  const Node* table = find_section(s, "place", "write [place] with latitude, longitude and altitude");
  if (table == nullptr) return;
  const Section section{s.reader, *table, "place", "[place]"};
  cfg::check_keys(section, kPlaceKeys);
  constexpr double degree = std::numbers::pi / 180.0;
  s.scene.place.latitude_rad = degree * read_si(section, kLatitude).value_or(0.0);
  s.scene.place.longitude_rad = degree * read_si(section, kLongitude).value_or(0.0);
  s.scene.north_rad = degree * read_si(section, kNorth).value_or(0.0);
  s.scene.place.altitude_m = read_si(section, kAltitude).value_or(0.0);
}

void read_time(SceneReader& s) {
  constexpr double kMostOutputs = 1e6;
  const Node* table = find_section(s, "time", "write [time] with start, end and step");
  if (table == nullptr) return;
  const Section section{s.reader, *table, "time", "[time]"};
  cfg::check_keys(section, kTimeKeys);
  TimeSection& time = s.scene.time;
  const auto start = read_instant(section, "start"), end = read_instant(section, "end");
  const auto step = read_si(section, kStep);
  time.step_s = step.value_or(time.step_s);
  time.start_s = start.value_or(0.0);
  time.end_s = end.value_or(0.0);
  for (const auto& [key, instant] : {std::pair{"start", start}, std::pair{"end", end}})
    if (instant && !(*instant >= heat::instant_of({1900, 1, 1}) && *instant <= heat::instant_of({2101, 1, 1})))
      section.error(key, "the sun is known for the years 1900 to 2100");
  if (!start || !end || (section.find("step") != nullptr && !step)) return;
  const double steps = (*end - *start) / time.step_s;
  if (!(*end > *start))
    section.error("end", "the end is not after the start");
  else if (steps > kMostOutputs)
    section.error("step", "more than a million output times; take longer steps");
  else if (std::abs(steps - std::round(steps)) > 1e-6 || steps < 0.5)
    section.error("step", "the step is no divisor of the time from start to end");
}

void read_weather_section(SceneReader& s) {
  const Node* table = find_section(s, "weather", "write [weather] with file = \"weather.csv\", or constant values");
  if (table == nullptr) return;
  const Section section{s.reader, *table, "weather", "[weather]"};
  std::vector<std::string_view> known(kWeatherKeys.begin(), kWeatherKeys.end());
  const auto constants = constant_keys();
  known.insert(known.end(), constants.begin(), constants.end());
  for (const FieldInfo& field : kWeatherChanges) known.push_back(field.name);
  cfg::check_keys(section, known);
  WeatherSection& weather = s.scene.weather;
  if (const auto stamp = cfg::read_word(section, "stamp", heat::kStampNames))
    weather.stamp = static_cast<heat::Stamp>(*stamp);
  if (const auto repeat = cfg::read_word(section, "repeat", heat::kRepeatNames))
    weather.repeat = static_cast<heat::Repeat>(*repeat);
  weather.longest_bridge_s = read_si(section, kBridge).value_or(weather.longest_bridge_s);
  weather.average_s = read_si(section, kAverage).value_or(weather.average_s);
  weather.file = read_path(section, "file").value_or("");
  if (const Node* file = section.find("file")) weather.file_at = file->position;
  read_weather_change(s, section, section.find("file") != nullptr || s.reader.has_failed("weather.file"));
  const auto constant = std::find_if(constants.begin(), constants.end(),
                                     [&](std::string_view key) { return section.find(key) != nullptr; });
  if (constant == constants.end()) {
    if (section.find("file") == nullptr && !s.reader.has_failed("weather.file"))
      section.error("file",
                    "missing; write for example file = \"weather.csv\", or constant values such as "
                    "air_temperature = \"15 degC\"");
  } else if (section.find("file") != nullptr) {
    section.error(*constant, "a constant value beside a file; remove one of them");
  } else {
    read_constant_weather(s, section);
  }
}

void read_sky(SceneReader& s) {
  const Node* table = find_section(s, "sky", "");
  if (table == nullptr) return;
  const Section section{s.reader, *table, "sky", "[sky]"};
  cfg::check_keys(section, kSkyKeys);
  SkySection& sky = s.scene.sky;
  if (const auto word = cfg::read_word(section, "longwave", kLongwaveNames))
    sky.longwave = static_cast<LongwaveModel>(*word);
  const Node* cloud = section.find("cloud");
  if (cloud == nullptr) return;
  if (cloud->kind == Node::Kind::string && !cloud->text.ends_with("%")) {
    if (const auto word = cfg::read_word(section, "cloud", kCloudWords)) sky.cloud = static_cast<CloudSource>(*word);
  } else if (const auto cover = read_si(section, kCloud)) {
    sky.cloud = CloudSource::constant;
    sky.cloud_cover = *cover;
  }
}

}  // namespace apps::scene
