// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/npy.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <utility>

#include "mtf/error.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/raw/number_type.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr std::uint64_t kMost = 1ULL << 40;  // numbers of an array

/// What stands behind `'key': ` in the header.
std::string_view entry(std::string_view header, const std::string& key) {
  const std::size_t at = header.find("'" + key + "'");
  if (at == std::string_view::npos) return {};
  const std::size_t colon = header.find(':', at);
  return colon == std::string_view::npos ? std::string_view() : header.substr(colon + 1);
}

/// The whole numbers of "(12, 345)", five of them at most.
std::vector<std::uint64_t> sizes_of(std::string_view text) {
  text = text.substr(std::min(text.find('('), text.size()));
  text = text.substr(0, text.find(')'));
  std::vector<std::uint64_t> sizes;
  while (sizes.size() < 5) {
    text.remove_prefix(std::min(text.find_first_of("0123456789"), text.size()));
    if (text.empty()) break;
    std::uint64_t value = 0;
    const auto end = std::from_chars(text.data(), text.data() + text.size(), value).ptr;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    sizes.push_back(value);
  }
  return sizes;
}

}  // namespace

NpyReader::NpyReader(const std::string& path) : path_(path) {
  const auto bytes = static_cast<std::uint64_t>(ordinary_file_size(path));
  file_.open(path, std::ios::binary);
  if (!file_) throw RuntimeError("cannot read " + one_line(path) + ": check its permissions");
  const auto refuse = [&](const std::string& what) { throw UsageError(one_line(path) + ": " + what); };
  const auto read = [&](std::size_t count, const char* cut) {
    std::string part(count, '\0');
    if (!file_.read(part.data(), static_cast<std::streamsize>(count))) refuse(cut);
    return part;
  };
  constexpr const char *kNone = "is no NPY file", *kCut = "the header of the NPY file is cut off";
  const std::string head = read(8, kNone);
  if (!head.starts_with("\x93NUMPY")) refuse(kNone);
  const std::string size = read(head[6] == 1 ? 2 : 4, kNone);  // of the header, the least byte first
  std::size_t length = 0;
  for (std::size_t i = size.size(); i-- > 0;) length = 256 * length + static_cast<unsigned char>(size[i]);
  begin_ = head.size() + size.size() + length;
  if (begin_ > bytes) refuse(kCut);
  const std::string header = read(length, kCut);
  const std::string_view descr = entry(header, "descr");
  const std::size_t quote = descr.find('\'');
  type_ = quote < 3 ? std::string(descr.substr(quote + 1, 3)) : "";
  const bool known = number_type(type_) && descr.substr(quote + 4).starts_with('\'');
  if (!known || entry(header, "fortran_order").find("False") > 4)
    refuse("whole numbers or floats in C order belong here, as numpy.save writes them");
  item_ = static_cast<std::size_t>(type_[2] - '0');
  shape_ = sizes_of(entry(header, "shape"));
  std::uint64_t count = 1;
  for (const std::uint64_t extent : shape_) count = extent > 0 && count <= kMost / extent ? count * extent : kMost + 1;
  if (count > kMost || (bytes - begin_) / item_ < count) refuse("the NPY file is cut off");
}

NpyReader::NpyReader(const std::string& path, std::string type, std::uint64_t begin, std::uint64_t rows,
                     std::uint64_t columns)
    : path_(path), type_(std::move(type)), begin_(begin), item_(static_cast<std::size_t>(type_.at(2) - '0')) {
  const auto bytes = static_cast<std::uint64_t>(ordinary_file_size(path));
  file_.open(path, std::ios::binary);
  if (!file_) throw RuntimeError("cannot read " + one_line(path) + ": check its permissions");
  const std::uint64_t plane = rows * columns * item_, planes = bytes > begin ? (bytes - begin) / plane : 0;
  if (planes == 0 || begin + planes * plane != bytes) {
    const auto size_of = [&](std::uint64_t n) { return std::to_string(begin + n * plane); };
    throw UsageError(one_line(path) + ": " + std::to_string(bytes) + " bytes are no whole number of frames of " +
                     std::to_string(plane) + " bytes behind a header of " + std::to_string(begin) + "; " +
                     (planes > 0 ? size_of(planes) + " or " : "") + size_of(planes + 1) + " would be" +
                     (bytes >= plane ? ", and with header = " + std::to_string(bytes % plane) + " this file is" : ""));
  }
  shape_ = {planes, rows, columns};
}

void NpyReader::read(std::uint64_t first, std::span<float> values, Rounding* rounding) {
  file_.seekg(static_cast<std::streamoff>(begin_ + first * item_));
  std::array<char, 65536> bytes;  // stay in cache
  while (!values.empty()) {
    const std::size_t count = std::min(values.size(), bytes.size() / item_);
    if (!file_.read(bytes.data(), static_cast<std::streamsize>(count * item_)))
      throw RuntimeError(one_line(path_) + ": it cannot be read");
    to_floats(*number_type(type_), bytes.data(), static_cast<std::int64_t>(item_), {}, values.first(count), rounding);
    values = values.subspan(count);
  }
}

}  // namespace mtf::io
