// SPDX-License-Identifier: Apache-2.0
#pragma once

// Columns of numbers out of a text table whose first line names them. Which columns are read is for the caller to say;
// others may hold text.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace mtf::io {

struct CsvNumbers {
  std::vector<std::vector<double>> column;  ///< as chosen; all of one length, finite
  std::vector<std::size_t> line;            ///< of each row, from 1
};

/// Indices of the columns to read, given the cells of the header; `where` is "file:line: ". Throws UsageError.
using ChooseColumns =
    std::function<std::vector<std::size_t>(const std::vector<std::string_view>& cells, const std::string& where)>;

/// Text with one header line, separated by commas, semicolons or tabs; # starts a comment line. At most a million rows
/// and 64 columns. Throws UsageError "source:line: ..." with `remedy` where the header is at fault.
CsvNumbers read_csv_numbers(std::string_view text, const std::string& source, const std::string& remedy,
                            const ChooseColumns& choose);

/// An ordinary file of at most `limit` bytes. Throws RuntimeError.
std::string read_table_text(const std::string& path, std::size_t limit = std::size_t{64} << 20);

}  // namespace mtf::io
