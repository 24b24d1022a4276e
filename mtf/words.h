// SPDX-License-Identifier: Apache-2.0
#pragma once

// Names and numbers as they stand in messages and tables.

#include <concepts>
#include <cstdint>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace mtf {

/// The text on one line with control characters and broken UTF-8 replaced, cut to `limit` bytes: names from damaged
/// files go into messages.
std::string printable(std::string_view text, std::size_t limit = 200);

/// The same, not cut: names of files, which are searched for as they stand.
std::string one_line(std::string_view text);

/// The text without blanks and tabs at its ends.
std::string_view trimmed(std::string_view text);

/// ASCII letters in lower case, all else as it is.
std::string lower_case(std::string_view text);

/// "a, b, c".
std::string joined(const std::vector<std::string>& parts, std::string_view between = ", ");
std::string joined(std::span<const std::string_view> parts, std::string_view between = ", ");
/// "a, b and c".
std::string listed(std::span<const std::string> parts);

/// The same of what `of` says of each element.
template <class List, class Of>
requires std::invocable<Of, decltype(*std::begin(std::declval<const List&>()))> std::string joined(
    const List& list, const Of& of, std::string_view between = ", ") {
  std::string text;
  for (const auto& element : list) text += (text.empty() ? "" : std::string(between)) + of(element);
  return text;
}

/// "640x512".
std::string size_text(std::int64_t width, std::int64_t height);

/// "1 frame", "2 frames".
std::string plural(std::int64_t count, const std::string& word);

/// printf's %.*f and %.*g, the latter with trailing zeros ("125.0") when `zeros`.
std::string fixed(double value, int decimals);
std::string significant(double value, int digits, bool zeros = false);

}  // namespace mtf
