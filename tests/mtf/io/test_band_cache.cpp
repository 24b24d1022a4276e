// SPDX-License-Identifier: Apache-2.0
// Bands that several readers share.
#include "mtf/io/exr/band_cache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

namespace {

using mtf::Image;
using mtf::io::Band;
using mtf::io::BandCache;
using Pinned = BandCache::Pinned;

// Bands of one sample, their number, and how often each was decoded.
class Bands : public testing::Test {
 protected:
  BandCache cache(std::int64_t kept) {
    return {kCount, kept, [this](std::int64_t index, Band& band) {
              if (index == broken) throw std::runtime_error("broken");
              ++decoded[static_cast<std::size_t>(index)];
              const int now = ++at_once;
              for (int most = most_at_once; now > most && !most_at_once.compare_exchange_weak(most, now);) continue;
              std::this_thread::sleep_for(std::chrono::milliseconds(1));
              if (band.empty()) {
                band.emplace_back(1, 1);
                ++fresh;
              }
              band[0].at(0, 0) = static_cast<float>(index);
              --at_once;
            }};
  }
  static void expect_right(const Pinned& pinned, std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i <= last; ++i) ASSERT_EQ(pinned[i][0].at(0, 0), static_cast<float>(i));
  }
  // What the threads of a run do: the same ranges, a row of tiles after the other.
  void read_down(BandCache& bands, std::int64_t length, std::int64_t step, int threads) {
    std::vector<std::thread> readers;
    for (int t = 0; t < threads; ++t)
      readers.emplace_back([&] {
        for (std::int64_t first = 0; first + length <= kCount; first += step) {
          const Pinned pinned(bands, first, first + length - 1);
          expect_right(pinned, first, first + length - 1);
        }
      });
    for (std::thread& reader : readers) reader.join();
  }
  static constexpr std::int64_t kCount = 64;
  std::array<std::atomic<int>, kCount> decoded{};
  std::atomic<int> at_once = 0, most_at_once = 0, fresh = 0;
  std::atomic<std::int64_t> broken = -1;
};

TEST_F(Bands, AreDecodedOnceInMemoryThatIsUsedAgain) {
  BandCache bands = cache(12);
  for (std::int64_t first = 0; first + 12 <= kCount; first += 10)
    for (int tile = 0; tile < 5; ++tile) expect_right(Pinned(bands, first, first + 11), first, first + 11);
  EXPECT_EQ(*std::max_element(decoded.begin(), decoded.end()), 1);
  EXPECT_EQ(fresh, 12);
}

TEST_F(Bands, AreSharedByReadersThatDecodeTogether) {
  BandCache bands = cache(16);
  std::vector<std::thread> readers;
  for (int t = 0; t < 4; ++t) readers.emplace_back([&] { expect_right(Pinned(bands, 0, 15), 0, 15); });
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(std::count(decoded.begin(), decoded.end(), 1), 16);
  EXPECT_GT(most_at_once, 1);
}

TEST_F(Bands, StayWithinWhatIsKept) {
  BandCache bands = cache(16);
  read_down(bands, 12, 4, 3);
  EXPECT_LE(fresh, 16);
  bands.keep(4);
  fresh = 0;
  read_down(bands, 4, 4, 3);
  EXPECT_EQ(fresh, 0);  // in the memory of those that were kept
}

TEST_F(Bands, ARangeLongerThanWhatIsKeptIsHeldWhole) {
  BandCache bands = cache(4);
  expect_right(Pinned(bands, 3, 20), 3, 20);
  read_down(bands, 10, 10, 2);
}

TEST_F(Bands, AFailureReachesEveryReaderAndIsTriedAgain) {
  BandCache bands = cache(8);
  broken = 5;
  std::atomic<int> failed = 0;
  std::vector<std::thread> readers;
  for (int t = 0; t < 3; ++t)
    readers.emplace_back([&] {
      try {
        const Pinned pinned(bands, 0, 7);
      } catch (const std::runtime_error&) {
        ++failed;
      }
    });
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(failed, 3);
  broken = -1;
  expect_right(Pinned(bands, 0, 7), 0, 7);
}

}  // namespace
