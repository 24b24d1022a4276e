// SPDX-License-Identifier: Apache-2.0
#pragma once

// Changes of a sensor file. Of its text, where what is edited is found by the positions of the tree; and of values in
// the tree before it is read, which is what schedules and trade studies do, so that units, bounds and defaults are
// those of the file. Parameters are called as messages and `mtf config explain` call them, the label of a component
// before its field: "jitter.rms", "presample[1].rms", "wavefront.zernike[3]"; a term of a number that changes over the
// field of view behind it: "wavefront.w131.r", "wavefront.w131.1" on the optical axis.

#include <map>
#include <optional>
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

/// Position of a parameter in the tree of a sensor file.
struct Target {
  std::string table;      ///< "frame", "optics", or the list of a component
  std::size_t index = 0;  ///< in that list
  bool component = false;
  std::string key{};
  std::optional<std::size_t> element{};  ///< of a list
  std::string term{};                    ///< of a number that changes over the field; "" for the whole number

  /// As diagnostics call it: "presample[1].rms".
  std::string path() const {
    return table + (component ? "[" + std::to_string(index) + "]" : "") + "." + key +
           (element ? "[" + std::to_string(*element) + "]" : "") + (term.empty() ? "" : "." + term);
  }
};

/// By name; components also as "presample[1]".
using Targets = std::map<std::string, Target, std::less<>>;

/// Every parameter of the frame, the optics, the components and the other tables in the file, not elements of lists.
Targets targets_of(const SensorConfig& sensor);

/// The target of "owner.field", "owner.field[3]" or, of components before the sampling, "owner.field.r2"; null when
/// there is none.
std::optional<Target> find_target(const Targets& targets, std::string_view name);

/// "the sensor has no parameter 'jiter.rms'; did you mean ...".
std::string unknown_parameter(const Targets& targets, const std::string& name);

/// A text as the sensor file would hold it: a number, a list, true or false, or else a string.
Node node_of(const std::string& cell, int line);

/// "rms" for "rms_x" and "rms_y", none for other keys. A pair of axes is written as one value or as two, never as both.
std::optional<std::string> pair_of_axis(std::string_view key);

/// Puts the value into the tree, and takes out what it replaces (pitch for pitch_x). A number that gets a term changes
/// over the field from then on. What is wrong, "" when nothing is.
std::string put(Node& root, const Target& target, Node value);

}  // namespace mtf::io::cfg
