// SPDX-License-Identifier: Apache-2.0
#pragma once

// Places in the text of a sensor file, and changes of it: what is edited is found by the positions of the tree.

#include <string>
#include <string_view>
#include <vector>

#include "mtf/io/config/config_tree.h"

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

/// The number of a table { value = ..., fit = ... }, else the value itself.
const Node* number_of(const Node* value);

/// Changes of one table of the text, which has to be that of the tree.
class TableText {
 public:
  TableText(std::string_view text, const Node& table) : text_(text), table_(table) {}

  const Node* find(std::string_view key) const { return table_.find(key); }
  void replace(const Node& old, const std::string& value);
  /// `key = value` gives way to `first` and `second`, one below the other.
  void replace_line(std::string_view key, std::string_view first, std::string_view second = {});
  void remove_line(std::string_view key);
  /// After the last key of the table, before tables within it that have headers of their own.
  void add_line(const std::string& line);
  std::string text() const { return edited(text_, edits_); }

 private:
  const Member& member_of(std::string_view key) const;
  std::size_t end_of(const Member& member) const;
  bool has_header(const Member& member) const;
  bool is_inline() const;
  /// The blanks before `at`, where the line starts with them.
  std::string_view indentation(std::size_t at) const;

  std::string_view text_;
  const Node& table_;
  std::vector<Edit> edits_{};
};

/// As TOML writes them: 8.0; "8 urad".
std::string toml_number(double value);
std::string toml_string(std::string_view text);

}  // namespace mtf::io::cfg
