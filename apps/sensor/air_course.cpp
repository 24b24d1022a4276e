// SPDX-License-Identifier: Apache-2.0
#include "apps/sensor/air_course.h"

#include <algorithm>

#include "mtf/components/path_air.h"
#include "mtf/words.h"
#include "radiometry/chain/sensor_budget.h"
#include "radiometry/chain/sensor_numbers.h"

namespace apps {

using radiometry::AtmosphereSettings;
using radiometry::PathTable;

namespace {

/// The table without the nearest of its ranges that lies between others, 0 among them.
std::shared_ptr<const PathTable> without_nearest(const PathTable& table, double range_m) {
  std::vector<double> ranges = table.range_m();
  auto transmission = table.transmission(), radiance = table.radiance();
  const auto last = ranges.end() - 1;
  const auto nearest = std::min_element(
      ranges.begin(), last, [&](double a, double b) { return std::abs(a - range_m) < std::abs(b - range_m); });
  const std::ptrdiff_t at = nearest - ranges.begin();
  ranges.erase(nearest);
  transmission.erase(transmission.begin() + at);
  radiance.erase(radiance.begin() + at);
  return std::make_shared<const PathTable>(table.source(), std::move(ranges), table.wavelength_um(),
                                           std::move(transmission), std::move(radiance));
}

/// The same path where nobody knows how a transmission falls from one range of the table to 0 at the next: a straight
/// line, which `at` takes, is the most it can be, 0 the least.
radiometry::Path at_least(radiometry::Path path, const PathTable& table, double range_m) {
  const auto next = static_cast<std::size_t>(std::lower_bound(table.range_m().begin(), table.range_m().end(), range_m) -
                                             table.range_m().begin());
  if (range_m < table.range_m()[next])
    for (std::size_t j = 0; j < path.transmission.value.size(); ++j)
      if (table.transmission()[next][j] == 0.0) path.transmission.value[j] = 0.0;
  return path;
}

/// With 15 digits: what a change of unit rounds is not shown.
std::string shown(double value, std::string_view unit) { return mtf::with_unit(mtf::significant(value, 15), unit); }
std::string shown(const std::string& text, std::string_view) { return text; }
std::string shown(const radiometry::NumberOrFile& value, std::string_view unit) {
  return value.file.empty() ? shown(value.number, unit) : value.file;
}
template <class T>
requires std::is_enum_v<T> std::string shown(T word, std::string_view) {
  return std::string(words(word)[static_cast<std::size_t>(word)]);
}
template <class T>
std::string shown(const std::optional<T>& value, std::string_view unit) {
  return value ? shown(*value, unit) : "";
}

/// What differs from a table without keys.
template <class T>
std::string keys_of(std::string text, const T& table) {
  std::vector<std::string> defaults;
  const T none{};
  for_each_field(none,
                 [&](const radiometry::FieldInfo& info, const auto& v) { defaults.push_back(shown(v, info.unit)); });
  std::size_t i = 0;
  for_each_field(table, [&](const radiometry::FieldInfo& info, const auto& value) {
    const std::string given = shown(value, info.unit);
    if (given != defaults[i++]) text += (text.ends_with(']') ? " " : ", ") + std::string(info.name) + " " + given;
  });
  return text;
}

}  // namespace

std::string air_course_gap(const mtf::System<double>& system, const LoadedSensor& loaded) {
  const radiometry::SensorSettings& settings = loaded.sensor.settings;
  if (loaded.paths)
    return "the path has the range of each pixel; remove scene.depth_channel, and give the air a range of its own";
  if (const std::string label = own_path(system); !label.empty())
    return "\"" + label +
           "\" states a path of its own, which would stay while the range changes; leave its path_length out, and of "
           "turbulence give cn2 alone, so that it takes the range of [atmosphere]";
  if (settings.path && !loaded.table)
    return "[path] with one transmission holds for one range; in its place give [atmosphere] or a path.table of "
           "several ranges, or remove it and give [conditions] extinction";
  if (loaded.table && loaded.table->range_m().size() < 2)
    return "path.table holds one range; give one of several, as mtf atmosphere --table writes it, or [atmosphere]";
  if (settings.atmosphere && !settings.atmosphere->range_m)
    return "[atmosphere] zenith_angle says how long the line of sight is; give range in place of target_altitude, or "
           "beside it in place of zenith_angle";
  return "";
}

AirCourse air_course(const LoadedSensor& loaded, const radiometry::Overrides<double>& numbers) {
  if (loaded.table) {
    const std::shared_ptr<const PathTable> table = loaded.table;
    return {.reach = {0.0, table->range_m().back(), "the table " + table->source() + " ends"},
            .path = [table](double range_m) { return table->at(range_m); },
            .coarser =
                [table](double range_m) {
                  return at_least(without_nearest(*table, range_m)->at(range_m), *table, range_m);
                }};
  }
  if (!loaded.sensor.settings.atmosphere) return {};
  const AtmosphereSettings own = atmosphere_with(loaded.sensor, numbers);
  const auto at = [own](double range_m) {
    AtmosphereSettings settings = own;
    settings.range_m = range_m;
    return settings;
  };
  AirCourse course{.reach = loaded.reach(own),
                   .path = [at, air = loaded.sensor.air](double range_m) { return air(at(range_m)); }};
  if (loaded.path_air)
    course.path_air = [at, path_air = loaded.path_air](double range_m) { return path_air(at(range_m)); };
  return course;
}

std::string air_words(const radiometry::SensorSettings& settings) {
  if (settings.atmosphere) return keys_of("[atmosphere]", *settings.atmosphere);
  return settings.path ? keys_of("[path]", *settings.path) : "";
}

std::string frame_rate_words(const mtf::System<double>& system, const radiometry::SensorSettings& settings) {
  const double time_s = frame_time_s(system, settings);
  if (!(time_s > 0.0)) return "";
  const bool given = settings.frame && settings.frame->frame_time_s;
  if (settings.thermal && !given) return "";  // figures of observers want a frame time of it
  return mtf::three_digits(1.0 / time_s) + " Hz (1 / " +
         (given ? "frame_time)" : "integration_time, as [frame] has no frame_time)");
}

std::optional<double> stated_range_m(const radiometry::SensorSettings& settings) {
  if (settings.atmosphere) return settings.atmosphere->range_m;
  return settings.path ? settings.path->range_m : std::nullopt;
}

}  // namespace apps
