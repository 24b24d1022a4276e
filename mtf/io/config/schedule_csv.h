// SPDX-License-Identifier: Apache-2.0
#pragma once

// The lines of a schedule as text, before their values are read.

#include <string>
#include <string_view>
#include <vector>

#include "mtf/io/config/schedule.h"

namespace mtf::io {

/// Errors of a schedule that one message lists.
inline constexpr std::size_t kMostScheduleErrors = 20;

/// Settings in the order of the file. What is wrong with its form goes to `errors` as "file:line: error: ..." lines.
std::vector<Setting> read_settings(std::string_view text, const std::string& file, std::vector<std::string>& errors);

/// "file:line: error: text"
std::string schedule_error(const std::string& file, int line, const std::string& text);

}  // namespace mtf::io
