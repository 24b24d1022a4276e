// SPDX-License-Identifier: Apache-2.0

// The parts of a study that need no sensor: its head, [yield], [conditions].

#include <algorithm>
#include <array>

#include "apps/study/study_reader.h"
#include "apps/study/study_shape.h"

namespace study {
namespace {

namespace cfg = mtf::io::cfg;
using cfg::Node;
using cfg::Section;
using mtf::Dimension;
using mtf::FieldInfo;

constexpr std::size_t kMaxName = 200;

struct Row {
  FieldInfo info;
  std::function<void(Conditions&, double)> set;
};

std::vector<Row> condition_rows() {
  using enum Dimension;
  const auto row = [](std::string_view name, Dimension dimension, std::string_view unit, double lo, double hi,
                      bool lo_open, std::string_view example, std::function<void(Conditions&, double)> set) {
    return Row{{.name = name,
                .dimension = dimension,
                .unit = unit,
                .lo = lo,
                .hi = hi,
                .lo_open = lo_open,
                .presence = mtf::Presence::optional,
                .example = example},
               std::move(set)};
  };
  return {
      row("temperature", temperature, "K", 0.0, 1e5, true, "\"300 K\"",
          [](Conditions& c, double x) { c.temperature_k = x; }),
      row("range", length, "m", 0.0, 1e13, true, "\"5 km\"", [](Conditions& c, double x) { c.range_m = x; }),
      row("elevation", angle, "deg", 0.0, 90.0, true, "\"60 deg\"",
          [](Conditions& c, double x) { c.elevation_deg = x; }),
      row("contrast", temperature_difference, "K", 0.0, 1e5, true, "\"2 K\"",
          [](Conditions& c, double x) { c.contrast_k = x; }),
      row("target_size", length, "m", 0.0, 1e9, true, "\"3.1 m\"",
          [](Conditions& c, double x) { c.target_size_m = x; }),
      row("signal_contrast", none, "", 0.0, 1.0, true, "0.5", [](Conditions& c, double x) { c.signal_contrast = x; }),
      row("extinction", none, "", 0.0, 1e6, false, "0.2", [](Conditions& c, double x) { c.extinction_per_km = x; }),
      row("scene_contrast", temperature_difference, "K", 0.0, 1e5, true, "\"5 K\"",
          [](Conditions& c, double x) { c.scene_contrast_k = x; }),
      row("snr_threshold", none, "", 0.0, 1e6, true, "2.5", [](Conditions& c, double x) { c.snr_threshold = x; }),
      row("eye_time", time, "s", 0.0, 1e3, true, "\"0.1 s\"", [](Conditions& c, double x) { c.eye_time_s = x; }),
      row("frame_rate", temporal, "Hz", 0.0, 1e9, true, "\"60 Hz\"",
          [](Conditions& c, double x) { c.frame_rate_hz = x; }),
      row("luminance", luminance, "cd/m^2", 0.0, 1e6, true, "\"34 cd/m^2\"",
          [](Conditions& c, double x) { c.luminance_cd_m2 = x; }),
      row("magnification", none, "", 0.0, 1e6, true, "5.0",
          [](Conditions& c, double x) { c.viewing_magnification = x; }),
      row("v50_detect", none, "", 0.0, 1e6, true, "2.0", [](Conditions& c, double x) { c.v50_detect = x; }),
      row("v50_recognise", none, "", 0.0, 1e6, true, "7.5", [](Conditions& c, double x) { c.v50_recognise = x; }),
      row("v50_identify", none, "", 0.0, 1e6, true, "13.0", [](Conditions& c, double x) { c.v50_identify = x; }),
  };
}

void read_conditions(StudyReader& s) {
  const Section root = s.root();
  const Node* table = cfg::find_table(root, "conditions");
  if (table == nullptr) return;
  const Section section{s.reader, *table, "conditions", "[conditions]"};
  const std::vector<Row> rows = condition_rows();
  std::vector<std::string_view> known;
  for (const Row& row : rows) known.push_back(row.info.name);
  check_study_keys(section, known);
  for (const Row& row : rows)
    if (const auto value = cfg::read_number(section, row.info, row.info.name)) row.set(s.study.conditions, *value);
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

std::vector<FieldInfo> condition_fields() {
  std::vector<FieldInfo> fields;
  for (const Row& row : condition_rows()) fields.push_back(row.info);
  return fields;
}

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

const Node* find_tables(StudyReader& s, const std::string& key) {
  const Node* list = s.tree.find(key);
  if (list == nullptr) return nullptr;
  s.reader.positions[key] = list->position;
  const auto is_table = [](const Node& item) { return item.kind == Node::Kind::table; };
  if (list->kind == Node::Kind::array && std::all_of(list->items.begin(), list->items.end(), is_table)) return list;
  s.error(list->position, key, "has to be a list of tables; write [[" + key + "]] with double brackets");
  return nullptr;
}

void read_settings(StudyReader& s) {
  cfg::check_keys(s.root(), kTopKeys);
  read_head(s);
  read_yield(s);
  read_conditions(s);
}

}  // namespace study
