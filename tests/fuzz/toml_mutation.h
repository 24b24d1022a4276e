// SPDX-License-Identifier: Apache-2.0
#pragma once

// Changes to a TOML text that leave most of it a TOML text: of plain changes of bytes only one in five gets past the
// parser, and what lies behind it is what wants testing.

#include <cstdint>
#include <string>
#include <string_view>

namespace fuzz {

/// One change, drawn by `seed`: a line is removed, doubled or moved, a value or the number in it replaced by one that
/// is likely to be mishandled (0, negative, huge, nan, another unit, another type, a list, a table).
std::string mutated_toml(std::string_view text, std::uint32_t seed);

/// The first text with some lines of the second, keys behind a table of the same name where there is one.
std::string crossed_toml(std::string_view text, std::string_view other, std::uint32_t seed);

}  // namespace fuzz
