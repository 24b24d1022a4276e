// SPDX-License-Identifier: Apache-2.0
// Rows in pieces: what a stop, a damage or another number of threads leaves of them.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <sstream>
#include <thread>

#include "apps/study/rows/row_file.h"
#include "apps/study/rows/row_table.h"
#include "mtf/error.h"
#include "tests/apps/study/temp_folder.h"
#include "tests/expect_error.h"

namespace {

using study::RowRange;
using study_test::read_file;
using study_test::TempFolder;
using study_test::write_file;

constexpr std::int64_t kColumns = 5;
const study::RowLayout kLayout{std::string(64, 'a'), kColumns};

/// Numbers of every size and both signs, some NaN, one column of indices.
void fill(std::int64_t design, std::span<double> row) {
  const auto d = static_cast<double>(design);
  row[0] = static_cast<double>(design % 2);
  row[1] = std::sin(d) * std::pow(10.0, std::fmod(d, 600.0) - 300.0);
  row[2] = design % 7 == 3 ? std::nan("") : 1.0 / (d + 1.0);
  row[3] = -d;
  row[4] = std::bit_cast<double>(std::uint64_t{0x3ff0000000000000} + static_cast<std::uint64_t>(design * 12345677));
}

study::RowRun run_of(const TempFolder& folder, std::int64_t designs, int threads = 2, std::int64_t piece = 16) {
  return {.layout = kLayout,
          .range = {0, designs},
          .folder = folder / "parts",
          .piece = piece,
          .threads = threads,
          .make = [] { return study::RowMaker(fill); },
          .done = {}};
}

const std::vector<study::TableColumn> kTable{
    {"kind", {"plain, wide", "say \"hi\""}}, {"a", {}}, {"b", {}}, {"c", {}}, {"d", {}}};

/// CSV of the pieces, then their NPY.
std::string table_of(const TempFolder& folder, const std::vector<study::RowPiece>& pieces, int threads = 2) {
  study::write_table(
      {.pieces = pieces, .columns = kTable, .csv = folder / "t.csv", .npy = folder / "t.npy", .threads = threads});
  return read_file(folder / "t.csv") + read_file(folder / "t.npy");
}

std::string table_of(const TempFolder& folder, const study::RowRun& run) {
  study::run_rows(run);
  return table_of(folder, study::rows_of(run), run.threads);
}

TEST(Rows, TheTableIsTheSameForAnyThreadsAndPieces) {
  const TempFolder first;
  const std::string expected = table_of(first, run_of(first, 1003, 1));
  for (const int threads : {1, 2, 7})
    for (const std::int64_t piece : {1, 16, 1000, 5000}) {
      const TempFolder folder;
      EXPECT_EQ(table_of(folder, run_of(folder, 1003, threads, piece)), expected) << threads << " " << piece;
    }
}

TEST(Rows, CsvReadsBackBitForBit) {
  const TempFolder folder;
  table_of(folder, run_of(folder, 200));
  const std::string csv = read_file(folder / "t.csv");
  EXPECT_TRUE(csv.starts_with("design,kind,a,b,c,d\n0,\"plain, wide\",")) << csv.substr(0, 80);
  std::size_t at = csv.find('\n') + 1;
  for (std::int64_t design = 0; design < 200; ++design) {
    std::array<double, kColumns> row{};
    fill(design, row);
    const std::string line = csv.substr(at, csv.find('\n', at) - at);
    at += line.size() + 1;
    const std::string word = design % 2 == 0 ? "\"plain, wide\"" : "\"say \"\"hi\"\"\"";
    const std::string head = std::to_string(design) + "," + word;
    ASSERT_TRUE(line.starts_with(head)) << line;
    const char* text = line.data() + head.size();
    const char* const end = line.data() + line.size();
    for (std::size_t c = 1; c < row.size(); ++c) {
      ASSERT_EQ(*text, ',');
      ++text;
      double value = 0.0;
      const auto [stop, error] = std::from_chars(text, end, value);
      if (std::isnan(row[c])) {
        EXPECT_TRUE(text == end || *text == ',') << line;
        continue;
      }
      EXPECT_EQ(std::bit_cast<std::uint64_t>(value), std::bit_cast<std::uint64_t>(row[c])) << line;
      text = stop;
    }
    EXPECT_EQ(text, end) << line;
  }
  EXPECT_EQ(at, csv.size());
}

TEST(Rows, NpyIsVersionOneWithTheRowsAfterAnAlignedHeader) {
  const TempFolder folder;
  table_of(folder, run_of(folder, 33));
  const std::string npy = read_file(folder / "t.npy");
  ASSERT_TRUE(npy.starts_with(std::string("\x93NUMPY\x01\0", 8)));
  const std::size_t length = static_cast<unsigned char>(npy[8]) + 256U * static_cast<unsigned char>(npy[9]);
  EXPECT_EQ((10 + length) % 64, 0U);
  EXPECT_EQ(npy[9 + length], '\n');
  EXPECT_TRUE(npy.substr(10).starts_with("{'descr': '<f8', 'fortran_order': False, 'shape': (33, 5), }"));
  ASSERT_EQ(npy.size(), 10 + length + 33 * kColumns * sizeof(double));
  std::array<double, kColumns> expected{}, row{};
  fill(32, expected);
  std::memcpy(row.data(), npy.data() + npy.size() - sizeof row, sizeof row);
  EXPECT_EQ(std::memcmp(row.data(), expected.data(), sizeof row), 0);
}

TEST(Rows, MarkedDesignsHaveAOneInAColumnOfTheirOwn) {
  const TempFolder folder;
  const study::RowRun run = run_of(folder, 33, 2, 4);
  const std::string plain = table_of(folder, run);
  std::vector<study::TableColumn> columns = kTable;
  columns.push_back({"mark", {}});
  study::write_table({.pieces = study::rows_of(run),
                      .columns = columns,
                      .marked = std::vector<std::int64_t>{0, 7, 8, 32},
                      .csv = folder / "m.csv",
                      .npy = folder / "m.npy"});
  std::istringstream without(plain), with(read_file(folder / "m.csv"));
  std::string left, right;
  for (int line = -1; line < 33; ++line) {
    ASSERT_TRUE(std::getline(without, left) && std::getline(with, right));
    const bool one = line == 0 || line == 7 || line == 8 || line == 32;
    EXPECT_EQ(right, left + (line < 0 ? ",mark" : one ? ",1" : ",0"));
  }
  const std::string npy = read_file(folder / "m.npy");
  expect_says(npy, {"'shape': (33, 6)"});
  double last = 0.0;
  std::memcpy(&last, npy.data() + npy.size() - sizeof last, sizeof last);
  EXPECT_EQ(last, 1.0);
}

TEST(Rows, NoDesignIsATableOfAHeader) {
  const TempFolder folder;
  table_of(folder, run_of(folder, 0));
  EXPECT_EQ(read_file(folder / "t.csv"), "design,kind,a,b,c,d\n");
  expect_says(read_file(folder / "t.npy"), {"'shape': (0, 5)"});
}

TEST(Rows, OneDesign) {
  const TempFolder folder;
  table_of(folder, run_of(folder, 1));
  EXPECT_EQ(read_file(folder / "t.csv"), "design,kind,a,b,c,d\n0,\"plain, wide\",0,1,-0,1\n");
}

TEST(Rows, ARunKilledInTheMiddleGoesOnAndGivesTheSameBytes) {
  const TempFolder whole, folder;
  const std::string expected = table_of(whole, run_of(whole, 400, 1));
  study::RowRun slow = run_of(folder, 400, 1);
  slow.make = [] {
    return study::RowMaker([](std::int64_t design, std::span<double> row) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      fill(design, row);
    });
  };
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    study::run_rows(slow);
    ::_exit(0);
  }
  const auto files = [&] {
    std::error_code error;
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(slow.folder, error))
      count += entry.path().extension().empty() ? 1U : 0U;
    return count;
  };
  while (files() < 5) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  const study::RowTally tally = study::run_rows(run_of(folder, 400, 2));
  EXPECT_GE(tally.resumed, 5 * 16);
  EXPECT_LT(tally.resumed, 400);
  EXPECT_EQ(tally.made + tally.resumed, 400);
  EXPECT_EQ(table_of(folder, study::rows_of(run_of(folder, 400))), expected);
}

TEST(Rows, DamagedPiecesAreMadeAgain) {
  const TempFolder whole;
  const std::string expected = table_of(whole, run_of(whole, 100));
  const TempFolder folder;
  const study::RowRun run = run_of(folder, 100);
  study::run_rows(run);
  const auto file = run.folder / "rows-0000000032";
  const std::string good = read_file(file);
  std::string flipped = good, head = good, foreign = good;
  flipped[flipped.size() - 3] = static_cast<char>(flipped[flipped.size() - 3] ^ 1);
  head[head.find("first 32") + 6] = '4';
  foreign[foreign.find("aaaa")] = 'b';
  for (const std::string& bad : {flipped, head, foreign, good.substr(0, good.size() - 1), good + "x", good + good,
                                 std::string("x"), std::string()}) {
    write_file(file, bad);
    const study::RowTally tally = study::run_rows(run);
    EXPECT_EQ(tally.damaged, 16);
    EXPECT_EQ(tally.made, 16);
    EXPECT_EQ(tally.resumed, 84);
    EXPECT_EQ(table_of(folder, study::rows_of(run)), expected);
  }
}

TEST(Rows, DamageThatComesLaterIsNamedAndLeavesNoTable) {
  const TempFolder folder;
  const study::RowRun run = run_of(folder, 100);
  study::run_rows(run);
  const auto pieces = study::rows_of(run);
  std::string bytes = read_file(pieces[3].file);
  bytes.back() = static_cast<char>(bytes.back() ^ 64);
  write_file(pieces[3].file, bytes);
  expect_refused<mtf::Error>({"rows-0000000048: damaged", "designs 48 to 63"}, [&] { table_of(folder, pieces); });
  EXPECT_FALSE(std::filesystem::exists(folder / "t.csv"));
  EXPECT_FALSE(std::filesystem::exists(folder / "t.npy"));
}

// Whichever bit flips, in the lines, the checksums or the numbers: the file is called damaged, not another study's, and
// a row whose numbers have changed is named.
TEST(Rows, AFlippedBitIsDamageWhereverItIs) {
  const TempFolder folder;
  const study::RowRun run = run_of(folder, 12, 2, 4);
  study::run_rows(run);
  study::join_rows(study::rows_of(run), folder / "joined");
  const std::string good = read_file(folder / "joined");
  const study::RowPiece last = study::list_rows(folder / "joined").back();
  const std::size_t numbers = good.size() - 4 * kColumns * sizeof(double);
  std::vector<double> rows;
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ (1 << at % 8));
    write_file(folder / "joined", bad);
    const std::string message = message_of([&] {
      for (const study::RowPiece& piece : study::in_order(study::list_rows(folder / "joined"), kLayout, {0, 12}))
        study::read_rows(piece, rows);
    });
    EXPECT_TRUE(says(message, "joined: damaged: ")) << at << ": " << message;
    if (at < numbers) continue;
    const std::size_t row = (at - numbers) / (kColumns * sizeof(double));
    expect_says(message, {"designs 8 to 11", "row of design " + std::to_string(8 + row)});
  }
  EXPECT_EQ(last.range, (RowRange{8, 4}));
}

TEST(Rows, PiecesHaveToCoverTheDesignsOnce) {
  const TempFolder folder;
  const study::RowRun run = run_of(folder, 100);
  study::run_rows(run);
  auto pieces = study::rows_of(run);
  auto twice = pieces;
  twice.push_back(pieces[2]);
  expect_refused<mtf::Error>({"foreign"}, [&] { study::in_order(twice, kLayout, run.range); });
  auto gap = pieces;
  gap.erase(gap.begin() + 1);
  expect_refused<mtf::Error>({"designs 16 to 31", "missing"}, [&] { study::in_order(gap, kLayout, run.range); });
  auto cut = pieces;
  cut.pop_back();
  expect_refused<mtf::Error>({"designs 96 to 99", "missing"}, [&] { study::in_order(cut, kLayout, run.range); });
  std::swap(pieces[0], pieces[4]);
  EXPECT_EQ(study::in_order(pieces, kLayout, run.range)[0].range, (RowRange{0, 16}));
}

TEST(Rows, AFailureOfARowMakerComesThroughAndKeepsWhatIsDone) {
  const TempFolder folder;
  study::RowRun run = run_of(folder, 400);
  run.make = [] {
    return study::RowMaker([](std::int64_t design, std::span<double> row) {
      if (design == 200) throw mtf::RuntimeError("no such curve");
      fill(design, row);
    });
  };
  EXPECT_EQ(message_of([&] { study::run_rows(run); }), "no such curve");
  const study::RowTally tally = study::run_rows(run_of(folder, 400));
  EXPECT_GE(tally.resumed, 100);
}

TEST(Rows, JoinedFilesReadAsTheirPieces) {
  const TempFolder folder;
  const study::RowRun run = run_of(folder, 100);
  study::run_rows(run);
  const std::string expected = table_of(folder, study::rows_of(run));
  study::join_rows(study::rows_of(run), folder / "joined");
  const auto pieces = study::list_rows(folder / "joined");
  EXPECT_EQ(pieces.size(), 7U);
  EXPECT_EQ(table_of(folder, pieces), expected);
}

}  // namespace
