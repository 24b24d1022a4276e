// SPDX-License-Identifier: Apache-2.0
#include "apps/terminal/text_table.h"

#include <algorithm>
#include <cmath>

#include "mtf/units.h"

namespace apps {
namespace {

// Characters, not bytes: continuation bytes of UTF-8 take no room.
std::size_t shown_width(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

}  // namespace

std::string TextTable::aligned(const std::vector<Align>& align) const {
  std::vector<std::size_t> widths(rows_.front().size(), 0);
  for (const auto& row : rows_)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], shown_width(row[i]));
  std::string text;
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string padding(widths[i] - shown_width(row[i]), ' ');
      const bool right = i < align.size() && align[i] == Align::right;
      line += (i > 0 ? "  " : "") + (right ? padding + row[i] : row[i] + padding);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string TextTable::csv() const {
  std::string text;
  for (const auto& row : rows_)
    for (std::size_t i = 0; i < row.size(); ++i) text += csv_field(row[i]) + (i + 1 < row.size() ? "," : "\n");
  return text;
}

std::string csv_number(double value) { return std::isfinite(value) ? mtf::format_double(value) : ""; }

}  // namespace apps
