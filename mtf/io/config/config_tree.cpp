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
  switch (kind) {
    case Node::Kind::string:
      return "a string";
    case Node::Kind::integer:
      return "a whole number";
    case Node::Kind::real:
      return "a number";
    case Node::Kind::boolean:
      return "true or false";
    case Node::Kind::date:
      return "a date or time";
    case Node::Kind::array:
      return "a list";
    case Node::Kind::table:
      return "a table";
  }
  return "";
}

std::string shown(const Node& node) {
  constexpr std::size_t limit = 60;
  switch (node.kind) {
    case Node::Kind::string:
      return "\"" + printable(node.text, limit) + "\"";
    case Node::Kind::integer:
      return std::to_string(node.integer);
    case Node::Kind::real: {
      const std::string text = format_double(node.number);
      return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
    }
    case Node::Kind::boolean:
      return node.boolean ? "true" : "false";
    case Node::Kind::date:
      return "a date or time";
    default:
      break;
  }
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
