// SPDX-License-Identifier: Apache-2.0
#include "mtf/tiles/tile_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

namespace mtf::test {
namespace {

TEST(TileQueue, every_tile_once_and_no_row_before_all_above_are_read) {
  constexpr std::int64_t count = 40, tiles_per_row = 7;  // the last row is not full
  TileQueue queue(count, tiles_per_row);
  std::array<std::atomic<int>, count> taken{};
  std::atomic<std::int64_t> read = 0;
  std::atomic<int> early = 0;
  std::vector<std::thread> workers;
  for (int t = 0; t < 4; ++t)
    workers.emplace_back([&] {
      for (std::int64_t i = queue.next(); i < count; i = queue.next()) {
        ++taken[static_cast<std::size_t>(i)];
        if (read < i / tiles_per_row * tiles_per_row) ++early;
        std::this_thread::sleep_for(std::chrono::microseconds(i % 5 * 100));
        ++read;
        queue.was_read();
      }
    });
  for (std::thread& worker : workers) worker.join();
  EXPECT_EQ(std::count(taken.begin(), taken.end(), 1), count);
  EXPECT_EQ(early, 0);
}

TEST(TileQueue, a_failure_ends_those_that_wait) {
  TileQueue queue(4, 2);
  EXPECT_EQ(queue.next(), 0);
  EXPECT_EQ(queue.next(), 1);
  std::thread waiting([&] { EXPECT_EQ(queue.next(), 4); });
  queue.stop();
  waiting.join();
}

}  // namespace
}  // namespace mtf::test
