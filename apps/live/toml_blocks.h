// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whole tables of a sensor file as pieces of its text: taken out, added at the end, switched off and on again. A table
// that is off stays in the file as a comment whose lines begin with "#- ", so that a saved file keeps it.

#include <string>
#include <string_view>
#include <vector>

#include "mtf/io/config/config.h"

namespace apps::live {

/// The lines of one table: its header, its keys and the comments among them. Comments and blank lines above the next
/// header belong to that one.
struct TomlBlock {
  std::string header;              ///< "presample", "noise"
  bool list = false;               ///< [[presample]]
  bool off = false;                ///< a comment of "#- " lines
  std::size_t index = 0;           ///< among blocks of the same header that are as much on or off
  std::size_t begin = 0, end = 0;  ///< bytes of the text
};

/// In the order of the file. Headers within multi-line strings are none.
std::vector<TomlBlock> toml_blocks(std::string_view text);

/// Texts of the same file without the block, with it as a comment, and with the comment as a table again.
std::string without_block(std::string_view text, const TomlBlock& block);
std::string switched_off(std::string_view text, const TomlBlock& block);
std::string switched_on(std::string_view text, const TomlBlock& block);
/// The lines of a block that is off, as TOML.
std::string text_of_off(std::string_view text, const TomlBlock& block);
/// The text with a table at its end.
std::string with_block(std::string_view text, std::string_view block);

}  // namespace apps::live
