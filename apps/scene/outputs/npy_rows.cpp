// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/outputs/npy_rows.h"

#include <charconv>
#include <filesystem>
#include <string_view>

#include "mtf/error.h"

namespace apps::scene {
namespace {

constexpr std::size_t kFixed = 10;           // magic number, version and length of NPY 1.0
constexpr std::uint64_t kMost = 1ULL << 40;  // numbers of a table

/// The whole numbers of "(12, 345)".
std::vector<std::uint64_t> sizes_of(std::string_view text) {
  std::vector<std::uint64_t> sizes;
  while (sizes.size() < 4) {
    const std::size_t digit = text.find_first_of("0123456789");
    if (digit == std::string_view::npos) break;
    text.remove_prefix(digit);
    std::uint64_t value = 0;
    const auto end = std::from_chars(text.data(), text.data() + text.size(), value).ptr;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    sizes.push_back(value);
  }
  return sizes;
}

}  // namespace

NpyRows::NpyRows(const std::string& path) : path_(path), file_(path, std::ios::binary) {
  if (!file_) throw mtf::RuntimeError("cannot read " + path + ": is it there?");
  const auto refuse = [&](const std::string& what) { throw mtf::UsageError(path + ": " + what); };
  std::string head(kFixed, '\0');
  file_.read(head.data(), static_cast<std::streamsize>(head.size()));
  if (!file_ || !head.starts_with("\x93NUMPY\x01")) refuse("is no NPY file of version 1");
  const auto byte = [&](std::size_t i) { return static_cast<std::size_t>(static_cast<unsigned char>(head[i])); };
  std::string text(byte(8) + 256 * byte(9), '\0');
  begin_ = kFixed + text.size();
  file_.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file_) refuse("the header of the NPY file is cut off");
  const std::size_t shape = text.find("'shape'");
  if (text.find("'<f4'") == std::string::npos || text.find("False") == std::string::npos || shape == std::string::npos)
    refuse("float32 in C order belongs here, as numpy.save writes it");
  const std::vector<std::uint64_t> sizes = sizes_of(std::string_view(text).substr(shape));
  if (sizes.empty() || sizes.size() > 2) refuse("a table of facets, or of times x facets, belongs here");
  columns_ = sizes.back();
  if (sizes.size() == 2) rows_ = sizes.front();
  std::error_code error;
  const std::uint64_t bytes = std::filesystem::file_size(path, error);
  const bool possible = columns_ > 0 && rows_ > 0 && rows_ <= kMost / columns_;
  if (error || !possible || (bytes - begin_) / sizeof(float) < rows_ * columns_) refuse("the NPY file is cut off");
}

std::vector<float> NpyRows::row(std::uint64_t row) {
  std::vector<float> values(columns_);
  file_.seekg(static_cast<std::streamoff>(begin_ + row * columns_ * sizeof(float)));
  file_.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(float)));
  if (!file_) throw mtf::RuntimeError(path_ + ": it cannot be read");
  return values;
}

}  // namespace apps::scene
