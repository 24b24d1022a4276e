// SPDX-License-Identifier: Apache-2.0
#pragma once

// Row files are read piece by piece, so that memory does not grow with the number of designs: to be counted, and to
// become one table, as CSV and as NPY.

#include <functional>
#include <optional>

#include "apps/study/rows/row_file.h"

namespace study {

struct TableColumn {
  std::string name;
  /// The words, which the CSV shows, where the values of the column are indices of words; empty for numbers.
  std::vector<std::string> levels{};
};

/// Works on the rows of one piece, in any thread and any order; the function that it returns is called in the order of
/// the designs, one call at a time.
using PieceWork = std::function<std::function<void()>(RowRange, std::vector<double>)>;
/// Called with the designs finished so far; may be empty.
using RowsDone = std::function<void(std::int64_t)>;

/// Reads the pieces (in_order) in threads, 0 = all cores. Throws RuntimeError for a damaged piece, and what `work`
/// throws.
void read_pieces(const std::vector<RowPiece>& pieces, const PieceWork& work, int threads, const RowsDone& done = {});

struct TableJob {
  std::vector<RowPiece> pieces;  ///< in_order
  std::vector<TableColumn> columns;
  /// Designs, in rising order, that have 1 in a last column of the table, which rows do not have; the others have 0
  /// there. Null where `columns` are those of the rows.
  std::optional<std::vector<std::int64_t>> marked{};
  std::filesystem::path csv, npy;
  int threads = 0;  ///< 0 = all cores
  RowsDone done{};
};

/// CSV: a header `design,<columns>`, a line a design, numbers in the shortest text that reads back as the same double,
/// NaN as an empty cell. NPY 1.0: '<f8', C order, shape (designs, columns). Both are written whole or not at all, the
/// same bytes for any pieces and threads. Throws RuntimeError (a damaged piece, disk full, ...).
void write_table(const TableJob& job);

}  // namespace study
