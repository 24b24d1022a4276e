// SPDX-License-Identifier: Apache-2.0
#include "calib/find/roi_file.h"

#include <array>
#include <span>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"

namespace calib {
namespace {

namespace io = mtf::io;

constexpr std::size_t kMostRegions = 100'000, kMostErrors = 20, kMostName = 200;
constexpr std::int64_t kMostPixels = std::int64_t{1} << 31;  // a side
constexpr const char* kForm = "write x,y,width,height in whole pixels, as in 120,80,64,96";

/// Text that may stand in a message: short, and nothing that a terminal would obey.
std::string shown(std::string_view text) {
  std::string line(text.substr(0, 60));
  for (char& c : line)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return '"' + line + '"';
}

/// The four numbers; what is wrong with them goes to `error`.
Roi region_of(std::span<const std::string_view> cells, std::string& error) {
  std::array<std::int64_t, 4> number{};
  for (std::size_t i = 0; i < number.size(); ++i) {
    const auto value = io::cell_number<std::int64_t>(cells[i]);
    if (!value) return error = shown(cells[i]) + " is no whole number; " + kForm, Roi{};
    number[i] = *value;
  }
  const auto [x, y, width, height] = number;
  if (x < 0 || y < 0) error = "x and y count from 0 at the upper left corner";
  if (width < 1 || height < 1) error = "width and height have to be 1 pixel or more";
  for (const std::int64_t n : number)
    if (n > kMostPixels) error = std::to_string(n) + " pixels are beyond any image";
  return {x, y, width, height};
}

}  // namespace

Roi parse_roi(std::string_view text) {
  const auto cells = io::split_cells(text, io::separator_of(text));
  std::string error = cells.size() == 4 ? "" : std::to_string(cells.size()) + " numbers where 4 belong; " + kForm;
  const Roi roi = error.empty() ? region_of(cells, error) : Roi{};
  if (!error.empty()) throw mtf::UsageError("region " + shown(text) + ": " + error);
  return roi;
}

std::vector<NamedRoi> parse_roi_file(std::string_view text, const std::string& source) {
  text = io::without_mark(text);
  std::vector<NamedRoi> regions;
  std::string errors;
  std::size_t wrong = 0;
  bool header_allowed = true;
  for (int line = 1; !text.empty() && wrong < kMostErrors; ++line) {
    const std::string_view row = io::take_text_line(text);
    if (io::is_comment(row)) continue;
    const auto cells = io::split_cells(row, io::separator_of(row));
    const bool header = header_allowed && cells.size() > 1 && !io::cell_number(cells[0]) && !io::cell_number(cells[1]);
    header_allowed = false;
    if (header) continue;
    NamedRoi region{.line = line};
    std::string error;
    if (cells.size() != 4 && cells.size() != 5)
      error = std::to_string(cells.size()) + " values where 4 or 5 belong: x,y,width,height and a name";
    else
      region.roi = region_of(std::span(cells).first(4), error);
    if (error.empty() && cells.size() == 5) region.name = cells[4];
    if (error.empty() && region.name.size() > kMostName) error = "a name of more than 200 characters";
    if (error.empty() && regions.size() == kMostRegions) throw mtf::UsageError(source + ": more than 100000 regions");
    if (error.empty()) {
      regions.push_back(std::move(region));
    } else {
      errors += (wrong++ > 0 ? "\n" : "") + source + ":" + std::to_string(line) + ": " + error;
    }
  }
  if (wrong > 0) throw mtf::UsageError(errors);
  if (regions.empty()) throw mtf::UsageError(source + ": no region in it; " + kForm + ", one a line");
  return regions;
}

}  // namespace calib
