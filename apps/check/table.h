// SPDX-License-Identifier: Apache-2.0
#pragma once

// The CSV tables of notebooks-data/reference: comma separated, one header row, numbers in decimal or hexadecimal. All
// of them are part of the program (CMakeLists.txt turns the folder into a source), so that an installed binary checks
// itself without its source tree.

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace apps::check {

/// One row, by column name. `where` is "file:line" for messages.
struct Row {
  std::string where;
  std::map<std::string, std::string, std::less<>> cells;

  /// Throws UsageError when there is no such column.
  const std::string& at(std::string_view column) const;
};

/// A cell as a double. Throws UsageError when it is not a number.
double number(const Row& row, std::string_view column);
/// The same with the digits beyond double that a comparison can use.
long double precise(const Row& row, std::string_view column);

/// Rows of CSV text. Throws UsageError for rows of another length than the header, and when there are none.
std::vector<Row> parse_table(const std::string& name, std::string_view text);

struct BuiltInTable {
  std::string_view name;
  std::string_view text;
};
/// Every table of notebooks-data/reference at the time of the build, by name.
std::span<const BuiltInTable> built_in_tables();

/// The tables that a run of checks reads: the built-in ones, or files of the same names in a folder in their place.
class Tables {
 public:
  Tables() = default;
  /// Throws UsageError when the folder has no CSV file, or one that no check reads (with the name probably meant).
  explicit Tables(const std::string& folder);
  std::vector<Row> rows(const std::string& name) const;

 private:
  std::map<std::string, std::string> own_;  ///< text by name
};

}  // namespace apps::check
