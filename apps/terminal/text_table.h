// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rows of text for people (aligned columns) and for programs (CSV).

#include <string>
#include <string_view>
#include <vector>

#include "apps/text/message_words.h"
#include "mtf/io/csv/csv_cells.h"

namespace apps {

enum class Align { left, right };

class TextTable {
 public:
  /// The header; the length of every row has to be the number of columns.
  explicit TextTable(std::vector<std::string> header) : rows_{std::move(header)} {}
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }

  /// Columns padded to their widest cell, two spaces apart, none trailing. `align` per column, left beyond its end.
  std::string aligned(const std::vector<Align>& align = {}) const;
  std::string csv() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

using mtf::io::csv_field;

/// A number of a CSV field with 17 digits, nothing where it is not finite.
std::string csv_number(double value);

}  // namespace apps
