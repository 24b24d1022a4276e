// SPDX-License-Identifier: Apache-2.0
#include "apps/sensor/sensor_air.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <span>

#include "apps/sensor/sensor_place.h"
#include "mtf/components/aerosol.h"
#include "mtf/components/path_air.h"
#include "mtf/error.h"
#include "mtf/io/csv/air_profile_csv.h"
#include "mtf/words.h"
#include "radiometry/atmosphere/range_table.h"
#include "radiometry/chain/sensor_budget.h"
#include "radiometry/chain/sensor_numbers.h"

namespace apps {
namespace {

using radiometry::PathTable;

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

using radiometry::AtmosphereSettings;
namespace air = radiometry::atmosphere;

namespace {

/// Of a transmission between the ranges of a table for scene.depth_channel; at most kMostRanges of them.
constexpr double kTableError = 1e-5;
constexpr std::size_t kMostRanges = 256;
constexpr double kJoin_m = 500.0;  // levels of the model nearer than that to the top of a sounding are not taken

static_assert(mtf::io::kProfileGases.size() == air::kGases);

/// The mixing ratio of a gas at an altitude, beyond the ends of the model as there.
double model_ppm(const air::Profile<double>& model, air::Gas gas, double altitude_m) {
  const double inside_m = std::clamp(altitude_m, model.levels.front().altitude_m, model.levels.back().altitude_m);
  return air::level_at(model, inside_m)[gas];
}

/// Soundings end somewhere; the air above is the model's, its pressure in proportion so that it joins. A single level
/// is the air of horizontal lines and stays alone.
void add_model_above(air::Profile<double>& profile, const air::Profile<double>& model) {
  if (profile.levels.size() < 2) return;
  const air::Level<double> top = profile.levels.back();
  if (top.altitude_m >= model.levels.back().altitude_m) return;
  const double factor =
      top.pressure_pa / air::level_at(model, std::max(top.altitude_m, model.levels.front().altitude_m)).pressure_pa;
  for (air::Level<double> level : model.levels) {
    if (level.altitude_m < top.altitude_m + kJoin_m) continue;
    level.pressure_pa *= factor;
    profile.levels.push_back(level);
  }
}

air::Profile<double> profile_of(const mtf::io::AirProfileColumns& columns, const AtmosphereSettings& settings) {
  const air::Profile<double> model = air::model_profile(settings.model.value_or(air::ModelAtmosphere::us_standard_1976),
                                                        settings.carbon_dioxide_ppm.value_or(air::kCarbonDioxide_ppm));
  air::Profile<double> profile{.source = columns.source, .levels = {}};
  for (std::size_t i = 0; i < columns.altitude_m.size(); ++i) {
    air::Level<double> level{.altitude_m = columns.altitude_m[i],
                             .pressure_pa = columns.pressure_pa[i],
                             .temperature_k = columns.temperature_k[i]};
    for (std::size_t g = 0; g < air::kGases; ++g) {
      const auto gas = static_cast<air::Gas>(g);
      const std::vector<double>& given = columns.mixing_ratio[g];
      if (!given.empty())
        level[gas] = given[i];
      else if (gas == air::Gas::water)
        level[gas] = air::water_ppm(level.pressure_pa, level.temperature_k, 100.0 * columns.relative_humidity[i]);
      else
        level[gas] = model_ppm(model, gas, level.altitude_m);
    }
    profile.levels.push_back(level);
  }
  add_model_above(profile, model);
  return profile;
}

constexpr const char* kTable = "[atmosphere]";

/// True where each pixel has a range of its own, so that there is no path for all.
bool has_depth_channel(std::span<const mtf::SettingsTable> tables) {
  return std::any_of(tables.begin(), tables.end(), [](const mtf::SettingsTable& table) {
    return table.name == "scene" && table.find("depth_channel") != nullptr;
  });
}

/// True for an aerosol component of the system that is such.
template <class Is>
bool any_aerosol(const mtf::System<double>& system, const Is& is) {
  const auto& list = system.list(mtf::Stage::presample);
  return std::any_of(list.begin(), list.end(), [&](const auto& entry) {
    const auto* aerosol = entry.component.template get_if<mtf::Aerosol<double>>();
    return aerosol != nullptr && is(*aerosol);
  });
}
bool has_scattering(const mtf::Aerosol<double>& aerosol) { return aerosol.scattering_1_km.has_value(); }

/// How far the line goes when its range is given other values.
radiometry::Reach reach_of(const AtmosphereSettings& settings, const std::optional<air::Profile<double>>& profile) {
  const air::Air<double> through = air_of(settings, profile);
  const double from_m = settings.sensor_altitude_m;
  constexpr double kShort = 1e-9;  // of the horizon, at which the line touches the ground
  if (settings.target_altitude_m) {
    const double to_m = *settings.target_altitude_m;
    return {std::abs(to_m - from_m), (1.0 - kShort) * air::horizon_range_m(through, from_m, to_m),
            "the horizon hides the target"};
  }
  if (!settings.zenith_deg) return {};
  const double ground_m = through.profile.levels.front().altitude_m;
  AtmosphereSettings down = settings;
  down.range_m = {};
  down.target_altitude_m = ground_m;
  try {
    if (from_m > ground_m && *settings.zenith_deg > 90.0)
      return {0.0, (1.0 - kShort) * sight_numbers(through, *sight_of(down)).range_m,
              "the line of sight meets the ground"};
  } catch (const mtf::UsageError&) {  // it passes above the ground
  }
  return {};
}

/// Tables over the ranges of images, a function of the nearest and the longest range alone, so that a frame does not
/// depend on those before it. Horizontal lines take ranges of whole powers of 2 in m, whose table frames then share.
class AirTables {
 public:
  AirTables(air::Air<double> through, AtmosphereSettings settings, const radiometry::Interval& band)
      : through_(std::move(through)), settings_(std::move(settings)), band_(band) {}

  RangedPaths covering(double nearest_m, double longest_m) const {
    if (!(nearest_m > 0.0 && longest_m < std::numeric_limits<double>::infinity()))
      throw mtf::UsageError("scene.depth_channel: ranges from " + mtf::format_double(nearest_m) + " to " +
                            mtf::format_double(longest_m) + " m; they are above 0 and finite");
    if (!settings_.target_altitude_m && !settings_.zenith_deg) {
      nearest_m = std::exp2(std::floor(std::log2(nearest_m)));
      longest_m = std::exp2(std::ceil(std::log2(longest_m)));
    }
    const std::scoped_lock lock(mutex_);
    if (!last_.table || nearest_m != nearest_m_ || longest_m != longest_m_) {
      last_ = made(nearest_m, longest_m);
      nearest_m_ = nearest_m;
      longest_m_ = longest_m;
    }
    return last_;
  }

 private:
  RangedPaths made(double nearest_m, double longest_m) const {
    AtmosphereSettings line = settings_;
    line.range_m = longest_m;
    const air::Sight<double> sight = read_sight(line);
    return at_key(kTable, [&] {
      const air::TableRanges ranges =
          ranges_for(through_, sight, nearest_m, longest_m, kTableError, band_, kMostRanges);
      double warmest_k = 0.0;
      for (const auto& level : through_.profile.levels) warmest_k = std::max(warmest_k, level.temperature_k);
      return RangedPaths{std::make_shared<const radiometry::PathTable>(
                             path_table(through_, sight, ranges.ranges_m, {.band = band_}).table),
                         ranges.error, warmest_k};
    });
  }

  air::Air<double> through_;
  AtmosphereSettings settings_;
  radiometry::Interval band_;
  mutable std::mutex mutex_;
  mutable RangedPaths last_;
  mutable double nearest_m_ = 0.0, longest_m_ = 0.0;
};

/// The path that components of a system take from [atmosphere]: its length, and what haze scatters in the band; nothing
/// where the table has no line.
mtf::PathAir<double> path_air_of(const AtmosphereSettings& settings, const std::optional<air::Profile<double>>& profile,
                                 const std::optional<mtf::Band>& band) {
  const auto sight = sight_of(settings);
  if (!sight) return {};
  const air::Air<double> through = air_of(settings, profile);
  mtf::PathAir<double> path{.path_length_m = sight_numbers(through, *sight).range_m, .scattering = {}};
  if (through.haze.kind != air::HazeKind::none && band)
    path.scattering = scattering_depth(through, *sight, {band->lo_um, band->hi_um});
  return path;
}

/// The profile that the table names; nothing where it names none. Gases that the file lacks are those of
/// [atmosphere] model, at equal altitudes. Throws UsageError "atmosphere.profile: ...", RuntimeError when it cannot be
/// read.
std::optional<air::Profile<double>> read_profile(const AtmosphereSettings& settings) {
  if (settings.profile.empty()) return std::nullopt;
  return at_key("atmosphere.profile",
                [&] { return std::optional(profile_of(mtf::io::read_air_profile_csv(settings.profile), settings)); });
}

}  // namespace

air::Sight<double> read_sight(const AtmosphereSettings& settings) {
  if (const auto sight = sight_of(settings)) return *sight;
  throw mtf::UsageError(
      "[atmosphere]: gives no line of sight; write range = \"2 km\" for a horizontal one, with target_altitude or "
      "zenith_angle beside it for others; mtf render and mtf fly take it from the scene, and mtf simulate "
      "--without-path needs none");
}

air::Air<double> read_air(const AtmosphereSettings& settings) { return air_of(settings, read_profile(settings)); }

air::AerosolLoss loss_in(const mtf::System<double>& system) {
  const bool kept = any_aerosol(system, [](const auto& aerosol) { return !has_scattering(aerosol); });
  return kept ? air::AerosolLoss::absorption : air::AerosolLoss::extinction;
}

std::vector<mtf::TableInfo> sensor_schema() {
  std::vector<mtf::TableInfo> tables = radiometry::sensor_tables();
  for (mtf::TableInfo& table : tables)
    if (table.name == "atmosphere")
      table.path_air = [](const mtf::SettingsTable& given, const std::optional<mtf::Band>& band) {
        const auto settings = radiometry::from_table<AtmosphereSettings>(given);
        return path_air_of(settings, read_profile(settings), band);
      };
  return tables;
}

void read_atmosphere(const mtf::System<double>& system, const radiometry::SensorSettings& settings,
                     LoadedSensor& loaded) {
  const AtmosphereSettings& given = *settings.atmosphere;
  const radiometry::Interval band = loaded.sensor.curves.band;
  const auto profile = read_profile(given);
  const air::AerosolLoss loss = loss_in(system);
  if (!settings.scene || settings.scene->depth_channel.name.empty()) {
    if (takes_path_air(system))
      loaded.path_air = [profile, system_band = system.band](const AtmosphereSettings& numbers) {
        return path_air_of(numbers, profile, system_band);
      };
    loaded.sensor.air = [profile, band, loss](const AtmosphereSettings& numbers) {
      air::Air<double> through = air_of(numbers, profile);
      through.haze.loss = loss;
      const air::Sight<double> sight = read_sight(numbers);
      return at_key(kTable, [&] { return path_of(spectral_path(through, sight, {.band = band}), "[atmosphere]"); });
    };
    loaded.sensor.path = loaded.sensor.air(given);
    loaded.reach = [profile](const AtmosphereSettings& numbers) { return reach_of(numbers, profile); };
    return;
  }
  if (given.range_m)
    throw mtf::UsageError("atmosphere.range: given together with scene.depth_channel; remove one of them");
  if (given.target_altitude_m && given.zenith_deg)
    throw mtf::UsageError(
        "atmosphere.zenith_angle: given together with target_altitude and scene.depth_channel; remove one of them");
  air::Air<double> through = air_of(given, profile);
  through.haze.loss = loss;
  const auto tables = std::make_shared<const AirTables>(std::move(through), given, band);
  loaded.paths = [tables](double nearest_m, double longest_m) { return tables->covering(nearest_m, longest_m); };
}

mtf::io::SensorConfig without_path(mtf::io::SensorConfig sensor) {
  std::erase_if(sensor.tables,
                [](const mtf::SettingsTable& table) { return table.name == "path" || table.name == "atmosphere"; });
  for (mtf::SettingsTable& table : sensor.tables)
    if (table.name == "scene")
      std::erase_if(table.settings, [](const mtf::GivenSetting& setting) { return setting.name == "depth_channel"; });
  return sensor;
}

std::optional<AirRange> range_of_air(const mtf::io::SensorConfig& sensor) {
  const radiometry::SensorSettings settings = radiometry::sensor_settings(sensor.tables);
  if (settings.path && settings.path->range_m) return AirRange{*settings.path->range_m};
  if (!settings.atmosphere) return std::nullopt;
  const auto sight = sight_of(*settings.atmosphere);
  if (!sight) return std::nullopt;
  const air::Air<double> through = read_air(*settings.atmosphere);
  const air::SightNumbers<double> numbers = sight_numbers(through, *sight);
  constexpr double kNear_m = 1.0;
  const double top_m = through.profile.levels.back().altitude_m - kNear_m;
  return AirRange{numbers.range_m,
                  through.profile.levels.size() > 1 &&
                      (settings.atmosphere->sensor_altitude_m >= top_m || numbers.object_altitude_m >= top_m)};
}

std::vector<mtf::io::Diagnostic> atmosphere_warnings(const mtf::io::SensorConfig& config) {
  std::vector<mtf::io::Diagnostic> warnings;
  const mtf::SettingsTable* table = find_table(config.tables, "atmosphere");
  if (table == nullptr || !config.system.band) return warnings;
  try {
    const auto settings = radiometry::from_table<AtmosphereSettings>(*table);
    if (settings.haze != air::HazeKind::none && any_aerosol(config.system, has_scattering))
      warnings.push_back({.error = false,
                          .position = {},
                          .path = "atmosphere.haze",
                          .text = "its transmission and the scattering of the aerosol component count scattered light "
                                  "twice; leave scattering and path_length out of the component, which then takes them "
                                  "from here, or remove haze"});
    const radiometry::Interval band{config.system.band->lo_um, config.system.band->hi_um};
    for (std::string& text : air::limits_of(read_air(settings), band, sight_of(settings)))
      warnings.push_back({.error = false, .position = {}, .path = "atmosphere", .text = std::move(text)});
    if (has_depth_channel(config.tables))
      warnings.push_back({.error = false,
                          .position = {},
                          .path = "atmosphere",
                          .text = "each pixel has a range of its own: curves of this file are those without air",
                          .remark = true});
  } catch (const mtf::Error&) {  // refused where the sensor is loaded
  }
  return warnings;
}

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
