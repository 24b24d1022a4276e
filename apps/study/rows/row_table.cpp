// SPDX-License-Identifier: Apache-2.0
#include "apps/study/rows/row_table.h"

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>

#include "mtf/io/atomic_file.h"
#include "mtf/parallel.h"

namespace study {
namespace {

constexpr std::size_t kMostDigits = 32;  // of a double in its shortest form, or a 64-bit number

template <class T>
void append_number(std::string& text, T value) {
  const std::size_t size = text.size();
  text.resize(size + kMostDigits);
  char* const begin = text.data() + size;
  text.resize(size + static_cast<std::size_t>(std::to_chars(begin, begin + kMostDigits, value).ptr - begin));
}

/// Columns with the words of their levels as cells.
struct Cells {
  std::vector<std::vector<std::string>> levels;

  explicit Cells(const std::vector<TableColumn>& columns) {
    for (const TableColumn& column : columns) {
      std::vector<std::string>& cells = levels.emplace_back();
      for (const std::string& level : column.levels) cells.push_back(csv_cell(level));
    }
  }

  void append(std::string& text, std::size_t column, double value) const {
    if (std::isnan(value)) return;
    const std::vector<std::string>& words = levels[column];
    if (value >= 0.0 && value < static_cast<double>(words.size()) && value == std::floor(value))
      text += words[static_cast<std::size_t>(value)];
    else
      append_number(text, value);
  }
};

std::string csv_rows(const Cells& cells, RowRange range, std::span<const double> rows) {
  const std::size_t columns = cells.levels.size();
  std::string text;
  text.reserve(rows.size() * 20);
  for (std::int64_t i = 0; i < range.count; ++i) {
    append_number(text, range.first + i);
    const double* const row = rows.data() + static_cast<std::size_t>(i) * columns;
    for (std::size_t c = 0; c < columns; ++c) {
      text += ',';
      cells.append(text, c, row[c]);
    }
    text += '\n';
  }
  return text;
}

std::string csv_header(const std::vector<TableColumn>& columns) {
  std::string text = "design";
  for (const TableColumn& column : columns) text += "," + csv_cell(column.name);
  return text + "\n";
}

std::string npy_header(std::int64_t rows, std::size_t columns) {
  constexpr std::size_t kFixed = 10, kAlign = 64;  // magic, version and length; the data start at a multiple of 64
  std::string text = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(rows) + ", " +
                     std::to_string(columns) + "), }";
  text += std::string((kAlign - (kFixed + text.size() + 1) % kAlign) % kAlign, ' ') + "\n";
  const auto length = static_cast<unsigned>(text.size());
  return std::string("\x93NUMPY\x01\0", 8) + static_cast<char>(length & 0xFFU) + static_cast<char>(length >> 8U) + text;
}

struct Token {
  const RowPiece* piece = nullptr;
  std::vector<double> rows;
  std::string csv;
  std::function<void()> count;
};

std::optional<mtf::io::AtomicFile>& open(std::optional<mtf::io::AtomicFile>& file, const std::filesystem::path& path,
                                         const std::string& header) {
  if (path.empty()) return file;
  file.emplace(path.string());
  file->write(header.data(), header.size());
  return file;
}

}  // namespace

std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\n\r") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

void write_table(const TableJob& job) {
  std::int64_t designs = 0;
  for (const RowPiece& piece : job.pieces) designs += piece.range.count;
  const Cells cells(job.columns);
  std::optional<mtf::io::AtomicFile> csv, npy;
  open(csv, job.csv, csv_header(job.columns));
  open(npy, job.npy, npy_header(designs, job.columns.size()));

  using Next = std::shared_ptr<Token>;
  std::size_t next = 0;
  std::int64_t written = 0;
  const int threads = mtf::threads_of(job.threads);
  tbb::task_arena arena(threads);
  arena.execute([&] {
    tbb::parallel_pipeline(
        static_cast<std::size_t>(threads) + 2,
        tbb::make_filter<void, Next>(tbb::filter_mode::serial_in_order, [&](tbb::flow_control& control) {
          if (next == job.pieces.size()) {
            control.stop();
            return Next();
          }
          const auto token = std::make_shared<Token>();
          token->piece = &job.pieces[next++];
          return token;
        }) & tbb::make_filter<Next, Next>(tbb::filter_mode::parallel, [&](const Next& token) {
          const RowPiece& piece = *token->piece;
          read_rows(piece, token->rows);
          if (csv) token->csv = csv_rows(cells, piece.range, token->rows);
          if (job.count_rows) token->count = job.count_rows(piece.range, token->rows);
          return token;
        }) & tbb::make_filter<Next, void>(tbb::filter_mode::serial_in_order, [&](const Next& token) {
          if (csv) csv->write(token->csv.data(), token->csv.size());
          if (npy) npy->write(token->rows.data(), token->rows.size() * sizeof(double));
          if (token->count) token->count();
          written += token->piece->range.count;
          if (job.done) job.done(written);
        }));
  });
  if (csv) csv->commit();
  if (npy) npy->commit();
}

}  // namespace study
