// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/npy_rows.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/file_checks.h"

namespace apps::scene {
namespace {

constexpr std::uint64_t kMost = 1ULL << 40;  // numbers of a table

/// What stands behind `'key': ` in the header of an NPY file.
std::string_view entry(std::string_view header, const std::string& key) {
  const std::size_t at = header.find("'" + key + "'");
  if (at == std::string_view::npos) return {};
  const std::size_t colon = header.find(':', at);
  return colon == std::string_view::npos ? std::string_view() : header.substr(colon + 1);
}

/// The whole numbers of "(12, 345)", three of them at most.
std::vector<std::uint64_t> sizes_of(std::string_view text) {
  text = text.substr(std::min(text.find('('), text.size()));
  text = text.substr(0, text.find(')'));
  std::vector<std::uint64_t> sizes;
  while (sizes.size() < 3) {
    text.remove_prefix(std::min(text.find_first_of("0123456789"), text.size()));
    if (text.empty()) break;
    std::uint64_t value = 0;
    const auto end = std::from_chars(text.data(), text.data() + text.size(), value).ptr;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    sizes.push_back(value);
  }
  return sizes;
}

template <class Number>
std::vector<float> read_numbers(std::ifstream& file, std::uint64_t count) {
  std::vector<Number> numbers(count);
  file.read(reinterpret_cast<char*>(numbers.data()), static_cast<std::streamsize>(count * sizeof(Number)));
  return {numbers.begin(), numbers.end()};
}

}  // namespace

NpyRows::NpyRows(const std::string& path) : path_(path) {
  const auto bytes = static_cast<std::uint64_t>(mtf::io::ordinary_file_size(path));
  file_.open(path, std::ios::binary);
  if (!file_) throw mtf::RuntimeError("cannot read " + one_line(path) + ": check its permissions");
  const auto refuse = [&](const std::string& what) { throw mtf::UsageError(one_line(path) + ": " + what); };
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
  item_ = descr.find("'<f4'") < 4 ? sizeof(float) : descr.find("'<f8'") < 4 ? sizeof(double) : 0;
  if (item_ == 0 || entry(header, "fortran_order").find("False") > 4)
    refuse("float32 or float64 in C order belongs here, as numpy.save writes it");
  const std::vector<std::uint64_t> sizes = sizes_of(entry(header, "shape"));
  if (sizes.empty() || sizes.size() > 2) refuse("a table of facets, or of times x facets, belongs here");
  columns_ = sizes.back();
  if (sizes.size() == 2) rows_ = sizes.front();
  const bool possible = columns_ > 0 && rows_ > 0 && rows_ <= kMost / columns_;
  if (!possible || (bytes - begin_) / item_ < rows_ * columns_) refuse("the NPY file is cut off");
}

std::vector<float> NpyRows::row(std::uint64_t row) {
  file_.seekg(static_cast<std::streamoff>(begin_ + row * columns_ * item_));
  std::vector<float> values =
      item_ == sizeof(float) ? read_numbers<float>(file_, columns_) : read_numbers<double>(file_, columns_);
  if (!file_) throw mtf::RuntimeError(one_line(path_) + ": it cannot be read");
  return values;
}

}  // namespace apps::scene
