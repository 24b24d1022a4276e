// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/schedule.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>

#include "mtf/error.h"
#include "mtf/io/config_reader.h"
#include "mtf/io/curve_csv.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/schedule_csv.h"
#include "mtf/io/sha256.h"

namespace mtf::io {
namespace {

using cfg::Node;

constexpr std::size_t kMaxBytes = std::size_t{64} << 20;
constexpr std::size_t kMaxErrors = 20;

/// Where in the tree of a sensor file a parameter stands.
struct Target {
  std::string table;      ///< "frame", "optics", or the list of a component
  std::size_t index = 0;  ///< in that list
  bool component = false;
  std::string key;
  std::optional<std::size_t> element;  ///< of a list

  /// As diagnostics call it: "presample[1].rms".
  std::string path() const {
    return table + (component ? "[" + std::to_string(index) + "]" : "") + "." + key +
           (element ? "[" + std::to_string(*element) + "]" : "");
  }
};

/// Every parameter that a schedule may name, but for elements of lists.
std::map<std::string, Target, std::less<>> targets_of(const SensorConfig& sensor) {
  const System<double>& system = sensor.system;
  std::map<std::string, Target, std::less<>> targets;
  const auto add = [&](const std::string& owner, Target target, std::string_view key) {
    target.key = key;
    targets.try_emplace(owner + "." + target.key, std::move(target));
  };
  const Target frame{.table = "frame", .key = {}, .element = {}}, optics{.table = "optics", .key = {}, .element = {}};
  for (const std::string_view key : cfg::kFrameKeys)
    if (key != "format") add("frame", frame, key);
  for (const std::string_view key : cfg::kOpticsKeys) add("optics", optics, key);
  for (const TableInfo& info : sensor.schema)
    if (const std::string name(info.name); find_table(sensor.tables, name) != nullptr)
      for (const SettingInfo& row : info.settings) add(name, {.table = name, .key = {}, .element = {}}, row.info.name);
  for (const Stage stage : kStages)
    for (std::size_t i = 0; i < system.list(stage).size(); ++i) {
      const Entry<double>& entry = system.list(stage)[i];
      const std::string list(stage_name(stage));
      const Target target{.table = list, .index = i, .component = true, .key = {}, .element = {}};
      for (const FieldRef<double>& field : entry.component.fields())
        for (const std::string& owner : {entry.label, list + "[" + std::to_string(i) + "]"}) {
          const std::string name(field.info->name);
          add(owner, target, name);
          if (!std::holds_alternative<AxisPair<double>*>(field.value)) continue;
          add(owner, target, name + "_x");
          add(owner, target, name + "_y");
        }
    }
  return targets;
}

/// The target of "owner.field" or "owner.field[3]"; null when there is none.
std::optional<Target> find_target(const std::map<std::string, Target, std::less<>>& targets, std::string_view name) {
  if (const auto found = targets.find(name); found != targets.end()) return found->second;
  const std::size_t bracket = name.rfind('[');
  if (bracket == std::string_view::npos || !name.ends_with(']')) return std::nullopt;
  const auto found = targets.find(name.substr(0, bracket));
  if (found == targets.end()) return std::nullopt;
  Target target = found->second;
  const char* last = name.data() + name.size() - 1;
  const auto [end, status] = std::from_chars(name.data() + bracket + 1, last, target.element.emplace());
  return status == std::errc{} && end == last ? std::optional(target) : std::nullopt;
}

std::string unknown_parameter(const std::map<std::string, Target, std::less<>>& targets, const std::string& name) {
  std::vector<std::string_view> known;
  std::string shown;
  for (const auto& [key, target] : targets) known.push_back(key);
  if (name.size() <= 80)
    if (const auto guess = nearest(std::string_view(name), known)) shown = "; did you mean " + *guess + "?";
  return "the sensor has no parameter '" + printable(name, 80) + "'" + shown +
         " (label of a component and its field; mtf config explain shows them)";
}

/// A cell as the sensor file would hold it: a number, a list, or else a string.
Node node_of(const std::string& cell, int line) {
  Node node;
  node.position.line = line;
  const char* end = cell.data() + cell.size();
  const char* begin = cell.data() + (cell.starts_with('+') ? 1 : 0);
  if (cell.starts_with('[')) {
    const cfg::Tree tree = cfg::read_tree("value = " + cell);
    if (const Node* value = tree.root.find("value"); !tree.error && value != nullptr) {
      node = *value;
      node.position.line = line;
      return node;
    }
  }
  if (cell == "true" || cell == "false") {
    node.kind = Node::Kind::boolean;
    node.boolean = cell == "true";
    return node;
  }
  if (const auto [at, status] = std::from_chars(begin, end, node.integer); status == std::errc{} && at == end) {
    node.kind = Node::Kind::integer;
    node.number = static_cast<double>(node.integer);
  } else if (const auto [to, real] = std::from_chars(begin, end, node.number); real == std::errc{} && to == end) {
    node.kind = Node::Kind::real;
  } else {
    node.kind = Node::Kind::string;
    node.text = cell;
  }
  return node;
}

Node& child(Node& table, const std::string& key) {
  for (cfg::Member& member : table.members)
    if (member.key == key) return member.value;
  return table.members.emplace_back(cfg::Member{key, {}, {}}).value;
}

void remove(Node& table, const std::string& key) {
  std::erase_if(table.members, [&](const cfg::Member& member) { return member.key == key; });
}

/// Puts the value into the tree. What is wrong with that, "" when nothing is.
std::string put(Node& root, const Target& target, Node value) {
  Node& owner = child(root, target.table);
  Node& table = target.component ? owner.items.at(target.index) : owner;
  if (target.element) {
    const Node* list = table.find(target.key);
    const std::size_t size = list != nullptr && list->kind == Node::Kind::array ? list->items.size() : 0;
    if (*target.element >= size)
      return "the list has " + std::to_string(size) + " elements, counted from 0; write a longer one (with zeros) in " +
             "the sensor file";
    child(table, target.key).items[*target.element] = std::move(value);
    return "";
  }
  // A pair of axes stands as one value or as two, never as both.
  const bool one_axis = target.key.ends_with("_x") || target.key.ends_with("_y");
  const std::string stem = one_axis ? target.key.substr(0, target.key.size() - 2) : target.key;
  if (one_axis) {
    if (const Node* both = table.find(stem); both != nullptr) {
      const Node copy = *both;
      remove(table, stem);
      child(table, stem + "_x") = copy;
      child(table, stem + "_y") = copy;
    }
  } else {
    remove(table, stem + "_x");
    remove(table, stem + "_y");
  }
  child(table, target.key) = std::move(value);
  return "";
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (std::size_t i = 0; i < std::min(lines.size(), kMaxErrors); ++i) text += (i > 0 ? "\n" : "") + lines[i];
  return text;
}

}  // namespace

struct ScheduledSensor::State {
  SensorConfig sensor;
  Schedule schedule;
  Node root;
  std::map<std::string, Target, std::less<>> targets;
  std::size_t next = 0;                              ///< first setting that is not in force yet
  std::map<std::string, Setting, std::less<>> last;  ///< in force, by path

  /// The line that a finding about `path` comes from: the latest that set this value, a part of it, or something in
  /// its table; otherwise the latest of all.
  const Setting& cause(const std::string& path) const {
    const auto concerns = [&](const std::string& key) {
      return key == path || key == path + "_x" || key == path + "_y" || key.starts_with(path + "[") ||
             key.starts_with(path + ".") || path.starts_with(key + "[");
    };
    const Setting* found = nullptr;
    for (const auto& [key, setting] : last)
      if (concerns(key) && (found == nullptr || setting.frame > found->frame)) found = &setting;
    return found != nullptr ? *found : schedule.settings[next - 1];
  }
};

ScheduledSensor::ScheduledSensor(const SensorConfig& sensor, Schedule schedule)
    : state_(std::make_unique<State>(State{.sensor = sensor,
                                           .schedule = std::move(schedule),
                                           .root = cfg::read_tree(sensor.text).root,
                                           .targets = targets_of(sensor),
                                           .last = {}})) {}
ScheduledSensor::~ScheduledSensor() = default;
ScheduledSensor::ScheduledSensor(ScheduledSensor&&) noexcept = default;
ScheduledSensor& ScheduledSensor::operator=(ScheduledSensor&&) noexcept = default;

const SensorConfig& ScheduledSensor::sensor() const { return state_->sensor; }

std::string ScheduledSensor::in_force() const {
  std::string text;
  for (const auto& [path, setting] : state_->last)
    text += (text.empty() ? "" : "; ") + setting.parameter + " = " + setting.value;
  return text;
}

bool ScheduledSensor::advance(std::int64_t frame) {
  State& s = *state_;
  const std::string& file = s.schedule.file;
  std::vector<std::string> errors;
  bool changed = false;
  for (; s.next < s.schedule.settings.size() && s.schedule.settings[s.next].frame <= frame; ++s.next) {
    const Setting& setting = s.schedule.settings[s.next];
    const auto target = find_target(s.targets, setting.parameter);
    if (!target) {
      errors.push_back(schedule_error(file, setting.line, unknown_parameter(s.targets, setting.parameter)));
      continue;
    }
    if (const std::string wrong = put(s.root, *target, node_of(setting.value, setting.line)); !wrong.empty())
      errors.push_back(schedule_error(file, setting.line, printable(setting.parameter, 80) + ": " + wrong));
    const std::string path = target->path();
    std::erase_if(s.last, [&](const auto& item) {  // axes and elements that this value replaces
      return item.first == path + "_x" || item.first == path + "_y" || item.first.starts_with(path + "[");
    });
    s.last.insert_or_assign(path, setting);
    changed = true;
  }
  if (!errors.empty()) throw UsageError(joined(errors));
  if (!changed) return false;

  ConfigResult result;
  result.config.file = s.sensor.file;
  result.config.text = s.sensor.text;
  result.config.schema = s.sensor.schema;
  result.config.sha256 = s.sensor.sha256;
  cfg::interpret(s.root, result);
  for (const Diagnostic& diagnostic : result.diagnostics) {
    if (!diagnostic.error) continue;
    const Setting& cause = s.cause(diagnostic.path);
    errors.push_back(schedule_error(file, cause.line,
                                    printable(cause.parameter, 80) + " = " + printable(cause.value, 80) + " at frame " +
                                        std::to_string(cause.frame) + ": " + diagnostic.text));
  }
  if (!errors.empty()) throw UsageError(joined(errors));
  s.sensor = std::move(result.config);
  return true;
}

Schedule parse_schedule(std::string_view text, const std::string& file, const SensorConfig& sensor) {
  std::vector<std::string> errors;
  Schedule schedule{.file = file, .sha256 = sha256_hex(std::string(text)), .settings = {}};
  schedule.settings = read_settings(text, file, errors);
  std::stable_sort(schedule.settings.begin(), schedule.settings.end(),
                   [](const Setting& a, const Setting& b) { return a.frame < b.frame; });
  const auto targets = targets_of(sensor);
  std::map<std::pair<std::int64_t, std::string>, int> seen;
  for (const Setting& setting : schedule.settings) {
    if (errors.size() >= kMaxErrors) break;
    const auto target = find_target(targets, setting.parameter);
    if (!target) {
      errors.push_back(schedule_error(file, setting.line, unknown_parameter(targets, setting.parameter)));
      continue;
    }
    const auto [first, fresh] = seen.try_emplace({setting.frame, target->path()}, setting.line);
    if (fresh) continue;
    errors.push_back(schedule_error(file, setting.line,
                                    printable(setting.parameter, 80) + " is set at frame " +
                                        std::to_string(setting.frame) + " by line " + std::to_string(first->second) +
                                        " already; leave one"));
  }
  if (!errors.empty()) throw UsageError(joined(errors));
  ScheduledSensor check(sensor, schedule);
  for (const Setting& setting : schedule.settings) check.advance(setting.frame);
  return schedule;
}

Schedule read_schedule(const std::string& path, const SensorConfig& sensor) {
  return parse_schedule(read_text_file(path, kMaxBytes), path, sensor);
}

}  // namespace mtf::io
