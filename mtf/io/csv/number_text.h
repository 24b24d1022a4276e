// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers as text for attributes: the shortest text that reads back as the same number, whatever the locale.

#include <array>
#include <charconv>
#include <string>
#include <string_view>

namespace mtf::io {

template <class T>
std::string number_text(T value) {
  std::array<char, 64> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

/// Appends `word`, with `separator` before it unless the text is empty.
inline void append_word(std::string& text, std::string_view word, char separator = ' ') {
  if (!text.empty()) text += separator;
  text += word;
}

}  // namespace mtf::io
