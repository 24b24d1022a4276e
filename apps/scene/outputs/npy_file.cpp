// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/outputs/npy_file.h"

#include <bit>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "mtf/error.h"

namespace apps::scene {
namespace {

static_assert(std::endian::native == std::endian::little, "'<f4' is the byte order of the machine");

constexpr std::size_t kHeaderSize = 128;  // in all, as numpy aligns it

// As long for every number of rows, so that it can be written first and corrected at the end.
std::string header(std::uint64_t rows, std::uint64_t columns) {
  constexpr std::size_t fixed = 10;  // magic number, version and length
  std::string text = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(rows) + ", " +
                     std::to_string(columns) + "), }";
  text.resize(kHeaderSize - fixed - 1, ' ');
  return std::string("\x93NUMPY\x01\0", 8) + static_cast<char>(kHeaderSize - fixed) + '\0' + text + '\n';
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

void NpyFile::write_header() {
  const std::string text = header(rows_, columns_);
  file_.seek(0);
  file_.write(text.data(), text.size());
}

void NpyFile::commit() {
  write_header();
  file_.commit();
}

bool NpyFile::keep_as(const std::filesystem::path& file) {
  const std::uint64_t end = file_.position();
  write_header();
  file_.seek(end);
  return file_.keep_as(file.string());
}

void copy_rows(const std::filesystem::path& from, std::uint64_t rows, NpyFile& to) {
  std::error_code error;
  const std::uint64_t row_bytes = to.columns() * sizeof(float), size = std::filesystem::file_size(from, error);
  std::ifstream file(from, std::ios::binary);
  std::string head(kHeaderSize, '\0');
  file.read(head.data(), kHeaderSize);
  const std::uint64_t held = error || size < kHeaderSize ? 0 : (size - kHeaderSize) / row_bytes;
  const std::size_t number = header(0, 0).find('(') + 1;
  const std::uint64_t named = file ? std::strtoull(head.c_str() + number, nullptr, 10) : 0;
  if (!file || named < rows || held < named || head != header(named, to.columns()))
    throw mtf::RuntimeError(from.string() + " is not the table of " + std::to_string(rows) + " outputs and " +
                            std::to_string(to.columns()) + " facets that an interrupted run left");
  std::vector<float> row(to.columns());
  for (std::uint64_t i = 0; i < rows; ++i) {
    file.read(reinterpret_cast<char*>(row.data()), static_cast<std::streamsize>(row_bytes));
    if (!file) throw mtf::RuntimeError(from.string() + ": it cannot be read");
    to.append(row);
  }
}

}  // namespace apps::scene
