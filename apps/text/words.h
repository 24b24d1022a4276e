// SPDX-License-Identifier: Apache-2.0
#pragma once

// Names and numbers as they stand in messages and tables.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace apps {

/// The text without control characters and broken UTF-8, so that no file name breaks a line.
std::string one_line(std::string_view text);

/// "a, b, c".
std::string joined(const std::vector<std::string>& parts, std::string_view between = ", ");

/// "1 frame", "2 frames".
std::string plural(std::int64_t count, const std::string& word);

/// printf's %.*f and %.*g, the latter with trailing zeros ("125.0") when `zeros`.
std::string fixed(double value, int decimals);
std::string significant(double value, int digits, bool zeros = false);

}  // namespace apps
