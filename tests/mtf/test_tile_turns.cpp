// SPDX-License-Identifier: Apache-2.0
#include "mtf/tile_turns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

namespace mtf::test {
namespace {

TEST(Turns, every_tile_once_and_no_row_before_all_above_are_read) {
  constexpr std::int64_t count = 40, a_row = 7;  // the last row is not full
  Turns turns(count, a_row);
  std::array<std::atomic<int>, count> taken{};
  std::atomic<std::int64_t> read = 0;
  std::atomic<int> early = 0;
  std::vector<std::thread> workers;
  for (int t = 0; t < 4; ++t)
    workers.emplace_back([&] {
      for (std::int64_t i = turns.next(); i < count; i = turns.next()) {
        ++taken[static_cast<std::size_t>(i)];
        if (read < i / a_row * a_row) ++early;
        std::this_thread::sleep_for(std::chrono::microseconds(i % 5 * 100));
        ++read;
        turns.was_read();
      }
    });
  for (std::thread& worker : workers) worker.join();
  EXPECT_EQ(std::count(taken.begin(), taken.end(), 1), count);
  EXPECT_EQ(early, 0);
}

TEST(Turns, a_failure_ends_those_that_wait) {
  Turns turns(4, 2);
  EXPECT_EQ(turns.next(), 0);
  EXPECT_EQ(turns.next(), 1);
  std::thread waiting([&] { EXPECT_EQ(turns.next(), 4); });
  turns.stop();
  waiting.join();
}

}  // namespace
}  // namespace mtf::test
