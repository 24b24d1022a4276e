// SPDX-License-Identifier: Apache-2.0
#include "apps/study/study_reader.h"

#include <algorithm>
#include <array>

#include "apps/study/design/variant_sensor.h"
#include "calib/fit/parameter_site.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/words.h"

namespace study {
namespace {

using cfg::Target;
using mtf::FieldType;

/// The table of the file that holds the target; null when it is not there.
const Node* table_of(const SensorView& view, const Target& target) {
  const Node* owner = view.tree.find(target.table);
  if (owner == nullptr || !target.component) return owner;
  return target.index < owner->items.size() ? &owner->items[target.index] : nullptr;
}

std::string stem_of(const std::string& key) {
  return key.ends_with("_x") || key.ends_with("_y") ? key.substr(0, key.size() - 2) : key;
}

bool is_given(const SensorView& view, const Target& target) {
  const Node* table = table_of(view, target);
  if (table == nullptr) return false;
  return table->find(target.key) != nullptr || table->find(stem_of(target.key)) != nullptr ||
         (table->find(target.key + "_x") != nullptr && table->find(target.key + "_y") != nullptr);
}

std::string heading(const SensorView& view, const Target& target) {
  if (!target.component) return "[" + target.table + "]";
  for (const mtf::Stage stage : mtf::kStages)
    if (mtf::stage_name(stage) == target.table)
      return "[[" + target.table + "]] " + view.sensor.system.list(stage)[target.index].label;
  return target.table;
}

std::string not_given(const SensorView& view, const Target& target, const mtf::FieldInfo& info) {
  std::string text = "the sensor file does not give it; write for example " + target.key + " = " +
                     std::string(info.example) + " in " + heading(view, target);
  const auto& optics = view.sensor.system.optics;
  if (target.path() == "optics.f_number" && optics.aperture_mm) text += " in place of aperture";
  if (target.path() == "optics.aperture" && optics.f_number) text += " in place of f_number";
  if (target.component && info.presence == mtf::Presence::shared)
    text += ", or name optics." + target.key + ", which it follows";
  return text;
}

std::string value_words(FieldType type) {
  constexpr std::array words{"a number", "a number", "a number", "a whole number", "true or false", "a word", "a list",
                             "a list",   "a text",   "a file",   "a file",         "a list",        "a date"};
  return words.at(static_cast<std::size_t>(type));
}

const mtf::FieldInfo* row_of(const SensorView& view, const Target& target) {
  for (const mtf::TableInfo& table : view.sensor.schema)
    if (table.name == target.table)
      for (const mtf::FieldInfo& row : table.settings)
        if (row.name == target.key) return &row;
  return nullptr;
}

/// The key of the map that stands in the place of a number where the sensor has both, "" for other numbers.
std::string_view map_in_place_of(std::string_view path) {
  if (path.starts_with("nonuniformity.prnu")) return "responsivity";
  return path == "nonuniformity.dsnu" ? "offset" : "";
}

/// Why a number of the sensor changes nothing; "" where it does.
std::string replaced_by_map(const SensorView& view, const Target& target) {
  const std::string map(map_in_place_of(target.path()));
  const mtf::SettingsTable* table = map.empty() ? nullptr : mtf::find_table(view.sensor.tables, target.table);
  const mtf::SettingValue* value = table != nullptr ? table->find(map) : nullptr;
  const std::string* file = value != nullptr ? std::get_if<std::string>(value) : nullptr;
  if (file == nullptr || file->empty()) return "";
  return "the sensor has the map " + map + " = \"" + mtf::printable(*file) + "\", which frames take in place of " +
         target.key + ": another " + target.key + " would change nothing; remove " + map +
         " from the sensor file, or name another parameter (an axis of files can vary the map: parameter = \"" +
         target.table + "." + map + "\")";
}

Found of_setting(const SensorView& view, const Target& target, const mtf::FieldInfo& row) {
  Place place{.target = target, .file = mtf::names_file(row), .info = row};
  place.what = value_words(row.type);
  if (row.type != FieldType::number && row.type != FieldType::number_or_file) return {place};
  if (std::string problem = replaced_by_map(view, target); !problem.empty()) return {std::nullopt, std::move(problem)};
  const mtf::SettingsTable* table = mtf::find_table(view.sensor.tables, target.table);
  const mtf::SettingValue* value = table != nullptr ? table->find(target.key) : nullptr;
  if (value == nullptr) return {std::nullopt, not_given(view, target, row)};
  const auto* number_value = std::get_if<double>(value);
  // What no budget reads is a sensor of its own for each value.
  if (number_value != nullptr && is_overridable(target.path())) {
    place.kind = Place::Kind::number;
    place.value = *number_value;
  }
  return {place};
}

/// Unit of an Extent or SpatialFrequency as written; null for other fields.
const mtf::Unit* unit_written(const mtf::FieldRef<double>& field, std::string_view key) {
  if (const auto* pair = std::get_if<mtf::AxisPair<double>*>(&field.value))
    return (*pair)->split && key.ends_with("_y") ? (*pair)->y.unit : (*pair)->x.unit;
  if (const auto* frequency = std::get_if<mtf::SpatialFrequency<double>*>(&field.value)) return (*frequency)->unit;
  return nullptr;
}

Found of_component(const SensorView& view, const Target& target) {
  mtf::System<double> system = view.sensor.system;  // sites are of a system that may be changed
  for (const mtf::Stage stage : mtf::kStages) {
    if (mtf::stage_name(stage) != target.table) continue;
    for (const mtf::FieldRef<double>& field : system.list(stage)[target.index].component.fields()) {
      const std::string name(field.info->name);
      const FieldType type = field.info->type;
      if (target.key != name && !(type == FieldType::size && stem_of(target.key) == name)) continue;
      Place place{.target = target, .what = value_words(type), .file = type == FieldType::file, .info = *field.info};
      const bool list = type == FieldType::numbers || type == FieldType::rows;
      if ((list && !target.element) || type == FieldType::whole || type == FieldType::word || place.file)
        return {place};
      if (!is_given(view, target)) return {std::nullopt, not_given(view, target, *field.info)};
      const mtf::Unit* unit = unit_written(field, target.key);
      const auto site = calib::parameter_site(system, target.path());
      if (site.numbers.empty() && !target.term.empty())
        return {std::nullopt, "the sensor file has no such term of a number over the field; write " + target.key +
                                  " = { 1 = ..., " + target.term + " = ... } there"};
      if (site.numbers.empty() && list)
        return {std::nullopt, "the list in the sensor file has no such element; write a longer one (with zeros) there"};
      if (site.numbers.empty())
        return {std::nullopt, target.key == name ? "the sensor file gives " + name + "_x and " + name +
                                                       "_y; name one of them, or write " + name + " there"
                                                 : "the sensor file gives " + name + " for both axes; write " + name +
                                                       "_x and " + name + "_y there, or name " + name};
      place.kind = Place::Kind::number;
      place.info = site.info;
      if (unit != nullptr) place.info.unit = unit->name;
      place.value = *site.numbers.front();
      return {place};
    }
  }
  return {std::nullopt, "the sensor has no such component"};
}

/// Of [frame], [optics] and [band].
Found of_system(const SensorView& view, const Target& target) {
  Place place{.target = target, .what = "a list"};
  if (target.table == "band" || target.key == "format") return {place};
  const mtf::FieldInfo* row = nullptr;
  for (const mtf::FieldInfo& info : cfg::own_rows(target.table))
    if (info.name == stem_of(target.key)) row = &info;
  mtf::System<double> system = view.sensor.system;
  const auto site = calib::parameter_site(system, target.path());
  if (row == nullptr || site.numbers.empty() || !is_given(view, target))
    return {std::nullopt, row != nullptr ? not_given(view, target, *row) : "the sensor file does not give it"};
  if (site.numbers.size() == 2 && *site.numbers[0] != *site.numbers[1])
    return {std::nullopt, "the sensor file gives pitch_x and pitch_y; name one of them, or write pitch there"};
  place.kind = Place::Kind::number;
  place.info = *row;
  place.info.lo = site.info.lo;
  place.info.hi = site.info.hi;
  place.info.lo_open = site.info.lo_open;
  place.info.hi_open = site.info.hi_open;
  place.value = *site.numbers.front();
  return {place};
}

/// A table that the file does not have, but could: "" when `name` is none of such a one.
std::string missing_table(const SensorView& view, std::string_view name) {
  const std::size_t dot = name.find('.');
  const std::string_view owner = dot == std::string_view::npos ? "" : name.substr(0, dot),
                         key = dot == std::string_view::npos ? name : name.substr(dot + 1);
  for (const mtf::TableInfo& table : view.sensor.schema) {
    if (mtf::find_table(view.sensor.tables, table.name) != nullptr || (!owner.empty() && table.name != owner)) continue;
    for (const mtf::FieldInfo& row : table.settings)
      if (row.name == key)
        return "the sensor file has no [" + std::string(table.name) + "]; write it there with " + std::string(key) +
               " = " + std::string(row.example);
  }
  return "";
}

/// The places of a key that stands alone: those that the file gives, else all.
std::vector<std::string> owners_of(const SensorView& view, std::string_view key) {
  const std::string_view stem = key.substr(0, key.find('['));
  const std::string element(key.substr(stem.size()));
  std::vector<std::string> given, all, paths;
  for (const auto& [name, target] : view.targets) {
    if (target.component && name.starts_with(target.table + "[")) continue;  // the label names it too
    if (target.key != stem || std::find(paths.begin(), paths.end(), target.path()) != paths.end()) continue;
    paths.push_back(target.path());
    all.push_back(name + element);
    if (is_given(view, target)) given.push_back(name + element);
  }
  if (!given.empty()) return given;
  // Components take from [optics] what they do not give themselves.
  const std::string shared = "optics." + std::string(key);
  return std::find(all.begin(), all.end(), shared) != all.end() ? std::vector{shared} : all;
}

}  // namespace

SensorView view_of(mtf::io::SensorConfig sensor) {
  SensorView view{.sensor = std::move(sensor), .tree = {}, .targets = {}};
  view.tree = cfg::read_tree(view.sensor.text).root;
  view.targets = cfg::targets_of(view.sensor);
  for (const auto& [table, key] : {std::pair{"frame", "format"}, std::pair{"band", "wavelength"}})
    view.targets.try_emplace(std::string(table) + "." + key, Target{.table = table, .key = key, .element = {}});
  return view;
}

Found find_place(const SensorView& view, std::string_view name) {
  std::string full(name);
  if (name.substr(0, name.find('[')).find('.') == std::string_view::npos && !view.targets.contains(name) &&
      !cfg::find_target(view.targets, name)) {
    const auto owners = owners_of(view, name);
    if (owners.size() > 1) {
      std::string list;
      for (std::size_t i = 0; i < owners.size() && i < 6; ++i) list += (i > 0 ? ", " : "") + owners[i];
      return {std::nullopt, "is the name of several: " + list + "; write the one that is meant"};
    }
    if (owners.size() == 1) full = owners[0];
  }
  const auto target = cfg::find_target(view.targets, full);
  if (!target) {
    const std::string missing = missing_table(view, full);
    if (!missing.empty()) return {std::nullopt, missing};
    return {std::nullopt, cfg::unknown_parameter(view.targets, full), true};
  }
  if (target->component) return of_component(view, *target);
  if (const mtf::FieldInfo* row = row_of(view, *target)) return of_setting(view, *target, *row);
  return of_system(view, *target);
}

bool overlap(std::string_view path, std::string_view other) {
  const auto within = [](std::string_view part, std::string_view whole) {
    return part == whole ||
           (part.starts_with(whole) &&
            (part.substr(whole.size()) == "_x" || part.substr(whole.size()) == "_y" ||
             part.substr(whole.size()).starts_with("[") || part.substr(whole.size()).starts_with(".")));
  };
  const auto replaces = [](std::string_view map, std::string_view number) {
    const std::string_view key = map_in_place_of(number);
    return !key.empty() && map == "nonuniformity." + std::string(key);
  };
  return !path.empty() && !other.empty() &&
         (within(path, other) || within(other, path) || replaces(path, other) || replaces(other, path));
}

}  // namespace study
