// SPDX-License-Identifier: Apache-2.0
#include "apps/study/rows/row_run.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/words.h"

namespace study {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kSmallestPiece = 4, kLargestPiece = 4096, kPieces = 256;

std::int64_t size_of(const RowRun& run) { return run.piece > 0 ? run.piece : piece_size(run.range.count); }

RowRange piece_range(const RowRun& run, std::int64_t index) {
  const std::int64_t size = size_of(run), first = run.range.first + index * size;
  return {first, std::min(size, run.range.end() - first)};
}

fs::path file_of(const RowRun& run, RowRange range) {
  const std::string number = std::to_string(range.first);
  return run.folder / ("rows-" + std::string(10 - std::min<std::size_t>(10, number.size()), '0') + number);
}

enum class Found { nothing, good, bad };

Found read_piece(const RowRun& run, RowRange range, std::vector<double>& rows) {
  const fs::path file = file_of(run, range);
  std::error_code error;
  if (!fs::exists(file, error)) return Found::nothing;
  try {
    const std::vector<RowPiece> pieces = list_rows(file);
    if (pieces.size() != 1 || pieces[0].layout != run.layout || pieces[0].range != range) return Found::bad;
    read_rows(pieces[0], rows);
    return Found::good;
  } catch (const mtf::RuntimeError&) {
    return Found::bad;
  }
}

/// All that the threads share.
struct Shared {
  const RowRun& run;
  std::int64_t pieces;
  std::atomic<std::int64_t> next{0};
  std::mutex lock{};
  RowTally tally{};
  std::exception_ptr failure{};
};

void make_piece(Shared& shared, RowMaker& maker, RowRange range, std::vector<double>& rows) {
  const RowRun& run = shared.run;
  const Found found = read_piece(run, range, rows);
  if (found != Found::good) {
    if (!maker) maker = run.make();
    const auto columns = static_cast<std::size_t>(run.layout.columns);
    rows.resize(static_cast<std::size_t>(range.count) * columns);
    for (std::int64_t i = 0; i < range.count; ++i)
      maker(range.first + i, std::span(rows).subspan(static_cast<std::size_t>(i) * columns, columns));
    write_rows(file_of(run, range), run.layout, range, rows);
  }
  const std::lock_guard guard(shared.lock);
  (found == Found::good ? shared.tally.resumed : shared.tally.made) += range.count;
  if (found == Found::bad) shared.tally.damaged += range.count;
  if (run.done) run.done(shared.tally.made + shared.tally.resumed);
}

void make_pieces(Shared& shared) {
  try {
    RowMaker maker;
    std::vector<double> rows;
    for (std::int64_t i; (i = shared.next++) < shared.pieces;)
      make_piece(shared, maker, piece_range(shared.run, i), rows);
  } catch (...) {
    shared.next = shared.pieces;
    const std::lock_guard guard(shared.lock);
    if (!shared.failure) shared.failure = std::current_exception();
  }
}

}  // namespace

std::int64_t piece_size(std::int64_t designs) {
  return std::clamp((designs + kPieces - 1) / kPieces, kSmallestPiece, kLargestPiece);
}

RowTally run_rows(const RowRun& run) {
  std::error_code error;
  fs::create_directory(run.folder, error);
  if (error) throw mtf::RuntimeError("cannot create " + mtf::printable(run.folder.string()) + ": " + error.message());
  const std::int64_t size = size_of(run);
  Shared shared{.run = run, .pieces = (run.range.count + size - 1) / size};
  const auto threads = std::min<std::int64_t>(mtf::threads_of(run.threads), shared.pieces);
  std::vector<std::jthread> others;
  for (std::int64_t i = 1; i < threads; ++i) others.emplace_back([&shared] { make_pieces(shared); });
  make_pieces(shared);
  others.clear();
  if (shared.failure) std::rethrow_exception(shared.failure);
  return shared.tally;
}

std::vector<RowPiece> rows_of(const RowRun& run) {
  std::vector<RowPiece> pieces;
  const std::int64_t size = size_of(run);
  for (std::int64_t first = run.range.first; first < run.range.end(); first += size) {
    const fs::path file = file_of(run, piece_range(run, (first - run.range.first) / size));
    std::error_code error;
    if (!fs::exists(file, error)) continue;  // named by its designs below
    for (RowPiece& piece : list_rows(file)) pieces.push_back(std::move(piece));
  }
  return in_order(std::move(pieces), run.layout, run.range);
}

}  // namespace study
