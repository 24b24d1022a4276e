// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rows of a table of facets in an NPY file, '<f4' or '<f8', one at a time: tables of a run hold hundreds of rows of
// hundreds of thousands of facets, of which a picture needs two.

#include <cstdint>
#include <string>
#include <vector>

#include "mtf/io/npy.h"

namespace apps::scene {

class NpyRows {
 public:
  /// Throws RuntimeError for a file that cannot be read, UsageError with its name for one that is no table of floats in
  /// C order of one or two dimensions, or is cut off.
  explicit NpyRows(const std::string& path);

  std::uint64_t rows() const { return rows_; }
  std::uint64_t columns() const { return columns_; }
  std::vector<float> row(std::uint64_t row);

 private:
  mtf::io::NpyReader file_;
  std::uint64_t rows_ = 1, columns_ = 0;
};

}  // namespace apps::scene
