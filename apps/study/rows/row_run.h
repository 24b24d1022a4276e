// SPDX-License-Identifier: Apache-2.0
#pragma once

// Makes rows in threads and keeps them piece by piece, so that a run that was stopped loses no finished piece.

#include <functional>

#include "apps/study/rows/row_file.h"

namespace study {

/// Fills the row of a design. Its answer may not depend on the designs that came before.
using RowMaker = std::function<void(std::int64_t design, std::span<double> row)>;

struct RowRun {
  RowLayout layout;
  RowRange range;
  std::filesystem::path folder;    ///< holds the pieces; made here where it is missing
  std::int64_t piece = 0;          ///< designs in one; 0 = piece_size(range.count)
  int threads = 0;                 ///< 0 = all cores
  std::function<RowMaker()> make;  ///< called once a thread
  std::function<void(std::int64_t)>
      done{};  ///< called with the designs finished so far, one call at a time; may be empty
};

/// The result of a run, in numbers of designs.
struct RowTally {
  std::int64_t made = 0;     ///< designs made in this run
  std::int64_t resumed = 0;  ///< left by a run before
  std::int64_t damaged = 0;  ///< designs of pieces that were damaged and were made again (part of `made`)
};

/// Designs in a piece: small enough to lose little and to share among threads, large enough for few files.
std::int64_t piece_size(std::int64_t designs);

/// Makes the rows that the folder does not hold. A piece that is damaged, foreign or of another size is made again.
/// Throws what `make`, a row maker or the disk throws; finished pieces stay.
RowTally run_rows(const RowRun& run);

/// The pieces of the folder that make up the range of the run. Throws RuntimeError as in_order does.
std::vector<RowPiece> rows_of(const RowRun& run);

}  // namespace study
