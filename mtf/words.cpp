// SPDX-License-Identifier: Apache-2.0
#include "mtf/words.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>

namespace mtf {
namespace {

// Length of the well-formed UTF-8 sequence at `at`, 0 when there is none.
std::size_t utf8_length(std::string_view text, std::size_t at) {
  const auto lead = static_cast<unsigned char>(text[at]);
  const std::size_t length = lead < 0x80   ? 1
                             : lead < 0xc2 ? 0
                             : lead < 0xe0 ? 2
                             : lead < 0xf0 ? 3
                             : lead < 0xf5 ? 4
                                           : 0;
  if (length == 0 || at + length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((static_cast<unsigned char>(text[at + i]) & 0xc0U) != 0x80) return 0;
  return length;
}

std::string formatted(const char* format, int digits, double value) {
  std::array<char, 400> text{};
  static_cast<void>(std::snprintf(text.data(), text.size(), format, digits, value));
  return text.data();
}

}  // namespace

std::string printable(std::string_view text, std::size_t limit) {
  std::string shown;
  std::size_t at = 0;
  while (at < text.size() && shown.size() < limit) {
    const std::size_t length = utf8_length(text, at);
    const auto code = static_cast<unsigned char>(text[at]);
    if (length == 0 || code < 0x20 || code == 0x7f)
      shown += code == '\n' || code == '\t' ? ' ' : '?';
    else
      shown += text.substr(at, length);
    at += std::max<std::size_t>(length, 1);
  }
  if (at < text.size()) shown += "...";
  return shown;
}

std::string one_line(std::string_view text) { return printable(text, std::numeric_limits<std::size_t>::max()); }

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t";
  const std::size_t begin = text.find_first_not_of(blanks);
  return begin == std::string_view::npos ? std::string_view{}
                                         : text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

std::string joined(const std::vector<std::string>& parts, std::string_view between) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : std::string(between)) + part;
  return text;
}

std::string joined(std::span<const std::string_view> parts, std::string_view between) {
  return joined(std::vector<std::string>(parts.begin(), parts.end()), between);
}

std::string listed(std::span<const std::string> parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i)
    text += (i == 0 ? "" : i + 1 == parts.size() ? " and " : ", ") + parts[i];
  return text;
}

std::string size_text(std::int64_t width, std::int64_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

std::string plural(std::int64_t count, const std::string& word) {
  return std::to_string(count) + " " + word + (count == 1 ? "" : "s");
}

std::string fixed(double value, int decimals) { return formatted("%.*f", decimals, value); }

std::string significant(double value, int digits, bool zeros) {
  return formatted(zeros ? "%#.*g" : "%.*g", digits, value);
}

}  // namespace mtf
