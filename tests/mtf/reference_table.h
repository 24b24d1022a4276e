// SPDX-License-Identifier: Apache-2.0
#pragma once

// The CSV tables of notebooks-data/reference.

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace mtf::test {

using Row = std::map<std::string, std::string>;

/// All rows by column name. Throws std::runtime_error when the file is missing or has no rows.
inline std::vector<Row> reference_table(const std::string& file) {
  std::ifstream in(std::string(MTFKIT_SOURCE_DIR) + "/notebooks-data/reference/" + file);
  const auto cells = [](const std::string& line) {
    std::vector<std::string> all;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) all.push_back(cell);
    return all;
  };
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> header = cells(line);
  std::vector<Row> rows;
  while (std::getline(in, line)) {
    const std::vector<std::string> values = cells(line);
    Row row;
    for (std::size_t i = 0; i < header.size(); ++i) row[header[i]] = values.at(i);
    rows.push_back(row);
  }
  if (rows.empty()) throw std::runtime_error("no rows in " + file);
  return rows;
}

/// Reads decimals and hexadecimal floats alike.
inline double number(const Row& row, const std::string& column) { return std::strtod(row.at(column).c_str(), nullptr); }
/// The reference with the digits beyond double that the comparison can use.
inline long double precise(const Row& row, const std::string& column) {
  return std::strtold(row.at(column).c_str(), nullptr);
}

}  // namespace mtf::test
