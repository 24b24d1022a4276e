// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/csv/csv_numbers.h"

#include <cmath>
#include <optional>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/words.h"

namespace mtf::io {

CsvNumbers read_csv_numbers(std::string_view text, const std::string& source, const std::string& remedy,
                            const ChooseColumns& choose) {
  text = without_mark(text);
  CsvNumbers numbers;
  std::vector<std::size_t> chosen;
  char separator = ',';
  std::size_t cells_of_header = 0;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::string_view row = take_text_line(text);
    if (is_comment(row)) continue;
    const auto where = [&] { return source + ":" + std::to_string(line) + ": "; };
    if (cells_of_header == 0) {
      separator = separator_of(row);
      const auto cells = split_cells(row, separator, kMaxTableColumns);
      cells_of_header = cells.size();
      if (cell_number(cells.front())) throw UsageError(where() + "the header is missing; " + remedy);
      if (cells.size() < 2)
        throw UsageError(where() + "one column only, two are needed (separator: comma, semicolon or tab); " + remedy);
      if (cells.size() > kMaxTableColumns)
        throw UsageError(where() + "more than " + std::to_string(kMaxTableColumns) + " columns");
      chosen = choose(cells, where());
      numbers.column.resize(chosen.size());
      continue;
    }
    const auto cells = split_cells(row, separator, kMaxTableColumns);
    if (cells.size() != cells_of_header)
      throw UsageError(where() + std::to_string(cells.size()) + " values where the header has " +
                       std::to_string(cells_of_header) + "; numbers have a decimal point, not a comma");
    if (numbers.line.size() == kMaxTableRows)
      throw UsageError(where() + "more than a million rows; thin the table out");
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const std::optional<double> value = cell_number(cells[chosen[i]]);
      if (!value || !std::isfinite(*value))
        throw UsageError(where() + "\"" + printable(cells[chosen[i]], 40) +
                         "\" is no finite number; write it like 0.93");
      numbers.column[i].push_back(*value);
    }
    numbers.line.push_back(line);
  }
  if (cells_of_header == 0) throw UsageError(source + ": no header and no data; " + remedy);
  if (numbers.line.empty()) throw UsageError(source + ": a header and no rows; add at least one");
  return numbers;
}

std::string read_table_text(const std::string& path, std::size_t limit) { return read_text_file(path, limit); }

}  // namespace mtf::io
