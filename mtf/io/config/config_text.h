// SPDX-License-Identifier: Apache-2.0
#pragma once

// Places in the text of a sensor file, and changes of it: what is edited is found by the positions of the tree.

#include <string>
#include <string_view>
#include <vector>

#include "mtf/io/config/config.h"

namespace mtf::io::cfg {

/// The bytes [begin, end) give way to `text`.
struct Edit {
  std::size_t begin = 0, end = 0;
  std::string text;
};

/// The text with all edits; of two that overlap the first counts.
std::string edited(std::string_view text, std::vector<Edit> edits);

/// Byte of a position; columns count characters, not bytes.
std::size_t offset_of(std::string_view text, Position position);

/// Where the value that starts at `begin` ends: a string, a list, an inline table, or a word.
std::size_t end_of_value(std::string_view text, std::size_t begin);

/// As TOML writes them: 8.0; "8 urad".
std::string toml_number(double value);
std::string toml_string(std::string_view text);

}  // namespace mtf::io::cfg
