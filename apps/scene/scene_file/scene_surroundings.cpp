// SPDX-License-Identifier: Apache-2.0

// [place], [time], [weather] and [sky] of a scene file.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/scene/scene_file/scene_reader.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;
using enum WeatherQuantity;

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
  const auto section = find_section(s, "place", "write [place] with latitude, longitude and altitude");
  if (!section) return;
  PlaceSection place;
  read_table(s, *section, place);
  constexpr double degree = std::numbers::pi / 180.0;
  s.scene.place = {.latitude_rad = degree * place.latitude_deg,
                   .longitude_rad = degree * place.longitude_deg,
                   .altitude_m = place.altitude_m};
  s.scene.north_rad = degree * place.north_deg;
}

void read_time(SceneReader& s) {
  constexpr double kMostOutputs = 1e6;
  const auto section = find_section(s, "time", "write [time] with start, end and step");
  if (!section) return;
  TimeSection& time = s.scene.time;
  read_table(s, *section, time);
  const auto has_failed = [&](std::string_view key) { return s.reader.has_failed(section->at(key)); };
  for (const auto& [key, instant] : {std::pair{"start", time.start_s}, std::pair{"end", time.end_s}})
    if (!has_failed(key) && !(instant >= heat::instant_of({1900, 1, 1}) && instant <= heat::instant_of({2101, 1, 1})))
      section->error(key, "the sun is known for the years 1900 to 2100");
  if (has_failed("start") || has_failed("end") || has_failed("step")) return;
  const double steps = (time.end_s - time.start_s) / time.step_s;
  if (!(time.end_s > time.start_s))
    section->error("end", "the end is not after the start");
  else if (steps > kMostOutputs)
    section->error("step", "more than a million output times; take longer steps");
  else if (std::abs(steps - std::round(steps)) > 1e-6 || steps < 0.5)
    section->error("step", "the step is no divisor of the time from start to end");
}

void read_weather_section(SceneReader& s) {
  const auto found = find_section(s, "weather", "write [weather] with file = \"weather.csv\", or constant values");
  if (!found) return;
  const Section& section = *found;
  WeatherSection& weather = s.scene.weather;
  std::vector<FieldInfo> known = rows_of<WeatherSection>(), changes = rows_of<WeatherChange>(), constants{kHumidity};
  constants.insert(constants.end(), kConstants.begin(), kConstants.end());
  known.insert(known.end(), constants.begin(), constants.end());
  known.insert(known.end(), changes.begin(), changes.end());
  check_rows(section, known);
  read_rows(s, section, weather);
  const bool failed = s.reader.has_failed("weather.file");
  const Node* file = section.find("file");
  if (file != nullptr) weather.file_at = file->position;
  for (const FieldInfo& row : changes)
    if (file == nullptr && !failed && section.find(row.name) != nullptr)
      section.error(row.name, "changes the records of a file; of constant weather change the values themselves");
  read_rows(s, section, weather.change);
  const auto constant = std::find_if(constants.begin(), constants.end(),
                                     [&](const FieldInfo& row) { return section.find(row.name) != nullptr; });
  if (constant == constants.end()) {
    if (file == nullptr && !failed)
      section.error("file",
                    "missing; write for example file = \"weather.csv\", or constant values such as "
                    "air_temperature = \"15 degC\"");
  } else if (file != nullptr) {
    section.error(constant->name, "a constant value beside a file; remove one of them");
  } else {
    read_constant_weather(s, section);
  }
}

void read_value(SceneReader& s, const Section& section, const FieldInfo& row, CloudSource& value) {
  const Node* cloud = section.find(row.name);
  if (cloud == nullptr) return;
  if (cloud->kind == Node::Kind::string && !cloud->text.ends_with("%")) {
    if (const auto word = cfg::read_word(section, row.name, row.words)) value = static_cast<CloudSource>(*word);
  } else if (const auto cover = read_si(section, row)) {
    value = CloudSource::constant;
    s.scene.sky.cloud_cover = *cover;
  }
}

void read_sky(SceneReader& s) {
  if (const auto section = find_section(s, "sky", "")) read_table(s, *section, s.scene.sky);
}

}  // namespace apps::scene
