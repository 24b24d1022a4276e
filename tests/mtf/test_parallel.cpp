// SPDX-License-Identifier: Apache-2.0

// Loops over threads: each piece once, calls within calls, and the memory of many calls.

#include "mtf/parallel.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <thread>
#include <vector>

namespace {

double resident_mib() {
  std::ifstream statm("/proc/self/statm");
  long whole = 0, resident = 0;
  statm >> whole >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

TEST(Parallel, EachPlaceIsVisitedOnceByConcurrentAndNestedCalls) {
  constexpr std::int64_t kCount = 301;
  const auto visit = [](int threads) {
    std::vector<std::atomic<int>> visits(kCount * kCount);
    mtf::parallel_for(kCount, 7, threads, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i)
        mtf::parallel_for(kCount, 50, threads, [&](std::int64_t first, std::int64_t last) {
          for (std::int64_t j = first; j < last; ++j) ++visits[static_cast<std::size_t>(i * kCount + j)];
        });
    });
    for (const auto& n : visits) ASSERT_EQ(n, 1);
  };
  std::vector<std::thread> callers;
  for (const int threads : {0, 1, 2, 2, 3}) callers.emplace_back(visit, threads);
  for (std::thread& caller : callers) caller.join();
}

// A caller may hold a lock while it waits for its own pieces. Were it given a piece of an outer call meanwhile, that
// piece would wait for the lock forever.
TEST(Parallel, AThreadThatWaitsTakesNoPieceOfAnOuterCall) {
  static thread_local bool waits = false;
  std::atomic<int> taken{0};
  mtf::parallel_for(200, 1, 4, [&](std::int64_t, std::int64_t) {
    if (waits) ++taken;
    waits = true;
    mtf::parallel_for(8, 1, 4, [](std::int64_t, std::int64_t) { std::this_thread::yield(); });
    waits = false;
  });
  EXPECT_EQ(taken, 0);
}

// An arena that is made for each call leaves some 6 kB behind (oneTBB issue 967).
TEST(Parallel, ManyCallsLeaveNoMemoryBehind) {
  const auto call = [](int times) {
    for (int i = 0; i < times; ++i) mtf::parallel_for(8, 1, 2, [](std::int64_t, std::int64_t) {});
  };
  call(2000);
  const double before = resident_mib();
  call(20000);
  EXPECT_LT(resident_mib() - before, 2.0);
}

}  // namespace
