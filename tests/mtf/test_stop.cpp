// SPDX-License-Identifier: Apache-2.0

// Work that is ended by its caller.

#include <gtest/gtest.h>

#include <atomic>

#include "mtf/parallel.h"
#include "mtf/work/stop.h"

namespace {

/// Pieces that run until the flag is set by one of them.
std::int64_t pieces_until_stopped(std::atomic<bool>& flag, int threads, bool nested) {
  std::atomic<std::int64_t> pieces{0};
  const auto piece = [&](std::int64_t, std::int64_t) {
    if (++pieces == 10) flag = true;
  };
  mtf::parallel_for(1000, 1, threads, [&](std::int64_t begin, std::int64_t end) {
    if (nested)
      mtf::parallel_for(10, 1, threads, piece);
    else
      piece(begin, end);
  });
  return pieces;
}

TEST(Stop, LoopsEndAtTheNextPiece) {
  for (const int threads : {1, 2, 4})
    for (const bool nested : {false, true}) {
      std::atomic<bool> flag{false};
      const mtf::StopScope scope(&flag);
      EXPECT_THROW(pieces_until_stopped(flag, threads, nested), mtf::Stopped) << threads << nested;
      EXPECT_THROW(mtf::require_going_on(), mtf::Stopped);
      EXPECT_THROW(mtf::parallel_for(1, 1, threads, [](std::int64_t, std::int64_t) { FAIL(); }), mtf::Stopped);
    }
}

TEST(Stop, WithoutAScopeAllIsDone) {
  std::atomic<bool> flag{false};
  EXPECT_EQ(pieces_until_stopped(flag, 2, false), 1000);
  EXPECT_TRUE(flag);
  EXPECT_NO_THROW(mtf::require_going_on());
}

TEST(Stop, ScopesNestAndEnd) {
  std::atomic<bool> outer{true}, inner{false};
  {
    const mtf::StopScope a(&outer);
    {
      const mtf::StopScope b(&inner);
      EXPECT_EQ(pieces_until_stopped(outer, 2, false), 1000);
    }
    EXPECT_THROW(mtf::require_going_on(), mtf::Stopped);
  }
  EXPECT_EQ(mtf::stop_flag(), nullptr);
}

}  // namespace
