// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "radiometry/stages/detector/microscan.h"
#include "radiometry/stages/noise/noise.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"

namespace radiometry {
namespace {

using test::flat;

std::vector<mtf::Image> frames_of(const mtf::Image& fine, const Microscan& microscan) {
  std::vector<mtf::Image> frames;
  for (int k = 0; k < microscan.positions(); ++k) frames.push_back(microscan_frame(fine.view(), microscan, k));
  return frames;
}

TEST(Microscan, taken_apart_and_put_together) {
  for (const int steps : {1, 2, 3, 16}) {
    mtf::Image fine = flat(steps * 11, steps * 7, 0.0F);
    add_gaussian(fine.view(), 1.0, {2, 0}, Stream::read);
    const Microscan microscan{.steps = steps};
    const auto frames = frames_of(fine, microscan);
    ASSERT_EQ(frames.size(), static_cast<std::size_t>(steps * steps));
    const mtf::Image again = microscan_interlace(frames, microscan);
    ASSERT_EQ(again.size(), fine.size());
    EXPECT_TRUE(std::equal(fine.data(), fine.data() + fine.size(), again.data()));
    EXPECT_EQ(frames.back().at(3, 2), fine.at(3 * steps + steps - 1, 2 * steps + steps - 1));
    EXPECT_EQ(frames[static_cast<std::size_t>(steps - 1)].at(3, 2), fine.at(3 * steps + steps - 1, 2 * steps));
  }
}

// A plane comes back between the positions too, but at the edges, where a neighbour is missing on one side.
TEST(Microscan, diagonal) {
  const Microscan microscan{.pattern = MicroscanPattern::diagonal};
  mtf::Image fine(14, 10);
  for (std::int64_t y = 0; y < 10; ++y)
    for (std::int64_t x = 0; x < 14; ++x) fine.at(x, y) = static_cast<float>(100 + 3 * x - 5 * y);
  const auto frames = frames_of(fine, microscan);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[1].at(2, 1), fine.at(5, 3));
  const mtf::Image again = microscan_interlace(frames, microscan);
  for (std::int64_t y = 0; y < 10; ++y)
    for (std::int64_t x = 0; x < 14; ++x)
      if ((x + y) % 2 == 0 || (x > 0 && y > 0 && x < 13 && y < 9)) {
        ASSERT_EQ(again.at(x, y), fine.at(x, y));
      }
  EXPECT_FLOAT_EQ(again.at(1, 0), (fine.at(0, 0) + fine.at(2, 0) + fine.at(1, 1)) / 3.0F);
  // One cell.
  std::vector<mtf::Image> single;
  single.push_back(flat(1, 1, 2.0F));
  single.push_back(flat(1, 1, 4.0F));
  const mtf::Image cell = microscan_interlace(single, microscan);
  EXPECT_EQ(cell.at(0, 0), 2.0F);
  EXPECT_EQ(cell.at(1, 1), 4.0F);
  EXPECT_EQ(cell.at(1, 0), 3.0F);
  EXPECT_EQ(cell.at(0, 1), 3.0F);
}

TEST(Microscan, every_frame_of_the_detector_has_its_own_noise) {
  const Microscan square{.steps = 2};
  EXPECT_EQ(microscan_key({5, 0}, square, 3).frame, 3U);
  EXPECT_EQ(microscan_key({5, 1}, square, 0).frame, 4U);
  EXPECT_EQ(microscan_key({5, 7}, square, 2).frame, 30U);
  EXPECT_EQ(microscan_key({5, 7}, square, 2).seed, 5U);
  EXPECT_EQ(microscan_key({5, 7}, {.pattern = MicroscanPattern::diagonal}, 1).frame, 15U);
  expect_refused({"2^32"}, [&] { microscan_key({5, 0xffffffffU}, square, 0); });
}

TEST(Microscan, refusals) {
  const mtf::Image fine = flat(9, 8, 1.0F);
  expect_refused({"9 x 8", "2 x 2", "crop"}, [&] { microscan_frame(fine.view(), {}, 0); });
  expect_refused({"position 4 of 4"}, [&] { microscan_frame(fine.view(), {}, 4); });
  expect_refused({"position -1"}, [&] { microscan_frame(fine.view(), {}, -1); });
  expect_refused({"microscan.steps = 0"}, [&] { microscan_frame(fine.view(), {.steps = 0}, 0); });
  expect_refused({"steps = 3", "diagonal"},
                 [&] { microscan_frame(fine.view(), {.steps = 3, .pattern = MicroscanPattern::diagonal}, 0); });
  const mtf::Image none;
  expect_refused({"0 x 0"}, [&] { microscan_frame(none.view(), {}, 0); });
  std::vector<mtf::Image> frames;
  frames.push_back(flat(4, 3, 1.0F));
  expect_refused({"1 frames for 4"}, [&] { microscan_interlace(frames, {}); });
  frames.push_back(flat(3, 4, 1.0F));
  expect_refused({"4 x 3", "3 x 4"}, [&] { microscan_interlace(frames, {.pattern = MicroscanPattern::diagonal}); });
}

}  // namespace
}  // namespace radiometry
