// SPDX-License-Identifier: Apache-2.0
#include "apps/characterize/emva_descriptor.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/sha256.h"

namespace apps {
namespace {

class EmvaReader {
 public:
  explicit EmvaReader(const std::string& file)
      : text_(mtf::io::read_text_file(file, mtf::io::cfg::kMaxBytes)),
        result_{.file = file, .sha256 = mtf::io::sha256_hex(text_), .unit = LightUnit::photons} {}

  StacksFile read() {
    for (std::string_view rest = mtf::io::without_mark(text_); !rest.empty();) {
      ++line_;
      const std::string_view line = mtf::io::take_text_line(rest);
      if (!mtf::io::is_comment(line)) add(mtf::io::trimmed_cell(line));
    }
    if (result_.stacks.empty())
      refuse("there is no stack; write b 40000 120, exposure in ns and photons, and its frames");
    require_frames();
    if (!result_.bits) refuse("the bits of a count are not said; write n 12 640 480: bits, columns and rows");
    return std::move(result_);
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw mtf::UsageError(result_.file + ":" + std::to_string(line_) + ": " + what);
  }

  void add(std::string_view line) {
    const bool is_letter = line.size() == 1 || line[1] == ' ' || line[1] == '\t';
    const std::string_view rest = mtf::io::trimmed_cell(line.substr(1));
    switch (is_letter ? line.front() : '\0') {
      case 'v':
      case 'l':
        return;
      case 'n':
        if (result_.bits) refuse("a second line n; the frames of a set have one format");
        return add_format(numbers(rest, 3, "n 12 640 480: bits, columns and rows"));
      case 'b':
        return add_stack(line, numbers(rest, 2, "b 40000 120: exposure in ns and photons"));
      case 'd':
        return add_stack(line, numbers(rest, 1, "d 40000: exposure in ns"));
      case 'i':
        return add_frame(std::string(rest));
      default:
        refuse("'" + mtf::printable(line, 40) + "': lines open with v, n, l, b, d, i or #, and a blank");
    }
  }

  /// Numbers from 0 between blanks; some programs write them with a decimal comma.
  std::vector<double> numbers(std::string_view text, std::size_t count, const std::string& example) const {
    std::vector<double> values;
    while (!text.empty()) {
      std::string word(text.substr(0, text.find_first_of(" \t")));
      text = mtf::io::trimmed_cell(text.substr(word.size()));
      std::replace(word.begin(), word.end(), ',', '.');
      values.push_back(mtf::io::cell_number(word).value_or(-1.0));
      if (!(values.back() >= 0.0 && values.back() < 1e15)) count = 0;
    }
    if (values.size() != count) refuse("write " + example);
    return values;
  }

  void add_format(const std::vector<double>& given) {
    const double bits = given[0], columns = given[1], rows = given[2];
    if (!(bits >= 1.0 && bits <= 31.0 && bits == std::floor(bits))) refuse("counts have 1 to 31 bits, a whole number");
    if (!(columns >= 1.0 && rows >= 1.0 && columns == std::floor(columns) && rows == std::floor(rows)))
      refuse("columns and rows are whole numbers from 1");
    result_.bits = static_cast<int>(bits);
    result_.size = {static_cast<std::int64_t>(columns), static_cast<std::int64_t>(rows)};
  }

  void add_stack(std::string_view line, const std::vector<double>& given) {
    require_frames();
    if (given.back() == 0.0 && given.size() > 1) refuse("no photons; a dark stack opens with d");
    const std::string name = std::filesystem::path(result_.file).filename().string() + ":" + std::to_string(line_);
    result_.stacks.push_back({.name = name + " (" + one_line(line) + ")",
                              .files = {},
                              .light = given.size() > 1 ? given[1] : 0.0,
                              .time_s = 1e-9 * given[0]});
  }

  /// Of the stack that ends above this line.
  void require_frames() const {
    if (!result_.stacks.empty() && result_.stacks.back().files.size() < 2)
      refuse(result_.stacks.back().name + " has " + plural(std::ssize(result_.stacks.back().files), "frame") +
             "; two or more lines i belong below it");
  }

  void add_frame(std::string name) {
    if (result_.stacks.empty()) refuse("a frame before the first stack, which opens with b or d");
    std::replace(name.begin(), name.end(), '\\', '/');
    const std::string file = mtf::io::cfg::beside(mtf::io::cfg::folder_of(result_.file), name);
    if (std::error_code none; name.empty() || !std::filesystem::is_regular_file(file, none))
      refuse("there is no file " + one_line(name) + "; names are relative to the folder of this file");
    result_.stacks.back().files.push_back(file);
  }

  std::string text_;
  StacksFile result_;
  std::size_t line_ = 0;
};

}  // namespace

bool is_emva_descriptor(const std::string& file) { return file.ends_with(".txt"); }

StacksFile load_emva_descriptor(const std::string& file) { return EmvaReader(file).read(); }

}  // namespace apps
