// SPDX-License-Identifier: Apache-2.0
#pragma once

// Names and numbers as they stand in messages and tables.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace mtf {

/// The text on one line with control characters and broken UTF-8 replaced, cut to `limit` bytes: names from damaged
/// files go into messages.
std::string printable(std::string_view text, std::size_t limit = 200);

/// The same, not cut: names of files, which are searched for as they stand.
std::string one_line(std::string_view text);

/// The text without blanks and tabs at its ends.
std::string_view trimmed(std::string_view text);

/// "a, b, c".
std::string joined(const std::vector<std::string>& parts, std::string_view between = ", ");

/// "1 frame", "2 frames".
std::string plural(std::int64_t count, const std::string& word);

/// printf's %.*f and %.*g, the latter with trailing zeros ("125.0") when `zeros`.
std::string fixed(double value, int decimals);
std::string significant(double value, int digits, bool zeros = false);

}  // namespace mtf
