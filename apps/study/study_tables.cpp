// SPDX-License-Identifier: Apache-2.0

// The parts of a study that need no sensor: its head, [yield], [conditions].

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/sensor/sensor_air.h"
#include "apps/study/study_reader.h"
#include "apps/study/study_shape.h"
#include "mtf/words.h"

namespace study {
namespace {

namespace cfg = mtf::io::cfg;
using cfg::Node;
using cfg::Section;
using mtf::FieldInfo;

constexpr std::size_t kMaxName = 200;

void read_conditions(StudyReader& s) {
  const Section root = s.root();
  const Node* table = cfg::find_table(root, "conditions");
  if (table == nullptr) return;
  const Section section{s.reader, *table, "conditions", "[conditions]"};
  const std::vector<FieldInfo> fields = condition_fields();
  std::vector<std::string_view> known;
  for (const FieldInfo& field : fields) known.push_back(field.name);
  check_study_keys(section, known);
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

}  // namespace

std::vector<FieldInfo> condition_fields() { return radiometry::table_info<Conditions>("conditions", "").settings; }

void check_study_keys(const Section& section, std::span<const std::string_view> known) {
  // What follows a table belongs to it: TOML cannot return to the top level.
  Node rest = section.table;
  std::erase_if(rest.members, [&](const cfg::Member& member) {
    const auto is = [&](std::string_view key) { return key == member.key; };
    if (std::any_of(known.begin(), known.end(), is) || std::none_of(kTopKeys.begin(), kTopKeys.end(), is)) return false;
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
               ? parameter.role != Parameter::Role::fixed ||
                     std::any_of(s.study.as_built.begin(), s.study.as_built.end(), varies)
               : false;
  };
  for (const SensorView& view : s.views) {
    const std::string file = mtf::printable(view.sensor.file);
    const char* air = find_table(view.sensor.tables, "atmosphere") ? "[atmosphere]" : "[path]";
    if (!find_table(view.sensor.tables, "atmosphere") && !find_table(view.sensor.tables, "path")) continue;
    if (given.extinction_per_km)
      return refuse("extinction", "given beside " + std::string(air) + " of " + file +
                                      ", whose air takes contrast too; remove extinction, or " + air +
                                      " from the sensor file");
    if (!given.range_m) continue;
    if (std::any_of(s.study.parameters.begin(), s.study.parameters.end(), air_changes))
      return refuse("range", "stays while the study changes the range of " + std::string(air) +
                                 "; remove it: without it figures take that of the air");
    const auto own = apps::range_of_air(view.sensor);
    if (own && std::abs(own->range_m - *given.range_m) > 1e-6 * *given.range_m &&
        !(own->to_space && *given.range_m > own->range_m))
      return refuse("range", "is " + mtf::format_double(*given.range_m) + " m, but the air of " + file + " is " +
                                 mtf::format_double(own->range_m) + " m long, " + std::string(air) +
                                 "; give both the same, or remove range: without it figures take that of the air");
  }
}

void read_settings(StudyReader& s) {
  cfg::check_keys(s.root(), kTopKeys);
  read_head(s);
  read_yield(s);
  read_conditions(s);
}

}  // namespace study
