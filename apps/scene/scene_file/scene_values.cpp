// SPDX-License-Identifier: Apache-2.0

// One value of each kind, from the tree of a scene file into SI.

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "apps/scene/scene_file/scene_reader.h"
#include "apps/scene/weather/si_units.h"
#include "apps/scene/weather/timed_table.h"
#include "apps/scene/weather/weather_csv.h"
#include "apps/text/words.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/file_checks.h"

namespace apps::scene {
namespace {

namespace cfg = mtf::io::cfg;
using cfg::Node;
using cfg::Section;
using mtf::FieldInfo;
using mtf::io::printable;
using radiometry::heat::Schedule;

constexpr std::size_t kLongestText = 1024;

/// The example without its quotes: "45 W/m/K".
std::string bare_example(const FieldInfo& field) {
  std::string text(field.example);
  std::erase(text, '"');
  return text;
}

/// The unit of the example: "W/m/K".
std::string example_unit(const FieldInfo& field) {
  const std::string text = bare_example(field);
  const std::size_t blank = text.find(' ');
  return blank == std::string::npos ? std::string(field.unit) : text.substr(blank + 1);
}

bool names_table(std::string_view text) { return text.ends_with(".csv") || text.ends_with(".CSV"); }

/// The first cell of the first line that is no comment.
std::string first_cell(std::string_view text) {
  text = mtf::io::without_mark(text);
  while (!text.empty()) {
    const std::string_view row = mtf::io::take_text_line(text);
    if (!mtf::io::is_comment(row)) return std::string(mtf::io::split_cells(row, mtf::io::separator_of(row)).front());
  }
  return {};
}

}  // namespace

std::optional<double> read_plain_si(const Section& section, const Node& node, const FieldInfo& field,
                                    const std::string& path) {
  const auto fail = [&](const std::string& text) {
    section.reader.error(node.position, path, text);
    return std::nullopt;
  };
  double value = 0.0;
  if (node.is_number() && field.unit.empty()) {
    if (!std::isfinite(node.number)) return fail(cfg::shown(node) + " is not finite; write an ordinary number");
    value = node.number;
  } else if (node.is_number()) {
    return fail(cfg::shown(node) + " has no unit; write \"" + (std::isfinite(node.number) ? cfg::shown(node) : "1") +
                " " + example_unit(field) + "\"");
  } else if (node.kind != Node::Kind::string || node.text.size() > kLongestText) {
    return fail(std::string(cfg::kind_word(node.kind)) + " where a number" + (field.unit.empty() ? "" : " with unit") +
                " belongs; write for example " + std::string(field.name) + " = " + std::string(field.example));
  } else {
    try {
      value = parse_si(node.text, field.unit, bare_example(field));
    } catch (const mtf::UsageError& error) {
      return fail(printable(error.what(), 400));
    }
  }
  if (mtf::in_range(field, value)) return value;
  const bool in_other_unit =
      !node.is_number() && !field.unit.empty() && !node.text.ends_with(" " + std::string(field.unit));
  const std::string given = in_other_unit ? printable(node.text, 60) + ", which is " + significant(value, 9) + " " +
                                                std::string(field.unit) + ","
                                          : mtf::with_unit(mtf::format_double(value), field.unit);
  return fail(given + " is outside " + mtf::range_text(field, field.unit));
}

std::optional<double> read_si(const Section& section, const FieldInfo& field) {
  const Node* node = section.find(field.name);
  const std::string path = section.at(field.name);
  if (node != nullptr && node->kind == Node::Kind::table) return read_marked(section, *node, field, path);
  if (node != nullptr) return read_plain_si(section, *node, field, path);
  if (field.presence == mtf::Presence::required && !section.reader.has_failed(path))
    section.error(field.name, cfg::missing_text(field));
  return std::nullopt;
}

const Node* find_section(SceneReader& s, std::string_view key, std::string_view remedy) {
  const Node* node = cfg::find_table(s.root(), key);
  if (node == nullptr && !remedy.empty() && !s.reader.has_failed(key))
    s.reader.error({}, std::string(key), "missing; " + std::string(remedy));
  return node;
}

const Node* find_tables(SceneReader& s, std::string_view key) {
  const Node* node = s.tree.find(key);
  if (node == nullptr) return nullptr;
  const auto is_table = [](const Node& item) { return item.kind == Node::Kind::table; };
  if (node->kind == Node::Kind::array && std::all_of(node->items.begin(), node->items.end(), is_table)) return node;
  s.reader.error(node->position, std::string(key),
                 std::string(cfg::kind_word(node->kind)) + " where a list of tables belongs; write [[" +
                     std::string(key) + "]] on a line of its own and its keys below it");
  return nullptr;
}

std::string read_name(const Section& section, std::vector<std::string_view>& names, std::string_view example) {
  const auto name = cfg::read_string(section, "name");
  if (section.find("name") == nullptr && !section.reader.has_failed(section.at("name")))
    section.error("name", "missing; write name = \"" + std::string(example) + "\", which others refer to");
  if (name && name->empty()) section.error("name", "an empty name");
  if (name && !name->empty() && std::find(names.begin(), names.end(), *name) != names.end())
    section.error("name", "the name stands twice");
  names.push_back(name ? std::string_view(section.find("name")->text) : std::string_view());
  return name.value_or("");
}

std::optional<std::string> read_path(const Section& section, std::string_view key) {
  const auto name = cfg::read_string(section, key);
  if (!name) return std::nullopt;
  if (!name->empty() && name->find('\0') == std::string::npos) return section.reader.file(*name);
  section.error(key, "no file name");
  return std::nullopt;
}

std::optional<std::string> out_of_range(const Schedule& schedule, const FieldInfo& field, double origin_s) {
  for (std::size_t i = 0; i < schedule.value.size(); ++i) {
    if (mtf::in_range(field, schedule.value[i])) continue;
    const TimedTable table = parse_timed_table(mtf::io::read_table_text(schedule.source), schedule.source, origin_s);
    const auto at = std::find(table.time_s.begin(), table.time_s.end(), schedule.time_s[i]) - table.time_s.begin();
    return error_at(schedule.source, table.line.at(static_cast<std::size_t>(at))) +
           mtf::outside_text(field, schedule.value[i], field.unit);
  }
  return std::nullopt;
}

std::optional<Schedule> read_schedule_value(SceneReader& s, const Section& section, const FieldInfo& field) {
  const Node* node = section.find(field.name);
  if (node == nullptr || node->kind != Node::Kind::string || !names_table(node->text)) {
    const auto value = read_si(section, field);
    return value ? std::optional(radiometry::heat::constant_schedule(*value)) : std::nullopt;
  }
  const auto path = read_path(section, field.name);
  if (!path) return std::nullopt;
  const auto fail = [&](const std::string& text) {
    section.error(field.name, printable(text, 600));
    return std::nullopt;
  };
  try {
    Schedule schedule = read_schedule(*path, field.unit, s.scene.time.start_s);
    if (const auto problem = out_of_range(schedule, field, s.scene.time.start_s)) return fail(*problem);
    return schedule;
  } catch (const mtf::Error& error) {
    return fail(error.what());
  }
}

std::optional<GivenTemperature> read_given_temperature(SceneReader& s, const Section& section) {
  const Node* node = section.find(kTemperature.name);
  if (node == nullptr) return std::nullopt;
  const bool text = node->kind == Node::Kind::string;
  if (text && node->text.ends_with(".npy")) {
    auto path = read_path(section, kTemperature.name);
    if (path) section.reader.file((std::filesystem::path(node->text).parent_path() / "times.csv").string());
    return path ? std::optional(GivenTemperature{.schedule = {}, .table = std::move(*path)}) : std::nullopt;
  }
  if (text && names_table(node->text)) try {
      const std::string path = section.reader.file(node->text);
      if (first_cell(mtf::io::read_table_text(path)) == "facet") return GivenTemperature{.schedule = {}, .table = path};
    } catch (const mtf::Error& error) {
      section.error(kTemperature.name, printable(error.what(), 600));
      return std::nullopt;
    }
  auto schedule = read_schedule_value(s, section, kTemperature);
  return schedule ? std::optional(GivenTemperature{.schedule = std::move(*schedule), .table = {}}) : std::nullopt;
}

std::optional<std::array<double, 3>> read_point(const Section& section, std::string_view key) {
  constexpr double kFarthest_m = 1e6;
  const Node* node = section.find(key);
  if (node == nullptr) return std::nullopt;
  const FieldInfo field{.name = key, .unit = "m", .lo = -kFarthest_m, .hi = kFarthest_m, .example = "\"14 m\""};
  if (node->kind != Node::Kind::array || node->items.size() != 3) {
    section.error(
        key, "a list of three lengths belongs here: x east, y north, z up, such as [\"14 m\", \"-12 m\", \"5 m\"]");
    return std::nullopt;
  }
  std::array<double, 3> point{};
  bool good = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto value = read_plain_si(section, node->items[i], field, section.at(key) + "[" + std::to_string(i) + "]");
    good = good && value;
    point[i] = value.value_or(0.0);
  }
  return good ? std::optional(point) : std::nullopt;
}

std::optional<std::size_t> read_reference(const Section& section, std::string_view key,
                                          const std::vector<std::string_view>& names, std::string_view what) {
  const auto name = cfg::read_string(section, key);
  if (!name) return std::nullopt;
  const auto found = std::find(names.begin(), names.end(), *name);
  if (found != names.end() && !name->empty()) return static_cast<std::size_t>(found - names.begin());
  // A table whose name is missing, which was reported, may be the one that is meant.
  if (std::find(names.begin(), names.end(), "") != names.end()) {
    section.reader.failed.insert(section.at(key));
    return std::nullopt;
  }
  section.error(key,
                "there is no " + std::string(what) + " \"" + printable(*name, 60) + "\"" +
                    (names.empty() ? "; define it as [[" + std::string(what) + "]]" : cfg::suggestion(*name, names)));
  return std::nullopt;
}

}  // namespace apps::scene
