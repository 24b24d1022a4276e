// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "radiometry/stages/noise/noise_lanes.h"
#include "radiometry/stages/noise/random.h"

namespace radiometry {
namespace {

// The vectors published with the generator (Random123, kat_vectors).
TEST(Philox, known_answers) {
  EXPECT_EQ(philox({0, 0, 0, 0}, 0), (Bits128{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, 0xffffffffffffffff),
            (Bits128{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, 0x299f31d0a4093822),
            (Bits128{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

// The loop over lanes gives the words of one pair after another, up to the last column that there is.
TEST(Philox, lanes_are_those_of_single_pairs) {
  const RandomRow row{{0x299f31d0a4093822, 0xffffffff}, Stream::read, 0xfffffffe};
  for (const std::uint32_t first : {0U, 1U, 0x7fffffffU, 0U - static_cast<std::uint32_t>(kPairs)}) {
    Words words;
    philox_lanes(row, first, words);
    for (int i = 0; i < kPairs; ++i)
      EXPECT_EQ((Bits128{words.w[0][i], words.w[1][i], words.w[2][i], words.w[3][i]}),
                row.pair(first + static_cast<std::uint32_t>(i)))
          << first << " + " << i;
  }
}

TEST(Uniform, keeps_both_ends) {
  for (const auto& [high, low] : {std::pair{0U, 0U}, {0xffffffffU, 0xffffffffU}, {0x80000000U, 0U}, {7U, 12345U}}) {
    const Uniform u = uniform(high, low);
    EXPECT_GT(u.u, 0.0);
    EXPECT_GT(u.rest, 0.0);
    EXPECT_NEAR(u.u + u.rest, 1.0, 1e-16);
  }
  EXPECT_EQ(uniform(0, 0).u, 0x1p-63);
  EXPECT_EQ(uniform(0xffffffff, 0xffffffff).rest, 0x1p-63);
}

TEST(Uniform, every_part_of_the_key_matters) {
  const RandomRow row{{1, 2}, Stream::shot, 3};
  const double u = uniform_at(row, 10).u;
  EXPECT_EQ(uniform_at(row, 10).u, u);
  EXPECT_NE(uniform_at(row, 11).u, u);
  EXPECT_NE(uniform_at({{1, 2}, Stream::shot, 4}, 10).u, u);
  EXPECT_NE(uniform_at({{1, 3}, Stream::shot, 3}, 10).u, u);
  EXPECT_NE(uniform_at({{std::uint64_t{1} << 32, 2}, Stream::shot, 3}, 10).u, u);
  EXPECT_NE(uniform_at({{1, 2}, Stream::read, 3}, 10).u, u);
}

}  // namespace
}  // namespace radiometry
