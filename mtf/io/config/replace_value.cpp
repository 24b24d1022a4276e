// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/replace_value.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "mtf/error.h"
#include "mtf/io/config/config_edit.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

using cfg::end_of_value;
using cfg::Member;
using cfg::Node;
using cfg::number_of;
using cfg::offset_of;
using cfg::TableText;
using cfg::Target;

/// Equal values under equal keys; the order of keys and their positions do not count.
bool same_values(const Node& a, const Node& b) {
  if (a.kind != b.kind) return false;
  if (a.kind == Node::Kind::string || a.kind == Node::Kind::date) return a.text == b.text;
  if (a.kind == Node::Kind::integer) return a.integer == b.integer;
  if (a.kind == Node::Kind::real) return a.number == b.number || (std::isnan(a.number) && std::isnan(b.number));
  if (a.kind == Node::Kind::boolean) return a.boolean == b.boolean;
  if (a.kind == Node::Kind::array)
    return std::equal(a.items.begin(), a.items.end(), b.items.begin(), b.items.end(), same_values);
  return a.members.size() == b.members.size() && std::ranges::all_of(a.members, [&](const Member& member) {
           const Node* other = b.find(member.key);
           return other != nullptr && same_values(member.value, *other);
         });
}

std::string toml_value(const Node& node, std::string_view given) {
  if (node.kind == Node::Kind::integer) return std::to_string(node.integer);
  if (node.kind == Node::Kind::real) return cfg::toml_number(node.number);
  if (node.kind == Node::Kind::string) return cfg::toml_string(node.text);
  return std::string(given);  // a list, true or false, which were read as TOML
}

const Node* table_of(const Node& root, const Target& target) {
  const Node* owner = root.find(target.table);
  if (owner == nullptr || !target.component) return owner;
  return target.index < owner->items.size() ? &owner->items[target.index] : nullptr;
}

/// A table { value = ..., fit = ... } takes the place of the whole; a number that of the number in such a table.
const Node& replaced_node(const Node& old, std::string_view value) {
  return value.starts_with('{') ? old : *number_of(&old);
}

/// The value that a text stands for, a table among them. A table that cannot be read is the text itself, which no key
/// takes.
Node wanted_node(std::string_view value) {
  if (value.starts_with('{')) {
    const cfg::Tree tree = cfg::read_tree("value = " + std::string(value));
    if (const Node* table = tree.root.find("value"); !tree.error && table != nullptr) return *table;
  }
  return cfg::node_of(std::string(value), 0);
}

std::string new_text(std::string_view text, const Node& root, const Target& target, const std::string& value) {
  const std::string line = target.key + " = " + value;
  const Node* table = table_of(root, target);
  if (table == nullptr)
    return std::string(text) + (text.ends_with('\n') ? "\n[" : "\n\n[") + target.table + "]\n" + line + "\n";
  TableText out(text, *table);
  const Node* old = table->find(target.key);
  if (target.element && old != nullptr) {
    out.replace(replaced_node(old->items.at(*target.element), value), value);
    return out.text();
  }
  const auto pair = cfg::pair_of_axis(target.key);
  const std::string stem = pair.value_or(target.key), x = stem + "_x", y = stem + "_y";
  if (old != nullptr) {
    out.replace(replaced_node(*old, value), value);
  } else if (const Node* both = pair ? table->find(stem) : nullptr; both != nullptr) {
    const std::size_t begin = offset_of(text, both->position);
    const std::string kept(text.substr(begin, end_of_value(text, begin) - begin));
    out.replace_line(stem, x + " = " + (target.key == x ? value : kept), y + " = " + (target.key == y ? value : kept));
  } else if (!pair && (table->find(x) != nullptr || table->find(y) != nullptr)) {
    const bool has_x = table->find(x) != nullptr;
    out.replace_line(has_x ? x : y, line);
    if (has_x && table->find(y) != nullptr) out.remove_line(y);
  } else {
    out.add_line(line);
  }
  return out.text();
}

/// The tree that the new text has to have. A fit keeps its marks.
std::string put_value(Node& root, const Target& target, const Node& value) {
  const Node* table = table_of(root, target);
  const Node* old = table != nullptr ? table->find(target.key) : nullptr;
  if (old != nullptr && target.element && *target.element < old->items.size()) old = &old->items[*target.element];
  Node wanted = value;
  if (const Node* number = number_of(old); number != old && value.kind != Node::Kind::table) {
    wanted = *old;
    for (Member& member : wanted.members)
      if (member.key == "value" || member.key == "1") member.value = value;
  }
  return cfg::put(root, target, std::move(wanted));
}

/// The target of a name: a parameter that studies change too, or any key of a table, "scene.border", "adc.bits", also
/// of one that the file does not have. Whether the table knows the key, its reader says.
std::optional<Target> target_of(const SensorConfig& config, const cfg::Targets& targets, std::string_view name) {
  if (const auto found = cfg::find_target(targets, name)) return found;
  const std::size_t dot = name.find('.');
  if (dot == std::string_view::npos) return std::nullopt;
  const std::string_view table = name.substr(0, dot), key = name.substr(dot + 1);
  constexpr std::array<std::string_view, 4> kOwn{"frame", "scene", "optics", "band"};
  const bool known = std::ranges::find(kOwn, table) != kOwn.end() ||
                     std::ranges::any_of(config.schema, [&](const TableInfo& t) { return t.name == table; });
  if (!known) return std::nullopt;
  Target whole{.table = std::string(table), .key = std::string(key.substr(0, key.find('[')))};
  const auto plain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  if (whole.key.empty() || !std::ranges::all_of(whole.key, plain)) return std::nullopt;
  return cfg::find_target({{whole.path(), whole}}, name);
}

/// A parameter in the tree of the file. Throws UsageError for a text that cannot be read or is none of the sensor's.
struct Located {
  cfg::Tree tree;
  Target target;
  const Node* table() const { return table_of(tree.root, target); }
};
Located located(const SensorConfig& config, std::string_view parameter) {
  cfg::Tree tree = cfg::read_tree(config.text);
  if (tree.error) throw UsageError(format_diagnostic(*tree.error, config.file));
  const cfg::Targets targets = cfg::targets_of(config);
  const auto target = target_of(config, targets, parameter);
  if (!target) throw UsageError(config.file + ": " + cfg::unknown_parameter(targets, std::string(parameter)));
  return {std::move(tree), *target};
}

/// What was changed is read again: a table written in an unusual form is refused, never changed into something else.
void require_tree(const std::string& text, const Node& expected, const std::string& problem, const Target& target) {
  const cfg::Tree result = cfg::read_tree(text);
  if (result.error || !same_values(result.root, expected))
    throw UsageError(problem + " in place; write [" + target.table + "] with one `key = value` a line");
}

}  // namespace

std::string replace_value(const SensorConfig& config, std::string_view parameter, std::string_view value) {
  const std::string where = config.file + ": " + printable(std::string(parameter), 80) + ": ";
  const Located at = located(config, parameter);
  const Node wanted = wanted_node(value);
  Node expected = at.tree.root;
  if (const std::string problem = put_value(expected, at.target, wanted); !problem.empty())
    throw UsageError(where + problem);
  std::string text = new_text(config.text, at.tree.root, at.target, toml_value(wanted, value));
  require_tree(text, expected, where + "cannot be set to " + printable(value, 80), at.target);
  return text;
}

std::string without_value(const SensorConfig& config, std::string_view parameter) {
  const std::string where = config.file + ": " + printable(std::string(parameter), 80) + ": ";
  const Located at = located(config, parameter);
  const Target& target = at.target;
  const Node* table = at.table();
  if (table == nullptr || target.element || table->find(target.key) == nullptr)
    throw UsageError(where + "the file does not state it");
  TableText out(config.text, *table);
  out.remove_line(target.key);
  std::string text = out.text();
  Node expected = at.tree.root;
  const auto remove = [&](Node& owner) {
    std::erase_if(owner.members, [&](const Member& member) { return member.key == target.key; });
  };
  for (Member& member : expected.members)
    if (member.key == target.table) remove(target.component ? member.value.items.at(target.index) : member.value);
  require_tree(text, expected, where + "cannot be taken out", target);
  return text;
}

std::string stated_value(const SensorConfig& config, std::string_view parameter) {
  const Located at = located(config, parameter);
  const Target& target = at.target;
  const Node* table = at.table();
  const Node* value = table != nullptr ? table->find(target.key) : nullptr;
  if (value == nullptr && table != nullptr)  // of both axes
    if (const auto pair = cfg::pair_of_axis(target.key)) value = table->find(*pair);
  if (value != nullptr && target.element) {
    if (*target.element >= value->items.size())
      throw UsageError(config.file + ": " + printable(std::string(parameter), 80) + ": " +
                       (value->kind != Node::Kind::array
                            ? "is one value, not a list; leave the index out"
                            : "the list has " + plural(static_cast<std::int64_t>(value->items.size()), "value") +
                                  ", counted from 0"));
    value = &value->items[*target.element];
  }
  if (value == nullptr) return {};
  const std::size_t begin = offset_of(config.text, number_of(value)->position);
  return config.text.substr(begin, end_of_value(config.text, begin) - begin);
}

SensorConfig replaced(const SensorConfig& config, std::string_view parameter, std::string_view value) {
  ConfigResult result = parse_config(replace_value(config, parameter, value), config.file, config.schema);
  cfg::require_no_errors(result.diagnostics, config.file);
  return std::move(result.config);
}

}  // namespace mtf::io
