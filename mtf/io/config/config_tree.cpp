// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/config_tree.h"

#include <algorithm>

#include "mtf/words.h"

namespace mtf::io::cfg {

const Node* Node::find(std::string_view key) const {
  const auto found = std::find_if(members.begin(), members.end(), [&](const Member& m) { return m.key == key; });
  return found == members.end() ? nullptr : &found->value;
}

std::string_view kind_word(Node::Kind kind) {
  constexpr std::array kWords{"a string",       "a whole number", "a number", "true or false",
                              "a date or time", "a list",         "a table"};
  return kWords[static_cast<std::size_t>(kind)];
}

std::string shown(const Node& node) {
  constexpr std::size_t limit = 60;
  if (node.kind == Node::Kind::string) return "\"" + printable(node.text, limit) + "\"";
  if (node.kind == Node::Kind::integer) return std::to_string(node.integer);
  if (node.kind == Node::Kind::real) {
    const std::string text = format_double(node.number);
    return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
  }
  if (node.kind == Node::Kind::boolean) return node.boolean ? "true" : "false";
  if (node.kind == Node::Kind::date) return "a date or time";
  const bool table = node.kind == Node::Kind::table;
  std::string text(table ? "{" : "[");
  const auto add = [&](const std::string& item) {
    if (text.size() > limit) return false;
    text += (text.size() > 1 ? ", " : table ? " " : "") + item;
    return true;
  };
  bool whole = true;
  for (const Node& item : node.items) {
    if (!(whole = add(shown(item)))) break;
  }
  for (const Member& member : node.members) {
    if (!whole || !(whole = add(printable(member.key, limit) + " = " + shown(member.value)))) break;
  }
  return text + (whole ? "" : ", ...") + (table ? " }" : "]");
}

}  // namespace mtf::io::cfg
