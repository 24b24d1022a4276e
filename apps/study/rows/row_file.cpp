// SPDX-License-Identifier: Apache-2.0
#include "apps/study/rows/row_file.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <charconv>
#include <exception>
#include <fstream>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>

#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/sha256.h"
#include "mtf/math/word_hash.h"
#include "mtf/parallel.h"
#include "mtf/words.h"

namespace study {
namespace {

static_assert(std::endian::native == std::endian::little, "row files hold the numbers as they lie in memory");

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "mtfkit rows 2\n";
constexpr std::size_t kMostHead = 400;  // bytes; the lines take some 240
constexpr std::int64_t kMostRows = 1'000'000'000, kMostColumns = 100'000;

/// The lines that a hash covers besides the numbers.
std::string lines_of(const RowLayout& layout, RowRange range) {
  return std::string(kMagic) + "key " + layout.key + "\nfirst " + std::to_string(range.first) + "\ncount " +
         std::to_string(range.count) + "\ncolumns " + std::to_string(layout.columns) + "\n";
}

std::string hash_of(const RowLayout& layout, RowRange range, std::span<const std::uint64_t> sums,
                    std::span<const double> rows) {
  const std::string checksums =
      mtf::io::sha256_hex({reinterpret_cast<const char*>(sums.data()), sums.size() * sizeof(std::uint64_t)});
  const std::string numbers =
      mtf::io::sha256_hex({reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(double)});
  return mtf::io::sha256_hex(lines_of(layout, range) + checksums + numbers);
}

/// A checksum of each row, over the bits of its numbers.
std::vector<std::uint64_t> sums_of(RowRange range, std::span<const double> rows) {
  std::vector<std::uint64_t> sums;
  const std::size_t columns = rows.size() / static_cast<std::size_t>(range.count);
  for (std::size_t row = 0; row < static_cast<std::size_t>(range.count); ++row) {
    std::uint64_t sum = mtf::kWordHashStart;
    for (const double value : rows.subspan(row * columns, columns))
      sum = mtf::mixed(sum, std::bit_cast<std::uint64_t>(value));
    sums.push_back(sum);
  }
  return sums;
}

[[noreturn]] void damaged(const fs::path& file, const std::string& what) {
  throw DamagedRows(shown(file) + ": damaged: " + what + "; its designs have to be computed again");
}

/// Says which rows do not have their checksum.
[[noreturn]] void damaged_rows(const RowPiece& piece, std::span<const std::uint64_t> sums,
                               std::span<const double> rows) {
  const std::vector<std::uint64_t> found = sums_of(piece.range, rows);
  std::int64_t first = -1, wrong = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i] == sums[i]) continue;
    if (++wrong == 1) first = piece.range.first + static_cast<std::int64_t>(i);
  }
  const std::string numbers = "the numbers of " + describe(piece.range) + " are not those that were written";
  if (wrong == 0) damaged(piece.file, "the lines above " + describe(piece.range) + " are not those that were written");
  damaged(piece.file, numbers + ": " +
                          (wrong == 1 ? "the row of design " + std::to_string(first) + " has changed"
                                      : std::to_string(wrong) + " rows have changed, the first is that of design " +
                                            std::to_string(first)));
}

/// Takes "<word> <value>\n" off the front of `text`; null where that is not there.
std::optional<std::string_view> take_line(std::string_view& text, std::string_view word) {
  const std::size_t end = text.find('\n');
  if (end == std::string_view::npos || !text.starts_with(word) || end <= word.size() || text[word.size()] != ' ')
    return std::nullopt;
  const std::string_view value = text.substr(word.size() + 1, end - word.size() - 1);
  text.remove_prefix(end + 1);
  return value;
}

bool take_number(std::string_view& text, std::string_view word, std::int64_t low, std::int64_t high,
                 std::int64_t& number) {
  const auto value = take_line(text, word);
  if (!value) return false;
  const char* const end = value->data() + value->size();
  const auto [stop, error] = std::from_chars(value->data(), end, number);
  return error == std::errc{} && stop == end && number >= low && number <= high;
}

bool take_hash(std::string_view& text, std::string_view word, std::string& hash) {
  const auto value = take_line(text, word);
  if (!value || value->size() != 64 || value->find_first_not_of("0123456789abcdef") != std::string_view::npos)
    return false;
  hash = *value;
  return true;
}

/// Writes a file of one piece; rows.size() = range.count x layout.columns. Throws RuntimeError (disk full, ...).
void write_rows(const fs::path& file, const RowLayout& layout, RowRange range, std::span<const double> rows) {
  mtf::io::AtomicFile out(file.string());
  const std::vector<std::uint64_t> sums = sums_of(range, rows);
  const std::string head = lines_of(layout, range) + "sha256 " + hash_of(layout, range, sums, rows) + "\n\n";
  out.write(head.data(), head.size());
  out.write(sums.data(), sums.size() * sizeof(std::uint64_t));
  out.write(rows.data(), rows.size() * sizeof(double));
  out.commit();
}

/// Designs in a piece: small enough to lose little and to share among threads, large enough for few files.
std::int64_t size_of(const RowRun& run) {
  constexpr std::int64_t kSmallest = 4, kLargest = 4096, kPieces = 256;
  return run.piece > 0 ? run.piece : std::clamp((run.range.count + kPieces - 1) / kPieces, kSmallest, kLargest);
}

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

std::string shown(const fs::path& path) { return mtf::printable(path.string()); }

std::uint64_t RowPiece::bytes() const {
  const auto words_of_row = static_cast<std::uint64_t>(layout.columns) + 1;  // a checksum and the numbers
  return static_cast<std::uint64_t>(range.count) * words_of_row * sizeof(double);
}

std::vector<RowPiece> list_rows(const fs::path& file) {
  const auto size = static_cast<std::uint64_t>(mtf::io::input_file_size(file.string()));
  std::ifstream in(file, std::ios::binary);
  if (!in) throw mtf::RuntimeError(shown(file) + ": cannot be opened");
  std::vector<RowPiece> pieces;
  for (std::uint64_t at = 0; at < size;) {
    std::array<char, kMostHead> bytes{};
    in.clear();
    in.seekg(static_cast<std::streamoff>(at));
    in.read(bytes.data(), bytes.size());
    std::string_view text(bytes.data(), static_cast<std::size_t>(in.gcount()));
    RowPiece piece{.file = file, .offset = at, .layout = {}, .range = {}, .sha256 = {}};
    const std::size_t all = text.size();
    if (!text.starts_with(kMagic)) damaged(file, at == 0 ? "no row file" : "cut in the middle");
    text.remove_prefix(kMagic.size());
    if (!take_hash(text, "key", piece.layout.key) || !take_number(text, "first", 0, kMostRows, piece.range.first) ||
        !take_number(text, "count", 1, kMostRows, piece.range.count) ||
        !take_number(text, "columns", 1, kMostColumns, piece.layout.columns) ||
        !take_hash(text, "sha256", piece.sha256) || !text.starts_with('\n'))
      damaged(file, "its first lines cannot be read");
    piece.head = all - text.size() + 1;
    if (piece.bytes() > size - at - piece.head) damaged(file, "it ends too early");
    at += piece.head + piece.bytes();
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

void read_rows(const RowPiece& piece, std::vector<double>& rows) {
  std::vector<std::uint64_t> sums(static_cast<std::size_t>(piece.range.count));
  rows.resize(sums.size() * static_cast<std::size_t>(piece.layout.columns));
  std::ifstream in(piece.file, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(piece.offset + piece.head));
  in.read(reinterpret_cast<char*>(sums.data()), static_cast<std::streamsize>(sums.size() * sizeof(std::uint64_t)));
  in.read(reinterpret_cast<char*>(rows.data()), static_cast<std::streamsize>(rows.size() * sizeof(double)));
  if (!in) throw mtf::RuntimeError(shown(piece.file) + ": cannot be read");
  if (hash_of(piece.layout, piece.range, sums, rows) != piece.sha256) damaged_rows(piece, sums, rows);
}

void join_rows(const std::vector<RowPiece>& pieces, const fs::path& file) {
  mtf::io::AtomicFile out(file.string());
  std::vector<char> bytes;
  for (const RowPiece& piece : pieces) {
    bytes.resize(piece.head + piece.bytes());
    std::ifstream in(piece.file, std::ios::binary);
    in.seekg(static_cast<std::streamoff>(piece.offset));
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!in) throw mtf::RuntimeError(shown(piece.file) + ": cannot be read");
    out.write(bytes.data(), bytes.size());
  }
  out.commit();
}

std::string describe(RowRange range) {
  return range.count == 1 ? "design " + std::to_string(range.first)
                          : "designs " + std::to_string(range.first) + " to " + std::to_string(range.end() - 1);
}

std::vector<RowPiece> in_order(std::vector<RowPiece> pieces, const RowLayout& layout, RowRange range) {
  // A flipped bit in the lines of a piece makes it look like one of another study or of other designs.
  const auto refuse = [](const RowPiece& piece, const std::string& problem) {
    std::vector<double> rows;
    read_rows(piece, rows);
    throw mtf::RuntimeError(problem);
  };
  for (const RowPiece& piece : pieces)
    if (piece.layout != layout)
      refuse(piece, shown(piece.file) + ": foreign: made for another study, tolerance or version; remove it");
  std::sort(pieces.begin(), pieces.end(),
            [](const RowPiece& a, const RowPiece& b) { return a.range.first < b.range.first; });
  std::int64_t next = range.first;
  for (const RowPiece& piece : pieces) {
    if (piece.range.first > next)
      refuse(piece, describe(RowRange{next, piece.range.first - next}) + ": missing, " + shown(piece.file) +
                        " comes after them");
    if (piece.range.first < next || piece.range.end() > range.end())
      refuse(piece, shown(piece.file) + ": foreign: holds " + describe(piece.range) +
                        ", which others hold or nothing asks for; remove it");
    next = piece.range.end();
  }
  if (next < range.end()) throw mtf::RuntimeError(describe(RowRange{next, range.end() - next}) + ": missing");
  return pieces;
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
