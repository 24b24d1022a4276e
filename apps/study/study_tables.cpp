// SPDX-License-Identifier: Apache-2.0

// The parts of a study that need no sensor: its head, [yield], [conditions].

#include <algorithm>
#include <cassert>
#include <cmath>
#include <filesystem>

#include "apps/sensor/sensor_air.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/study/study_reader.h"
#include "apps/study/study_shape.h"
#include "mtf/error.h"
#include "mtf/words.h"

namespace study {
namespace {

using mtf::FieldInfo;

constexpr std::size_t kMaxName = 200;

void read_conditions(StudyReader& s) {
  const Section root = s.root();
  const Node* table = cfg::find_table(root, "conditions");
  if (table == nullptr) return;
  const Section section{s.reader, *table, "conditions", "[conditions]"};
  check_study_keys(section, condition_fields());
  Conditions& given = s.study.conditions;
  radiometry::for_each_field(given, [&](const FieldInfo& info, auto& member) {
    if (const auto value = cfg::read_number(section, info, info.name)) member = *value;
  });
  const bool height = section.find("display_height") != nullptr, distance = section.find("viewing_distance") != nullptr;
  if (height != distance)
    section.error(height ? "display_height" : "viewing_distance",
                  std::string("needs ") + (height ? "viewing_distance" : "display_height") +
                      " beside it: both say at which angle the observer sees the picture");
  else if (height && section.find("magnification") != nullptr)
    section.error("magnification", "given together with display_height, from which it follows; remove one of them");
}

void read_yield(StudyReader& s) {
  const Section root = s.root();
  const Node* table = cfg::find_table(root, "yield");
  if (table == nullptr) return;
  const Section section{s.reader, *table, "yield", "[yield]"};
  check_study_keys(section, kYieldKeys);
  if (const auto count = cfg::read_whole(section, kDraws)) s.study.draws = *count;
  if (s.tree.find("as_built") == nullptr)
    s.warn(table->position, "yield", "nothing varies as built, so there is no yield; add [[as_built]] or remove it");
}

void read_head(StudyReader& s) {
  const Section root = s.root();
  const Node* schema = root.find("schema");
  if (schema == nullptr)
    s.error({}, "schema", "missing; write schema = 1 as the first line");
  else if (schema->kind != Node::Kind::integer || schema->integer != 1)
    root.error("schema", cfg::shown(*schema) + " is not supported; this version reads schema = 1");
  if (const auto name = cfg::read_string(root, "name")) {
    if (name->size() > kMaxName) root.error("name", "longer than " + std::to_string(kMaxName) + " characters");
    s.study.name = *name;
  }
  s.study.tolerance = cfg::read_number(root, kTolerance, "tolerance").value_or(s.study.tolerance);
  if (const Node* seed = root.find("seed")) {
    if (seed->kind == Node::Kind::integer && seed->integer >= 0)
      s.study.seed = static_cast<std::uint64_t>(seed->integer);
    else
      root.error("seed", cfg::shown(*seed) + " has to be a whole number from 0 on");
  }
}

// Sensors with the levels of discrete axes: the values replace those in the tree of the sensor file, which is then read
// like any other.

using mtf::io::ConfigResult;

/// Names of files in a study are relative to its folder; the reader of the sensor takes them relative to the sensor's.
void find_file(Node& node, const Place& place, const std::string& study_file, const std::string& sensor_file) {
  if (!place.file || node.kind != Node::Kind::string) return;
  if (place.info.dimension != mtf::Dimension::none) try {
      static_cast<void>(mtf::parse_quantity(node.text, place.info.dimension));
      return;  // a number in place of a file
    } catch (const mtf::UsageError&) {
    }
  const std::string folder = cfg::folder_of(study_file);
  if (folder == cfg::folder_of(sensor_file) || node.text.empty() || node.text.find('\0') != std::string::npos) return;
  std::error_code none;
  const auto path = std::filesystem::absolute(cfg::beside(folder, node.text), none);
  if (!none) node.text = path.string();
}

std::string described(const Study& study, std::span<const int> levels) {
  std::string text;
  for (std::size_t a = 0; a < study.axes.size(); ++a)
    if (study.axes[a].discrete() && levels[a] >= 0)
      text += (text.empty() ? "" : ", ") + study.parameters[static_cast<std::size_t>(study.axes[a].parameter)].name +
              " = " + mtf::printable(study.axes[a].levels[static_cast<std::size_t>(levels[a])], 80);
  return text;
}

const Parameter& parameter_of(const Study& study, std::size_t axis) {
  return study.parameters[static_cast<std::size_t>(study.axes[axis].parameter)];
}

bool is_sensor(const Study& study, std::size_t axis) { return parameter_of(study, axis).path == "sensor"; }

/// That a parameter is in each sensor what it is in the base: the same place and unit.
void check_in_sensors(StudyReader& s, const Parameter& parameter, mtf::io::Position position, const std::string& path) {
  for (std::size_t i = 1; i < s.views.size(); ++i) {
    const std::string file = mtf::printable(s.views[i].sensor.file);
    const Found found = find_place(s.views[i], parameter.name);
    if (!found.place) {
      s.error(position, path, parameter.name + " in " + file + ": " + found.problem);
    } else if (found.place->target.path() != parameter.path) {
      s.error(position, path,
              parameter.name + " is " + parameter.path + " in " + mtf::printable(s.study.base.file) + ", but " +
                  found.place->target.path() + " in " + file + "; list the components in the same order");
    } else if (found.place->kind == Place::Kind::number && found.place->info.unit != parameter.unit &&
               !parameter.unit.empty()) {
      s.error(position, path,
              parameter.name + " is in " + parameter.unit + " in " + mtf::printable(s.study.base.file) + ", but in " +
                  std::string(found.place->info.unit) + " in " + file + "; write it in one unit");
    }
  }
}

}  // namespace

std::vector<FieldInfo> condition_fields() { return radiometry::table_info<Conditions>("conditions", "").settings; }

std::vector<std::string_view> top_keys() {
  std::vector<std::string_view> keys;
  for (const FieldInfo& key : kHeadKeys) keys.push_back(key.name);
  for (const StudyTable& table : kStudyTables) keys.push_back(table.name);
  return keys;
}

void check_study_keys(const Section& section, std::span<const FieldInfo> keys) {
  std::vector<std::string_view> known;
  for (const FieldInfo& key : keys) known.push_back(key.name);
  const std::vector<std::string_view> top = top_keys();
  // What follows a table belongs to it: TOML cannot return to the top level.
  Node rest = section.table;
  std::erase_if(rest.members, [&](const cfg::Member& member) {
    const auto is = [&](std::string_view key) { return key == member.key; };
    if (std::any_of(known.begin(), known.end(), is) || std::none_of(top.begin(), top.end(), is)) return false;
    section.reader.error(
        member.position, section.at(member.key),
        "belongs at the top of the file, above the first line with brackets; here it is a part of " + section.title);
    return true;
  });
  cfg::check_keys({section.reader, rest, section.path, section.title}, known);
}

void check_conditions(StudyReader& s) {
  const Node* table = s.tree.find("conditions");
  const auto refuse = [&](const char* key, const std::string& text) {
    s.error(table->find(key)->position, std::string("conditions.") + key, text);
  };
  const Conditions& given = s.study.conditions;
  const auto air_changes = [&](const Parameter& parameter) {
    const auto varies = [&](const AsBuilt& built) {
      return &s.study.parameters[static_cast<std::size_t>(built.parameter)] == &parameter;
    };
    return parameter.path == "atmosphere.range" || parameter.path == "path.range"
               ? parameter.role != Parameter::Role::fixed || std::ranges::any_of(s.study.as_built, varies)
               : false;
  };
  for (const SensorView& view : s.views) {
    const std::string file = mtf::printable(view.sensor.file);
    const char* air = find_table(view.sensor.tables, "atmosphere") ? "[atmosphere]" : "[path]";
    if (!find_table(view.sensor.tables, "atmosphere") && !find_table(view.sensor.tables, "path")) continue;
    if (given.extinction_per_km) return refuse("extinction", extinction_problem(view.sensor));
    if (!given.range_m) continue;
    if (std::any_of(s.study.parameters.begin(), s.study.parameters.end(), air_changes))
      return refuse("range", "stays while the study changes the range of " + std::string(air) +
                                 "; remove it: without it figures take that of the air");
    const auto own = apps::range_of_air(view.sensor);
    if (own && std::abs(own->range_m - *given.range_m) > 1e-6 * *given.range_m &&
        !(own->to_space && *given.range_m > own->range_m))
      return refuse("range", "is " + mtf::significant(*given.range_m, 15) + " m, but the air of " + file + " is " +
                                 mtf::significant(own->range_m, 15) + " m long, " + std::string(air) +
                                 "; give both the same, or remove range: without it figures take that of the air");
  }
}

void read_settings(StudyReader& s) {
  cfg::check_keys(s.root(), top_keys());
  read_head(s);
  read_yield(s);
  read_conditions(s);
}

std::vector<StudyFile> files_of(const Study& study) {
  const Node tree = cfg::read_tree(study.text).root;
  std::vector<StudyFile> files;
  const auto append = [&](const mtf::io::SensorConfig& sensor, const Node& named, const std::string& path) {
    for (std::string& file : apps::files_of(sensor)) files.push_back({std::move(file), named.position, path});
  };
  const auto values_of = [&](std::size_t axis) { return tree.find("axis")->items.at(axis).find("values"); };
  const auto path_of = [](std::size_t axis) { return "axis[" + std::to_string(axis) + "].values"; };
  if (const Node* named = tree.find("sensor")) append(study.base, *named, "sensor");
  std::vector<int> levels(study.axes.size(), 0);
  for (std::size_t a = 0; a < study.axes.size(); ++a) {
    for (std::size_t level = 0; level < study.axes[a].levels.size(); ++level) {
      const Node& value = values_of(a)->items.at(level);
      if (is_sensor(study, a)) append(study.sensors.at(level), value, path_of(a));
      levels[a] = static_cast<int>(level);
      try {
        append(variant(study, levels), value, path_of(a));
      } catch (const mtf::UsageError&) {
        continue;
      }
    }
    levels[a] = 0;
  }
  const auto by_name = [](const StudyFile& x, const StudyFile& y) { return x.file < y.file; };
  const auto same = [](const StudyFile& x, const StudyFile& y) { return x.file == y.file; };
  std::stable_sort(files.begin(), files.end(), by_name);
  files.erase(std::unique(files.begin(), files.end(), same), files.end());
  return files;
}

std::string level_text(const Node& node) {
  if (node.kind == Node::Kind::string) return node.text;
  if (node.kind != Node::Kind::array) return cfg::shown(node);
  std::string text = "[";
  for (std::size_t i = 0; i < node.items.size(); ++i)
    text += (i > 0 ? ", " : "") +
            (node.items[i].kind == Node::Kind::string ? "\"" + node.items[i].text + "\"" : level_text(node.items[i]));
  return text + "]";
}

ConfigResult with_levels(const Study& study, const Node& tree, const SensorView& view, std::span<const int> levels) {
  ConfigResult result;
  result.config.file = view.sensor.file;
  result.config.text = view.sensor.text;
  result.config.schema = view.sensor.schema;
  result.config.sha256 = view.sensor.sha256;
  Node root = view.tree;
  std::vector<mtf::io::Diagnostic> problems;
  for (std::size_t a = 0; a < study.axes.size(); ++a) {
    if (!study.axes[a].discrete() || levels[a] < 0 || is_sensor(study, a)) continue;
    const std::string& path = parameter_of(study, a).path;
    const Found found = find_place(view, path);
    std::string problem = found.problem;
    if (found.place) {
      Node node = tree.find("axis")->items.at(a).find("values")->items.at(static_cast<std::size_t>(levels[a]));
      find_file(node, *found.place, study.file, view.sensor.file);
      problem = cfg::put(root, found.place->target, std::move(node));
    }
    if (!problem.empty()) problems.push_back({.error = true, .position = {}, .path = path, .text = problem});
  }
  cfg::interpret(root, result);
  result.diagnostics.insert(result.diagnostics.begin(), problems.begin(), problems.end());
  return result;
}

void check_levels(StudyReader& s) {
  constexpr int kMostChains = 200;  // they read files
  const Study& study = s.study;
  int chains = 0;
  for (std::size_t a = 0; a < study.axes.size(); ++a) {
    const Axis& axis = study.axes[a];
    if (is_sensor(study, a) || parameter_of(study, a).path.empty()) continue;  // no sensor has the study's own numbers
    const Node& table = s.tree.find("axis")->items.at(a);
    const std::string path = "axis[" + std::to_string(a) + "]";
    check_in_sensors(s, parameter_of(study, a), table.position, path);
    if (!axis.discrete()) continue;
    std::vector<int> levels(study.axes.size(), -1);
    for (std::size_t i = 0; i < axis.levels.size(); ++i) {
      levels[a] = static_cast<int>(i);
      ConfigResult result = with_levels(study, s.tree, s.views.front(), levels);
      if (result.ok() && ++chains <= kMostChains)
        if (auto problem = apps::chain_problem(result.config)) {
          if (problem->path.empty()) problem->path = parameter_of(study, a).path;
          result.diagnostics.push_back(std::move(*problem));
        }
      for (const mtf::io::Diagnostic& diagnostic : result.diagnostics)
        if (diagnostic.error)
          s.error(table.find("values")->items.at(i).position, path + ".values",
                  diagnostic.path + ": " + diagnostic.text);
    }
  }
  for (const Parameter& parameter : study.parameters)
    if (parameter.role != Parameter::Role::axis && !parameter.path.empty())
      check_in_sensors(s, parameter, {}, parameter.name);
}

mtf::io::SensorConfig variant(const Study& study, std::span<const int> levels) {
  assert(levels.size() == study.axes.size());
  const mtf::io::SensorConfig* sensor = &study.base;
  for (std::size_t a = 0; a < study.axes.size(); ++a)
    if (study.axes[a].discrete() && is_sensor(study, a))
      sensor = &study.sensors.at(static_cast<std::size_t>(levels[a]));
  ConfigResult result = with_levels(study, cfg::read_tree(study.text).root, view_of(*sensor), levels);
  std::string errors;
  for (const mtf::io::Diagnostic& diagnostic : result.diagnostics)
    if (diagnostic.error)
      errors += (errors.empty() ? "" : "\n") + sensor->file + " with " + described(study, levels) + ": " +
                (diagnostic.path.empty() ? "" : diagnostic.path + ": ") + diagnostic.text;
  if (!errors.empty()) throw mtf::UsageError(errors);
  return std::move(result.config);
}

}  // namespace study
