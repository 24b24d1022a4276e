// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/outputs/npy_file.h"

#include <bit>
#include <string>

#include "mtf/error.h"

namespace apps::scene {
namespace {

static_assert(std::endian::native == std::endian::little, "'<f4' is the byte order of the machine");

// As long for every number of rows, so that it can be written first and corrected at the end.
std::string header(std::uint64_t rows, std::uint64_t columns) {
  constexpr std::size_t size = 128, fixed = 10;  // in all, as numpy aligns it; magic number, version and length
  std::string text = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(rows) + ", " +
                     std::to_string(columns) + "), }";
  text.resize(size - fixed - 1, ' ');
  return std::string("\x93NUMPY\x01\0", 8) + static_cast<char>(size - fixed) + '\0' + text + '\n';
}

}  // namespace

NpyFile::NpyFile(const std::filesystem::path& file, std::uint64_t columns) : file_(file.string()), columns_(columns) {
  const std::string text = header(0, columns_);
  file_.write(text.data(), text.size());
}

void NpyFile::append(std::span<const float> row) {
  if (row.size() != columns_)
    throw mtf::UsageError("a row of " + std::to_string(row.size()) + " numbers for a table of " +
                          std::to_string(columns_) + " columns");
  file_.write(row.data(), row.size_bytes());
  ++rows_;
}

void NpyFile::commit() {
  const std::string text = header(rows_, columns_);
  file_.seek(0);
  file_.write(text.data(), text.size());
  file_.commit();
}

}  // namespace apps::scene
