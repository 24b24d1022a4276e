// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/config_tree.h"

// toml++ 3.3 asserts in parse_key what damaged files break ("[table]]"), and reports them as errors a few lines later;
// a build with assertions would end there.
#define TOML_ASSERT(condition) static_cast<void>(0)
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <sstream>

#include "mtf/io/config/config_edit.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/file_checks.h"
#include "mtf/words.h"

namespace mtf::io::cfg {
namespace {

Position position_of(const toml::source_region& source) {
  return {static_cast<int>(source.begin.line), static_cast<int>(source.begin.column)};
}

/// As RFC 3339 writes it: "2016-01-01T00:00:00Z"; a part of it where the file has no more.
std::string date_text(const toml::node& from) {
  std::ostringstream text;
  if (const auto* both = from.as_date_time())
    text << both->get();
  else if (const auto* date = from.as_date())
    text << date->get();
  else if (const auto* time = from.as_time())
    text << time->get();
  return text.str();
}

Node node_of(const toml::node& from);

Node table_of(const toml::table& from) {
  Node node;
  for (const auto& [key, value] : from)
    node.members.push_back({std::string(key.str()), position_of(key.source()), node_of(value)});
  // toml++ iterates by name.
  std::stable_sort(node.members.begin(), node.members.end(), [](const Member& a, const Member& b) {
    return std::pair(a.position.line, a.position.column) < std::pair(b.position.line, b.position.column);
  });
  return node;
}

Node node_of(const toml::node& from) {
  Node node;
  if (const auto* table = from.as_table()) {
    node = table_of(*table);
  } else if (const auto* array = from.as_array()) {
    node.kind = Node::Kind::array;
    for (const toml::node& item : *array) node.items.push_back(node_of(item));
  } else if (const auto* text = from.as_string()) {
    node.kind = Node::Kind::string;
    node.text = text->get();
  } else if (const auto* integer = from.as_integer()) {
    node.kind = Node::Kind::integer;
    node.integer = integer->get();
    node.number = static_cast<double>(node.integer);
  } else if (const auto* real = from.as_floating_point()) {
    node.kind = Node::Kind::real;
    node.number = real->get();
  } else if (const auto* boolean = from.as_boolean()) {
    node.kind = Node::Kind::boolean;
    node.boolean = boolean->get();
  } else {
    node.kind = Node::Kind::date;
    node.text = date_text(from);
  }
  node.position = position_of(from.source());
  return node;
}

// toml++ frees and walks nested tables by recursion and has no limit for dotted keys, so depth is refused beforehand.
// Up to the first syntax error this scan and the parser agree on strings and comments; later text is not parsed.
class DepthScan {
 public:
  explicit DepthScan(std::string_view text) : text_(text) {}

  std::optional<Position> too_deep() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#') {
        skip_to("\n");
        continue;
      }
      if (c == '"' || c == '\'') {
        skip_string(c);
        continue;
      }
      if (c == '.' && ++dots_ > kMaxDots) return here();
      if (c == '[' || c == '{') {
        if (++brackets_ > kMaxBrackets) return here();
      } else if (c == ']' || c == '}') {
        brackets_ = std::max(0, brackets_ - 1);
      }
      if (std::string_view("=,[]{}\n").find(c) != std::string_view::npos) dots_ = 0;
      ++at_;
    }
    return std::nullopt;
  }

 private:
  Position here() const {
    const std::string_view before = text_.substr(0, at_);
    const std::size_t start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
    return {1 + static_cast<int>(std::count(before.begin(), before.end(), '\n')), static_cast<int>(at_ - start) + 1};
  }
  void skip_to(std::string_view end) { at_ = std::min(text_.find(end, at_), text_.size()); }
  void skip_string(char quote) {
    const std::string three(3, quote);
    const bool multi_line = text_.substr(at_, 3) == three;
    const std::string_view end = multi_line ? std::string_view(three) : std::string_view(three).substr(0, 1);
    at_ += end.size();
    while (at_ < text_.size() && text_.substr(at_, end.size()) != end) {
      if (!multi_line && text_[at_] == '\n') return;
      at_ += quote == '"' && text_[at_] == '\\' ? 2 : 1;
    }
    at_ = std::min(at_ + end.size(), text_.size());
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int brackets_ = 0;
  int dots_ = 0;
};

Tree failure(Position position, std::string text) {
  return {.root = {}, .error = Diagnostic{.error = true, .position = position, .path = {}, .text = std::move(text)}};
}

/// By its mark, or by the zero that every second byte of Latin letters is.
bool is_utf16(std::string_view text) {
  return text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") || text.substr(0, 2).find('\0') != text.npos;
}

/// For a line whose value is a word or a number with a unit and has no quotes: how to write it; else "".
std::string quotes_missing(std::string_view text, int line) {
  text.remove_prefix(offset_of(text, {line, 1}));
  text = text.substr(0, text.find_first_of("#\n"));
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) return {};
  text.remove_prefix(equals + 1);
  if (text.find_first_of("\"'=") != std::string_view::npos) return {};
  const std::string_view value = trimmed_cell(text);
  for (const std::string_view word : {"true", "false"})
    if (std::equal(value.begin(), value.end(), word.begin(), word.end(),
                   [](unsigned char a, unsigned char b) { return std::tolower(a) == b; }))
      return {};
  const std::string_view number = value.substr(value.starts_with('+') ? 1 : 0);
  double ignored = 0.0;
  const char* const end = std::from_chars(number.data(), number.data() + number.size(), ignored).ptr;
  const std::string_view word = trimmed_cell(number.substr(static_cast<std::size_t>(end - number.data())));
  const bool letter = !word.empty() && (static_cast<unsigned char>(word.front()) >= 0x80 ||  // of a µ or °
                                        std::isalpha(static_cast<unsigned char>(word.front())) != 0);
  return letter ? "; words and numbers with units stand in quotes: \"" + printable(value, 40) + "\"" : "";
}

}  // namespace

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

Tree read_tree(const std::string& text) {
  if (text.size() > kMaxBytes)
    return failure({}, "the file has " + shown_bytes(static_cast<double>(text.size())) +
                           "; a sensor file has at most 1 MiB: put curves into CSV files");
  if (is_utf16(text))
    return failure({1, 1},
                   "the text is UTF-16; save it as UTF-8, which is the encoding \"UTF-8\" of an editor's Save As, or "
                   "what iconv -f UTF-16 -t UTF-8 OLD > NEW makes");
  if (const auto position = DepthScan(text).too_deep())
    return failure(*position, "nested too deep; at most " + std::to_string(kMaxBrackets) + " brackets and " +
                                  std::to_string(kMaxDots) + " dots in a key");
  try {
    const toml::table table = toml::parse(std::string_view(text));
    return {.root = node_of(table), .error = std::nullopt};
  } catch (const toml::parse_error& error) {
    const Position position = position_of(error.source());
    return failure(position, "not valid TOML: " + printable(error.description()) + quotes_missing(text, position.line));
  }
}

}  // namespace mtf::io::cfg
