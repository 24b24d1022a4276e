// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rows of results on disk. A piece holds the rows of the designs [first, first + count): a few lines of text that say
// which study and designs the rows belong to, a checksum of each row, then the doubles (little endian, row by row). A
// row file is one piece or several, one after the other; it appears whole or not at all. Every piece carries a hash of
// its lines, checksums and numbers, so that a piece that a bad disk or an incomplete copy changed is recognised; the
// checksums say which rows of it are wrong.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "mtf/error.h"

namespace study {

/// Designs from `first` on.
struct RowRange {
  std::int64_t first = 0, count = 0;

  std::int64_t end() const { return first + count; }
  bool operator==(const RowRange&) const = default;
};

/// The key of rows: what they belong to. Rows of another key are another study's, tolerance's, version's or layout's.
struct RowLayout {
  std::string key;           ///< 64 hex digits
  std::int64_t columns = 0;  ///< at least 1

  bool operator==(const RowLayout&) const = default;
};

/// One piece of a row file as its lines describe it; the numbers are not read yet.
struct RowPiece {
  std::filesystem::path file;
  std::uint64_t offset = 0;  ///< place of its first line
  std::uint64_t head = 0;    ///< bytes of the lines
  RowLayout layout;
  RowRange range;
  std::string sha256;

  std::uint64_t bytes() const;  ///< size of the checksums and the numbers
};

/// The pieces of a file in their order. Throws RuntimeError naming the file when it cannot be read, is no row file, or
/// is shorter or longer than its lines say.
std::vector<RowPiece> list_rows(const std::filesystem::path& file);

/// The numbers of a piece, checked against its hash. Throws RuntimeError naming the file, the designs of the piece and
/// those whose rows are damaged.
void read_rows(const RowPiece& piece, std::vector<double>& rows);

/// Joins row files into one. Throws RuntimeError.
void join_rows(const std::vector<RowPiece>& pieces, const std::filesystem::path& file);

/// An error that names a damaged file: its rows can be computed again, whatever it holds.
class DamagedRows : public mtf::RuntimeError {
 public:
  using RuntimeError::RuntimeError;
};

/// A path in messages: printable characters only.
std::string shown(const std::filesystem::path& path);

/// "designs 4096 to 8191", for messages.
std::string describe(RowRange range);

/// The pieces in the order of their designs. Throws RuntimeError naming the file for a piece of another layout, and the
/// designs where the pieces do not cover `range` without a gap or twice; a piece that does not fit is damaged where its
/// hash is not that of its lines and numbers, else foreign.
std::vector<RowPiece> in_order(std::vector<RowPiece> pieces, const RowLayout& layout, RowRange range);

// Makes rows in threads and keeps them piece by piece, so that a run that was stopped loses no finished piece.

/// Fills the row of a design. Its answer may not depend on the designs that came before.
using RowMaker = std::function<void(std::int64_t design, std::span<double> row)>;

struct RowRun {
  RowLayout layout;
  RowRange range;
  std::filesystem::path folder;    ///< holds the pieces; made here where it is missing
  std::int64_t piece = 0;          ///< designs in one; 0 = 4 to 4096, by their number
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

/// Makes the rows that the folder does not hold. A piece that is damaged, foreign or of another size is made again.
/// Throws what `make`, a row maker or the disk throws; finished pieces stay.
RowTally run_rows(const RowRun& run);

/// The pieces of the folder that make up the range of the run. Throws RuntimeError as in_order does.
std::vector<RowPiece> rows_of(const RowRun& run);

}  // namespace study
