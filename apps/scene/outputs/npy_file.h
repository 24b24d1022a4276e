// SPDX-License-Identifier: Apache-2.0
#pragma once

// A table of float32 that numpy.load reads: NPY 1.0, '<f4', C order, shape (rows, columns).

#include <cstdint>
#include <filesystem>
#include <span>

#include "mtf/io/atomic_file.h"

namespace apps::scene {

/// The table row by row, as temperatures come: one row an output time, one column a facet. The file appears with
/// `commit`, with as many rows as were appended.
class NpyFile {
 public:
  NpyFile(const std::filesystem::path& file, std::uint64_t columns);

  /// Throws UsageError for a row of another length, RuntimeError when it cannot be written.
  void append(std::span<const float> row);
  void commit();
  /// The rows so far stand under another name too, as AtomicFile::keep_as has it; it may be followed by others there.
  bool keep_as(const std::filesystem::path& file);
  std::uint64_t columns() const { return columns_; }

 private:
  void write_header();

  mtf::io::AtomicFile file_;
  std::uint64_t columns_, rows_ = 0;
};

/// Appends the first rows of a table that an NpyFile wrote. Throws RuntimeError where it has fewer, or other columns.
void copy_rows(const std::filesystem::path& from, std::uint64_t rows, NpyFile& to);

}  // namespace apps::scene
