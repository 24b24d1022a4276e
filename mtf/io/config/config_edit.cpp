// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/config_edit.h"

#include <algorithm>
#include <charconv>

#include "mtf/io/config/config_reader.h"
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
