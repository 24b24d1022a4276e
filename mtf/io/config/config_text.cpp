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

}  // namespace mtf::io::cfg
