// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/config_edit.h"

#include <charconv>

#include "mtf/io/config/config_reader.h"
#include "mtf/words.h"

namespace mtf::io::cfg {

Targets targets_of(const SensorConfig& sensor) {
  const System<double>& system = sensor.system;
  Targets targets;
  const auto add = [&](const std::string& owner, Target target, std::string_view key) {
    target.key = key;
    targets.try_emplace(owner + "." + target.key, std::move(target));
  };
  for (const std::string table : {"frame", "optics", "band"})
    for (const FieldInfo& row : own_rows(table))
      if (table == "band" ? system.band.has_value() : row.type != FieldType::pair)
        for (const std::string& key : keys_of(row)) add(table, {.table = table}, key);
  for (const TableInfo& info : sensor.schema)
    if (const std::string name(info.name); find_table(sensor.tables, name) != nullptr)
      for (const FieldInfo& row : info.settings) add(name, {.table = name}, row.name);
  for (const Stage stage : kStages)
    for (std::size_t i = 0; i < system.list(stage).size(); ++i) {
      const Entry<double>& entry = system.list(stage)[i];
      const std::string list(stage_name(stage));
      const Target target{.table = list, .index = i, .component = true};
      for (const FieldRef<double>& field : entry.component.fields())
        for (const std::string& owner : {entry.label, list + "[" + std::to_string(i) + "]"})
          for (const std::string& key : keys_of(*field.info)) add(owner, target, key);
    }
  return targets;
}

std::optional<Target> find_target(const Targets& targets, std::string_view name) {
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

std::string unknown_parameter(const Targets& targets, const std::string& name) {
  std::vector<std::string_view> known;
  std::string shown;
  for (const auto& [key, target] : targets) known.push_back(key);
  if (name.size() <= 80)
    if (const auto guess = nearest(std::string_view(name), known)) shown = "; did you mean " + *guess + "?";
  return "the sensor has no parameter '" + printable(name, 80) + "'" + shown +
         " (label of a component and its field; mtf config explain shows them)";
}

Node node_of(const std::string& cell, int line) {
  Node node;
  node.position.line = line;
  const char* end = cell.data() + cell.size();
  const char* begin = cell.data() + (cell.starts_with('+') ? 1 : 0);
  if (cell.starts_with('[')) {
    const Tree tree = read_tree("value = " + cell);
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

namespace {

Node& child(Node& table, const std::string& key) {
  for (Member& member : table.members)
    if (member.key == key) return member.value;
  return table.members.emplace_back(Member{key, {}, {}}).value;
}

void remove(Node& table, const std::string& key) {
  std::erase_if(table.members, [&](const Member& member) { return member.key == key; });
}

}  // namespace

std::optional<std::string> pair_of_axis(std::string_view key) {
  if (!key.ends_with("_x") && !key.ends_with("_y")) return std::nullopt;
  return std::string(key.substr(0, key.size() - 2));
}

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
  if (const auto pair = pair_of_axis(target.key)) {
    if (const Node* both = table.find(*pair); both != nullptr) {
      const Node copy = *both;
      remove(table, *pair);
      child(table, *pair + "_x") = copy;
      child(table, *pair + "_y") = copy;
    }
  } else {
    remove(table, target.key + "_x");
    remove(table, target.key + "_y");
  }
  Node& old = child(table, target.key);
  if (is_over_field(old, {}) && value.kind != Node::Kind::table)
    return "it changes over the field of view; set its terms in the sensor file, with 1 = ... for the optical axis";
  old = std::move(value);
  return "";
}

}  // namespace mtf::io::cfg
