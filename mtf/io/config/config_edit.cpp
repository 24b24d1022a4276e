// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/config_edit.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "mtf/error.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/config/replace_value.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace mtf::io::cfg {
namespace {

/// Where the string that starts at `begin` ends; three quotes open a string over several lines.
std::size_t end_of_string(std::string_view text, std::size_t begin) {
  const char quote = text[begin];
  const std::string three(3, quote);
  const std::string_view closing =
      text.substr(begin).starts_with(three) ? std::string_view(three) : text.substr(begin, 1);
  std::size_t at = begin + closing.size();
  while (at < text.size() && !text.substr(at).starts_with(closing)) at += quote == '"' && text[at] == '\\' ? 2 : 1;
  return std::min(at + closing.size(), text.size());
}

Node& child(Node& table, const std::string& key) {
  for (Member& member : table.members)
    if (member.key == key) return member.value;
  return table.members.emplace_back(Member{key, {}, {}}).value;
}

void remove(Node& table, const std::string& key) {
  std::erase_if(table.members, [&](const Member& member) { return member.key == key; });
}

// One value of a sensor file changed in its text.

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
  if (node.kind == Node::Kind::real) return toml_number(node.number);
  if (node.kind == Node::Kind::string) return toml_string(node.text);
  return std::string(given);  // a list, true or false, which were read as TOML
}

const Node* table_of(const Node& root, const Target& target) {
  const Node* owner = root.find(target.table);
  if (owner == nullptr || !target.component) return owner;
  return target.index < owner->items.size() ? &owner->items[target.index] : nullptr;
}

/// The number that the file has for a target, its element of a list; null where it has none.
template <class AnyNode>
AnyNode* number_at(AnyNode* table, const Target& target) {
  if (table == nullptr) return nullptr;
  for (auto& member : table->members) {
    if (member.key != target.key) continue;
    if (!target.element) return &member.value;
    return *target.element < member.value.items.size() ? &member.value.items[*target.element] : nullptr;
  }
  return nullptr;
}

/// Gives a number that term; one that is not over the field yet is that of the optical axis. What is wrong, "" when
/// nothing is.
std::string put_term(Node& number, const std::string& term, Node value) {
  const bool table = number.kind == Node::Kind::table;
  if (table && !number.members.empty() && !is_over_field(number, {}))
    return "is a table of a fit; write it with terms in the sensor file";
  if (!table) {
    Node terms;
    terms.position = number.position;
    terms.members.push_back({"1", number.position, std::move(number)});
    number = std::move(terms);
  }
  child(number, term) = std::move(value);
  return "";
}

/// A table { value = ..., fit = ... } takes the place of the whole; a number that of the number in such a table.
const Node& replaced_node(const Node& old, std::string_view value) {
  return value.starts_with('{') ? old : *number_of(&old);
}

/// The value that a text stands for, a table among them. A table that cannot be read is the text itself, which no key
/// takes.
Node wanted_node(std::string_view value) {
  if (value.starts_with('{')) {
    const Tree tree = read_tree("value = " + std::string(value));
    if (const Node* table = tree.root.find("value"); !tree.error && table != nullptr) return *table;
  }
  return node_of(std::string(value), 0);
}

std::string new_text(std::string_view text, const Node& root, const Target& target, std::string value) {
  const Node* table = table_of(root, target);
  if (!target.term.empty() && table != nullptr) {
    const Node* number = number_at(table, target);
    if (number != nullptr && number->kind == Node::Kind::table) {
      TableText out(text, *number);
      if (const Node* term = number->find(target.term); term != nullptr)
        out.replace(replaced_node(*term, value), value);
      else
        out.add_line(target.term + " = " + value);
      return out.text();
    }
    if (const auto pair = pair_of_axis(target.key); number == nullptr && pair) number = table->find(*pair);
    std::string on_axis;
    if (number != nullptr && target.term != "1") {
      const std::size_t begin = offset_of(text, number->position);
      on_axis = "1 = " + std::string(text.substr(begin, end_of_value(text, begin) - begin)) + ", ";
    }
    value = "{ " + on_axis + target.term + " = " + value + " }";
  }
  const std::string line = target.key + " = " + value;
  if (table == nullptr)
    return std::string(text) + (text.ends_with('\n') ? "\n[" : "\n\n[") + target.table + "]\n" + line + "\n";
  TableText out(text, *table);
  const Node* old = table->find(target.key);
  if (target.element && old != nullptr) {
    out.replace(replaced_node(old->items.at(*target.element), value), value);
    return out.text();
  }
  const auto pair = pair_of_axis(target.key);
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
  const Node* old = number_at(table, target);
  if (old != nullptr && !target.term.empty()) old = old->find(target.term);
  Node wanted = value;
  if (const Node* number = number_of(old); number != old && value.kind != Node::Kind::table) {
    wanted = *old;
    for (Member& member : wanted.members)
      if (member.key == "value" || member.key == "1") member.value = value;
  }
  return put(root, target, std::move(wanted));
}

/// The target of a name: a parameter that studies change too, or any key of a table, "scene.border", "adc.bits", also
/// of one that the file does not have. Whether the table knows the key, its reader says.
std::optional<Target> target_of(const SensorConfig& config, const Targets& targets, std::string_view name) {
  if (const auto found = find_target(targets, name)) return found;
  const std::size_t dot = name.find('.');
  if (dot == std::string_view::npos) return std::nullopt;
  const std::string_view table = name.substr(0, dot), key = name.substr(dot + 1);
  const auto is_it = [&](const TableInfo& info) { return info.name == table; };
  if (std::ranges::none_of(own_tables(), is_it) && std::ranges::none_of(config.schema, is_it)) return std::nullopt;
  Target whole{.table = std::string(table), .key = std::string(key.substr(0, key.find('[')))};
  const auto plain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  if (whole.key.empty() || !std::ranges::all_of(whole.key, plain)) return std::nullopt;
  return find_target({{whole.path(), whole}}, name);
}

/// A parameter in the tree of the file. Throws UsageError for a text that cannot be read or is none of the sensor's.
struct Located {
  Tree tree;
  Target target;
  const Node* table() const { return table_of(tree.root, target); }
};
Located located(const SensorConfig& config, std::string_view parameter) {
  Tree tree = read_tree(config.text);
  if (tree.error) throw UsageError(format_diagnostic(*tree.error, config.file));
  const Targets targets = targets_of(config);
  const auto target = target_of(config, targets, parameter);
  if (!target) throw UsageError(config.file + ": " + unknown_parameter(targets, std::string(parameter)));
  return {std::move(tree), *target};
}

/// What was changed is read again: a table written in an unusual form is refused, never changed into something else.
void require_tree(const std::string& text, const Node& expected, const std::string& problem, const Target& target) {
  const Tree result = read_tree(text);
  if (result.error || !same_values(result.root, expected))
    throw UsageError(problem + " in place; write [" + target.table + "] with one `key = value` a line");
}

}  // namespace

std::string edited(std::string_view text, std::vector<Edit> edits) {
  std::stable_sort(edits.begin(), edits.end(), [](const Edit& a, const Edit& b) { return a.begin < b.begin; });
  std::string result;
  std::size_t at = 0;
  for (const Edit& edit : edits) {
    if (edit.begin < at) continue;
    result.append(text, at, edit.begin - at);
    result += edit.text;
    at = edit.end;
  }
  return result.append(text, at);
}

std::size_t offset_of(std::string_view text, Position position) {
  std::size_t at = 0;
  for (int line = 1; line < position.line; ++line) {
    at = text.find('\n', at);
    if (at == std::string_view::npos) return text.size();
    ++at;
  }
  const auto inside = [&](std::size_t i) { return i < text.size() && (static_cast<unsigned char>(text[i]) >> 6) == 2; };
  for (int column = 1; column < position.column && at < text.size(); ++column) do
      ++at;
    while (inside(at));
  return at;
}

std::size_t end_of_value(std::string_view text, std::size_t begin) {
  if (begin >= text.size()) return begin;
  const auto is_quote = [&](std::size_t i) { return text[i] == '"' || text[i] == '\''; };
  if (is_quote(begin)) return end_of_string(text, begin);
  if (text[begin] != '[' && text[begin] != '{') return std::min(text.find_first_of(" \t\r\n,}]#", begin), text.size());
  int depth = 0;
  for (std::size_t at = begin; at < text.size();) {
    if (is_quote(at)) {
      at = end_of_string(text, at);
    } else if (text[at] == '#') {
      at = std::min(text.find('\n', at), text.size());
    } else {
      depth +=
          static_cast<int>(text[at] == '[' || text[at] == '{') - static_cast<int>(text[at] == ']' || text[at] == '}');
      ++at;
      if (depth == 0) return at;
    }
  }
  return text.size();
}

std::string toml_number(double value) {
  std::string text = format_double(value);
  // Without a point it would be an integer, of 64 bits only.
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string toml_string(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (code < 0x20 || code == 0x7f) {
      quoted += std::string("\\u00") + digits[code >> 4] + digits[code & 15];
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

const Node* number_of(const Node* value) {
  const Node* inner = value != nullptr && value->kind == Node::Kind::table ? value->find("value") : nullptr;
  if (inner == nullptr && value != nullptr && value->kind == Node::Kind::table)
    inner = value->find("1");  // on the axis
  return inner != nullptr ? inner : value;
}

void TableText::replace(const Node& old, const std::string& value) {
  const std::size_t begin = offset_of(text_, old.position);
  edits_.push_back({begin, end_of_value(text_, begin), value});
}

void TableText::replace_line(std::string_view key, std::string_view first, std::string_view second) {
  const Member& member = member_of(key);
  const std::size_t begin = offset_of(text_, member.position);
  const std::string gap = is_inline() ? ", " : "\n" + std::string(indentation(begin));
  edits_.push_back({begin, end_of(member), std::string(first) + (second.empty() ? "" : gap + std::string(second))});
}

void TableText::remove_line(std::string_view key) {
  const Member& member = member_of(key);
  std::size_t begin = offset_of(text_, member.position), end = end_of(member);
  if (is_inline()) {  // with the comma before or after it
    const std::size_t before = text_.find_last_not_of(" \t\r\n", begin - 1),
                      after = text_.find_first_not_of(" \t", end);
    if (text_[before] == ',')
      begin = before;
    else if (after != std::string_view::npos && text_[after] == ',')
      end = text_.find_first_not_of(" \t", after + 1);
  } else {
    begin -= indentation(begin).size();
    end = std::min(text_.find('\n', end), text_.size() - 1) + 1;
  }
  edits_.push_back({begin, end, ""});
}

void TableText::add_line(const std::string& line) {
  const Member* last = nullptr;
  for (const Member& member : table_.members)
    if (!has_header(member) &&
        (last == nullptr || offset_of(text_, last->position) < offset_of(text_, member.position)))
      last = &member;
  if (last == nullptr) {
    const std::size_t at = std::min(text_.find('\n', offset_of(text_, table_.position)), text_.size());
    edits_.push_back({at, at, "\n" + line});
    return;
  }
  const std::size_t begin = offset_of(text_, last->position), end = end_of(*last);
  const std::size_t at = is_inline() ? end : std::min(text_.find('\n', end), text_.size());
  edits_.push_back({at, at, (is_inline() ? ", " : "\n" + std::string(indentation(begin))) + line});
}

const Member& TableText::member_of(std::string_view key) const {
  return *std::find_if(table_.members.begin(), table_.members.end(), [&](const Member& m) { return m.key == key; });
}

std::size_t TableText::end_of(const Member& member) const {
  return end_of_value(text_, offset_of(text_, member.value.position));
}

bool TableText::has_header(const Member& member) const {
  const std::size_t at = offset_of(text_, member.position);
  const std::size_t line = at == 0 ? std::string_view::npos : text_.rfind('\n', at - 1);
  const std::size_t begin = text_.find_first_not_of(" \t", line == std::string_view::npos ? 0 : line + 1);
  return !is_inline() && begin < at && text_[begin] == '[';
}

bool TableText::is_inline() const {
  const std::size_t at = offset_of(text_, table_.position);
  return at < text_.size() && text_[at] == '{';
}

std::string_view TableText::indentation(std::size_t at) const {
  std::size_t begin = at;
  while (begin > 0 && (text_[begin - 1] == ' ' || text_[begin - 1] == '\t')) --begin;
  return begin == 0 || text_[begin - 1] == '\n' ? text_.substr(begin, at - begin) : std::string_view();
}

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
  if (const std::size_t dot = name.rfind('.'); dot != std::string_view::npos && is_field_term(name.substr(dot + 1))) {
    auto number = find_target(targets, name.substr(0, dot));
    if (!number || !number->component || number->table != stage_name(Stage::presample) || !number->term.empty())
      return std::nullopt;
    number->term = name.substr(dot + 1);
    return number;
  }
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
    Node& old = child(table, target.key).items[*target.element];
    if (!target.term.empty()) return put_term(old, target.term, std::move(value));
    old = std::move(value);
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
    const std::string x = target.key + "_x", y = target.key + "_y";
    if (!target.term.empty() && (table.find(x) != nullptr || table.find(y) != nullptr))
      return "the sensor file gives " + x + " and " + y + "; name one of them";
    remove(table, x);
    remove(table, y);
  }
  Node& old = child(table, target.key);
  if (!target.term.empty()) return put_term(old, target.term, std::move(value));
  if (is_over_field(old, {}) && value.kind != Node::Kind::table)
    return "it changes over the field of view; name one of its terms, such as " + target.key +
           ".r2, or 1 for the optical axis";
  old = std::move(value);
  return "";
}

}  // namespace mtf::io::cfg

namespace mtf::io {

std::string replace_value(const SensorConfig& config, std::string_view parameter, std::string_view value) {
  const std::string where = config.file + ": " + printable(std::string(parameter), 80) + ": ";
  const cfg::Located at = cfg::located(config, parameter);
  const cfg::Node wanted = cfg::wanted_node(value);
  cfg::Node expected = at.tree.root;
  if (const std::string problem = cfg::put_value(expected, at.target, wanted); !problem.empty())
    throw UsageError(where + problem);
  std::string text = cfg::new_text(config.text, at.tree.root, at.target, cfg::toml_value(wanted, value));
  cfg::require_tree(text, expected, where + "cannot be set to " + printable(value, 80), at.target);
  return text;
}

std::string without_value(const SensorConfig& config, std::string_view parameter) {
  const std::string where = config.file + ": " + printable(std::string(parameter), 80) + ": ";
  const cfg::Located at = cfg::located(config, parameter);
  const cfg::Target& target = at.target;
  const cfg::Node* table = at.table();
  if (table == nullptr || target.element || table->find(target.key) == nullptr)
    throw UsageError(where + "the file does not state it");
  // Of a number with one term more than that, the term.
  const cfg::Node* number = cfg::number_at(table, target);
  const bool term = !target.term.empty() && number->members.size() > 1;
  if (!target.term.empty() && number->find(target.term) == nullptr)
    throw UsageError(where + "the file does not state it");
  cfg::TableText out(config.text, term ? *number : *table);
  out.remove_line(term ? target.term : target.key);
  std::string text = out.text();
  cfg::Node expected = at.tree.root;
  for (cfg::Member& member : expected.members)
    if (member.key == target.table) {
      cfg::Node& from = target.component ? member.value.items.at(target.index) : member.value;
      cfg::remove(term ? *cfg::number_at(&from, target) : from, term ? target.term : target.key);
    }
  cfg::require_tree(text, expected, where + "cannot be taken out", target);
  return text;
}

std::string stated_value(const SensorConfig& config, std::string_view parameter) {
  const cfg::Located at = cfg::located(config, parameter);
  const cfg::Target& target = at.target;
  const cfg::Node* table = at.table();
  const cfg::Node* value = table != nullptr ? table->find(target.key) : nullptr;
  if (value == nullptr && table != nullptr)  // of both axes
    if (const auto pair = cfg::pair_of_axis(target.key)) value = table->find(*pair);
  if (value != nullptr && target.element) {
    if (*target.element >= value->items.size())
      throw UsageError(config.file + ": " + printable(std::string(parameter), 80) + ": " +
                       (value->kind != cfg::Node::Kind::array
                            ? "is one value, not a list; leave the index out"
                            : "the list has " + plural(static_cast<std::int64_t>(value->items.size()), "value") +
                                  ", counted from 0"));
    value = &value->items[*target.element];
  }
  if (value != nullptr && !target.term.empty())
    value = value->kind == cfg::Node::Kind::table ? value->find(target.term) : nullptr;
  if (value == nullptr) return {};
  const std::size_t begin = cfg::offset_of(config.text, cfg::number_of(value)->position);
  return config.text.substr(begin, cfg::end_of_value(config.text, begin) - begin);
}

SensorConfig replaced(const SensorConfig& config, std::string_view parameter, std::string_view value) {
  ConfigResult result = parse_config(replace_value(config, parameter, value), config.file, config.schema);
  cfg::require_no_errors(result.diagnostics, config.file);
  return std::move(result.config);
}

}  // namespace mtf::io
