// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/config_text.h"

#include <algorithm>

#include "mtf/units.h"

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

}  // namespace mtf::io::cfg
