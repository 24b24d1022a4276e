// SPDX-License-Identifier: Apache-2.0
// How often each case is run; times themselves are nobody's promise.
#include <gtest/gtest.h>

#include <limits>

#include "apps/bench/interleave.h"

namespace {

using apps::detail::runs_within;

TEST(Interleave, EveryRoundWhereTimeAllows) {
  EXPECT_EQ(runs_within({1.0, 5.0, 2.0}, 15, std::numeric_limits<double>::infinity()), (std::vector{15, 15, 15}));
  EXPECT_EQ(runs_within({1.0, 5.0, 2.0}, 15, 121.0), (std::vector{15, 15, 15}));
}

TEST(Interleave, SlowOnesGiveWayToQuickOnes) {
  // 10 ms and 20 ms for all rounds of the quick ones; the rest of 100 ms is for the slow one.
  EXPECT_EQ(runs_within({1.0, 1000.0, 2.0}, 10, 100.0), (std::vector{10, 1, 10}));
  EXPECT_EQ(runs_within({1.0, 20.0, 2.0}, 10, 100.0), (std::vector{10, 3, 10}));
  // No time at all: each once.
  EXPECT_EQ(runs_within({1.0, 20.0}, 10, 0.0), (std::vector{1, 1}));
  EXPECT_EQ(runs_within({1.0, 20.0}, 10, -50.0), (std::vector{1, 1}));
  EXPECT_EQ(runs_within({}, 10, 5.0), std::vector<int>{});
  EXPECT_EQ(runs_within({0.0}, 10, 0.0), std::vector{10});
}

TEST(Interleave, TakesTurnsAndReportsItsEnd) {
  std::string order;
  double last = -1.0;
  const auto times = apps::interleave({[&] { order += 'a'; }, [&] { order += 'b'; }},
                                      {.rounds = 3, .progress = [&](double share) { last = share; }});
  EXPECT_EQ(order, "abababab");  // the first round is not counted
  EXPECT_EQ(last, 1.0);
  ASSERT_EQ(times.size(), 2U);
  for (const apps::Timing& time : times) {
    EXPECT_EQ(time.runs, 3);
    EXPECT_LE(time.min_ms, time.median_ms);
  }
}

}  // namespace
