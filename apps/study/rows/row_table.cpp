// SPDX-License-Identifier: Apache-2.0
#include "apps/study/rows/row_table.h"

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>

#include "mtf/io/atomic_file.h"
#include "mtf/io/csv/csv_cells.h"
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
      for (const std::string& level : column.levels) cells.push_back(mtf::io::csv_field(level));
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
  for (const TableColumn& column : columns) text += "," + mtf::io::csv_field(column.name);
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

/// What is known of a piece on its way through the threads.
struct Token {
  const RowPiece* piece = nullptr;
  std::function<void()> finish;
};

/// Rows of one column more: 1 for the marked designs, 0 for the others.
std::vector<double> with_mark(RowRange range, const std::vector<double>& rows,
                              const std::vector<std::int64_t>& marked) {
  const std::size_t columns = rows.size() / static_cast<std::size_t>(range.count);
  std::vector<double> wider;
  wider.reserve(rows.size() + static_cast<std::size_t>(range.count));
  for (std::int64_t i = 0; i < range.count; ++i) {
    const auto row = rows.begin() + i * static_cast<std::int64_t>(columns);
    wider.insert(wider.end(), row, row + static_cast<std::int64_t>(columns));
    wider.push_back(std::binary_search(marked.begin(), marked.end(), range.first + i) ? 1.0 : 0.0);
  }
  return wider;
}

}  // namespace

void read_pieces(const std::vector<RowPiece>& pieces, const PieceWork& work, int threads, const RowsDone& done) {
  using Next = std::shared_ptr<Token>;
  std::size_t next = 0;
  std::int64_t finished = 0;
  const int count = mtf::threads_of(threads);
  tbb::task_arena arena(count);
  arena.execute([&] {
    tbb::parallel_pipeline(
        static_cast<std::size_t>(count) + 2,
        tbb::make_filter<void, Next>(tbb::filter_mode::serial_in_order, [&](tbb::flow_control& control) {
          if (next == pieces.size()) {
            control.stop();
            return Next();
          }
          const auto token = std::make_shared<Token>();
          token->piece = &pieces[next++];
          return token;
        }) & tbb::make_filter<Next, Next>(tbb::filter_mode::parallel, [&](const Next& token) {
          std::vector<double> rows;
          read_rows(*token->piece, rows);
          token->finish = work(token->piece->range, std::move(rows));
          return token;
        }) & tbb::make_filter<Next, void>(tbb::filter_mode::serial_in_order, [&](const Next& token) {
          token->finish();
          finished += token->piece->range.count;
          if (done) done(finished);
        }));
  });
}

void write_table(const TableJob& job) {
  std::int64_t designs = 0;
  for (const RowPiece& piece : job.pieces) designs += piece.range.count;
  const Cells cells(job.columns);
  mtf::io::AtomicFile csv(job.csv.string()), npy(job.npy.string());
  const auto put = [](mtf::io::AtomicFile& file, const std::string& text) { file.write(text.data(), text.size()); };
  put(csv, csv_header(job.columns));
  put(npy, npy_header(designs, job.columns.size()));
  const auto work = [&](RowRange range, std::vector<double> read) {
    if (job.marked) read = with_mark(range, read, *job.marked);
    const auto rows = std::make_shared<const std::vector<double>>(std::move(read));
    return [&csv, &npy, put, rows, text = csv_rows(cells, range, *rows)] {
      put(csv, text);
      npy.write(rows->data(), rows->size() * sizeof(double));
    };
  };
  read_pieces(job.pieces, work, job.threads, job.done);
  csv.commit();
  npy.commit();
}

}  // namespace study
