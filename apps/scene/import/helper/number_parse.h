// SPDX-License-Identifier: Apache-2.0
#pragma once

// Words and numbers of a text, whatever the locale.

#include <algorithm>
#include <charconv>
#include <string_view>

namespace apps::scene {

constexpr std::string_view blanks = " \t\r\n\v\f";

inline std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(blanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(blanks) + 1 - begin);
}

/// Takes the next word off `text`; empty at the end.
inline std::string_view next_word(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(blanks));
  text.remove_prefix(word.size());
  return word;
}

/// False when the word is not a number of this type, or is more than that number. Of real ones `nan` and `inf` are.
template <class T>
bool parse_number(std::string_view word, T& value) {
  if (word.starts_with('+')) word.remove_prefix(1);  // which from_chars does not know
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

}  // namespace apps::scene
