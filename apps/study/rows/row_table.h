// SPDX-License-Identifier: Apache-2.0
#pragma once

// Row files become one table, as CSV and as NPY, and are counted in the same pass, piece by piece, so that memory does
// not grow with the number of designs.

#include <functional>

#include "apps/study/rows/row_file.h"

namespace study {

struct TableColumn {
  std::string name;
  /// The words, which the CSV shows, where the values of the column are indices of words; empty for numbers.
  std::vector<std::string> levels{};
};

/// Counts the rows of one piece, in any thread and any order; the function that it returns adds the counts to the total
/// and is called in the order of the designs, one call at a time.
using RowCounter = std::function<std::function<void()>(RowRange, std::span<const double>)>;

struct TableJob {
  std::vector<RowPiece> pieces;  ///< in_order
  std::vector<TableColumn> columns;
  std::filesystem::path csv, npy;            ///< each "" for none
  RowCounter count_rows{};                   ///< may be empty
  int threads = 0;                           ///< 0 = all cores
  std::function<void(std::int64_t)> done{};  ///< designs written so far; may be empty
};

/// CSV: a header `design,<columns>`, a line a design, numbers in the shortest text that reads back as the same double,
/// NaN as an empty cell. NPY 1.0: '<f8', C order, shape (designs, columns). Both are written whole or not at all, the
/// same bytes for any pieces and threads. Throws RuntimeError (a damaged piece, disk full, ...).
void write_table(const TableJob& job);

/// A cell of text, in quotes where CSV needs them.
std::string csv_cell(std::string_view text);

}  // namespace study
