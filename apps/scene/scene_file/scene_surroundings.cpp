// SPDX-License-Identifier: Apache-2.0

// [place], [time], [weather] and [sky] of a scene file.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/scene/scene_file/scene_reader.h"
#include "mtf/io/file_checks.h"
#include "radiometry/heat/weather/instant.h"

namespace apps::scene {
namespace {

namespace cfg = mtf::io::cfg;
namespace heat = radiometry::heat;
using cfg::Node;
using cfg::Section;
using heat::WeatherQuantity;
using mtf::FieldInfo;
using mtf::Presence;
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

constexpr FieldInfo constant_field(WeatherQuantity quantity, std::string_view unit, double lo, double hi,
                                   std::string_view example) {
  return {.name = heat::quantity_name(quantity),
          .unit = unit,
          .lo = lo,
          .hi = hi,
          .presence = Presence::optional,
          .example = example};
}

/// Constant values that [weather] may have, in the order of WeatherQuantity.
constexpr std::array kConstants{
    constant_field(air_temperature, "K", 178.15, 338.15, "\"15 degC\""),
    constant_field(wind_speed, "m/s", 0.0, 120.0, "\"3 m/s\""),
    constant_field(vapour_pressure, "Pa", 0.0, 12000.0, "\"8 hPa\""),
    constant_field(pressure, "Pa", 20e3, 115e3, "\"1013 hPa\""),
    constant_field(direct_normal, "W/m2", 0.0, 1500.0, "\"800 W/m2\""),
    constant_field(diffuse_horizontal, "W/m2", 0.0, 1500.0, "\"100 W/m2\""),
    constant_field(global_horizontal, "W/m2", 0.0, 1500.0, "\"600 W/m2\""),
    constant_field(longwave_down, "W/m2", 30.0, 700.0, "\"300 W/m2\""),
    constant_field(cloud_cover, "", 0.0, 1.0, "0.3"),
};
static_assert(kConstants.back().name == heat::quantity_name(static_cast<WeatherQuantity>(kConstants.size() - 1)));
constexpr FieldInfo kHumidity{
    .name = "relative_humidity", .lo = 0.0, .hi = 1.1, .presence = Presence::optional, .example = "\"50 %\""};

std::vector<std::string_view> constant_keys() {
  std::vector<std::string_view> keys{kHumidity.name};
  for (const FieldInfo& field : kConstants) keys.push_back(field.name);
  return keys;
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
  cfg::check_keys(section, std::array<std::string_view, 4>{"latitude", "longitude", "altitude", "north"});
  const auto angle = [&](std::string_view name, double most, Presence presence, std::string_view example,
                         std::string_view doc) {
    constexpr double degree = std::numbers::pi / 180.0;
    const FieldInfo field{
        .name = name, .unit = "deg", .lo = -most, .hi = most, .presence = presence, .example = example, .doc = doc};
    return degree * read_si(section, field).value_or(0.0);
  };
  s.scene.place.latitude_rad = angle("latitude", 90.0, Presence::required, "\"37.70 deg\"", "north positive");
  s.scene.place.longitude_rad = angle("longitude", 360.0, Presence::required, "\"-105.92 deg\"", "east positive");
  s.scene.north_rad = angle("north", 360.0, Presence::optional, "\"0 deg\"", "azimuth of +y");
  s.scene.place.altitude_m = read_si(section, {.name = "altitude",
                                               .unit = "m",
                                               .lo = -500.0,
                                               .hi = 9000.0,
                                               .example = "\"2317 m\"",
                                               .doc = "above the sea"})
                                 .value_or(0.0);
}

void read_time(SceneReader& s) {
  constexpr double kMostOutputs = 1e6;
  const Node* table = find_section(s, "time", "write [time] with start, end and step");
  if (table == nullptr) return;
  const Section section{s.reader, *table, "time", "[time]"};
  cfg::check_keys(section, std::array<std::string_view, 3>{"start", "end", "step"});
  TimeSection& time = s.scene.time;
  const auto start = read_instant(section, "start"), end = read_instant(section, "end");
  const auto step = read_si(section, {.name = "step",
                                      .unit = "s",
                                      .lo = 0.1,
                                      .hi = heat::kDay_s,
                                      .presence = Presence::optional,
                                      .example = "\"10 min\""});
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
  std::vector<std::string_view> known{"file", "stamp", "repeat", "bridge", "average"};
  const auto constants = constant_keys();
  known.insert(known.end(), constants.begin(), constants.end());
  cfg::check_keys(section, known);
  WeatherSection& weather = s.scene.weather;
  if (const auto stamp = cfg::read_word(section, "stamp", heat::kStampNames))
    weather.stamp = static_cast<heat::Stamp>(*stamp);
  if (const auto repeat = cfg::read_word(section, "repeat", heat::kRepeatNames))
    weather.repeat = static_cast<heat::Repeat>(*repeat);
  weather.longest_bridge_s = read_si(section, {.name = "bridge",
                                               .unit = "s",
                                               .lo = 0.0,
                                               .hi = heat::kDay_s,
                                               .presence = Presence::optional,
                                               .example = "\"1 h\""})
                                 .value_or(weather.longest_bridge_s);
  weather.average_s = read_si(section, {.name = "average",
                                        .unit = "s",
                                        .lo = 0.0,
                                        .hi = heat::kDay_s,
                                        .presence = Presence::optional,
                                        .example = "\"5 min\""})
                          .value_or(weather.average_s);
  weather.file = read_path(section, "file").value_or("");
  if (const Node* file = section.find("file")) weather.file_at = file->position;
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
  cfg::check_keys(section, std::array<std::string_view, 2>{"longwave", "cloud"});
  SkySection& sky = s.scene.sky;
  if (const auto word = cfg::read_word(section, "longwave", kLongwaveNames))
    sky.longwave = static_cast<LongwaveModel>(*word);
  const Node* cloud = section.find("cloud");
  if (cloud == nullptr) return;
  if (cloud->kind == Node::Kind::string && !cloud->text.ends_with("%")) {
    constexpr std::span<const std::string_view> words = std::span(kCloudNames).first(3);  // a constant is a number
    if (const auto word = cfg::read_word(section, "cloud", words)) sky.cloud = static_cast<CloudSource>(*word);
  } else if (const auto cover = read_si(section, {.name = "cloud", .lo = 0.0, .hi = 1.0, .example = "0.3"})) {
    sky.cloud = CloudSource::constant;
    sky.cloud_cover = *cover;
  }
}

}  // namespace apps::scene
