// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "radiometry/stages/noise/fixed_pattern.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"
#include "tests/radiometry/statistics.h"

namespace radiometry {
namespace {

using test::flat;
using test::kMostSigmas;
using test::moments;
using test::samples;

TEST(FixedPattern, maps_have_their_rms_and_are_fixed_by_the_seed) {
  mtf::Image gain = flat(512, 512, 0.0F), offset = flat(512, 512, 7.0F), again = flat(512, 512, 0.0F);
  responsivity_map(gain.view(), {0.02}, 5);
  responsivity_map(again.view(), {0.02}, 5, {}, 2);
  offset_map(offset.view(), 30.0, 5);
  const double n = 512 * 512;
  const auto g = moments(samples(gain)), o = moments(samples(offset));
  EXPECT_LT(std::abs(g.mean - 1.0) * std::sqrt(n) / 0.02, kMostSigmas);
  EXPECT_LT(std::abs(g.variance / 4e-4 - 1.0) * std::sqrt(n / 2), kMostSigmas);
  EXPECT_LT(std::abs(o.mean) * std::sqrt(n) / 30.0, kMostSigmas);
  EXPECT_LT(std::abs(o.variance / 900.0 - 1.0) * std::sqrt(n / 2), kMostSigmas);
  EXPECT_TRUE(std::equal(gain.data(), gain.data() + gain.size(), again.data()));
  EXPECT_LT(std::abs(test::correlation_sigmas(samples(gain), samples(offset))), kMostSigmas);

  mtf::Image part(100, 3);
  responsivity_map(part.view(), {0.02}, 5, {57, 200});
  for (std::int64_t x = 0; x < 100; ++x) ASSERT_EQ(part.at(x, 2), gain.at(57 + x, 202));

  // Rows and columns of their own, the same for any region.
  mtf::Image lines = flat(512, 512, 0.0F);
  responsivity_map(lines.view(), {.row = 0.03, .column = 0.01}, 5);
  std::vector<float> rows, columns;
  for (std::int64_t i = 0; i < 512; ++i) {
    rows.push_back(lines.at(0, i));
    columns.push_back(lines.at(i, 0));
    ASSERT_NEAR(lines.at(i, 7) - lines.at(i, 0), lines.at(0, 7) - lines.at(0, 0), 1e-6F);
  }
  EXPECT_LT(std::abs(moments(std::span<const float>(rows)).variance / 9e-4 - 1.0) * std::sqrt(256.0), kMostSigmas);
  EXPECT_LT(std::abs(moments(std::span<const float>(columns)).variance / 1e-4 - 1.0) * std::sqrt(256.0), kMostSigmas);
  responsivity_map(part.view(), {.row = 0.03, .column = 0.01}, 5, {57, 200});
  for (std::int64_t x = 0; x < 100; ++x) ASSERT_EQ(part.at(x, 2), lines.at(57 + x, 202));

  // The response is never negative, however large the rms.
  responsivity_map(gain.view(), {1.0}, 5);
  EXPECT_GE(*std::min_element(gain.data(), gain.data() + gain.size()), 0.0F);

  mtf::Image image = flat(512, 512, 100.0F);
  multiply_by(image.view(), gain.view());
  add_map(image.view(), offset.view());
  EXPECT_EQ(image.at(3, 4), 100.0F * gain.at(3, 4) + offset.at(3, 4));
}

TEST(FixedPattern, rows_and_columns) {
  mtf::Image image = flat(300, 200, 1.0F);
  add_row_noise(image.view(), 2.0, {1, 3}, Stream::temporal_row);
  for (std::int64_t y = 0; y < 200; ++y)
    for (std::int64_t x = 1; x < 300; ++x) ASSERT_EQ(image.at(x, y), image.at(0, y));
  EXPECT_NE(image.at(0, 0), image.at(0, 1));
  mtf::Image part = flat(10, 20, 1.0F);
  add_row_noise(part.view(), 2.0, {1, 3}, Stream::temporal_row, {5, 101});
  for (std::int64_t y = 0; y < 20; ++y) EXPECT_EQ(part.at(0, y), image.at(0, 101 + y));

  mtf::Image columns = flat(4000, 2, 0.0F);
  add_column_noise(columns.view(), 3.0, {1, 3}, Stream::fixed_column);
  for (std::int64_t x = 0; x < 4000; ++x) ASSERT_EQ(columns.at(x, 0), columns.at(x, 1));
  const auto m = moments(samples(columns).first(4000));
  EXPECT_LT(std::abs(m.variance / 9.0 - 1.0) * std::sqrt(2000.0), kMostSigmas);
}

TEST(Defects, fractions_excess_and_regions) {
  const Defects defects{.dead_fraction = 0.01, .hot_fraction = 0.02, .hot_e = 500.0};
  const auto found = find_defects(1000, 400, defects, 9);
  double dead = 0.0, hot = 0.0, excess = 0.0, squares = 0.0;
  std::map<std::pair<std::int64_t, std::int64_t>, DefectivePixel> by_place;
  for (const DefectivePixel& pixel : found) {
    (pixel.dead ? dead : hot) += 1.0;
    excess += static_cast<double>(pixel.excess_e);
    squares += std::pow(static_cast<double>(pixel.excess_e), 2);
    by_place[{pixel.x, pixel.y}] = pixel;
  }
  EXPECT_LT(std::abs(dead - 4000.0) / std::sqrt(4000.0), kMostSigmas);
  EXPECT_LT(std::abs(hot - 8000.0) / std::sqrt(8000.0), kMostSigmas);
  EXPECT_LT(std::abs(excess / hot - 500.0) / 500.0 * std::sqrt(hot), kMostSigmas);
  EXPECT_LT(std::abs(squares / hot / 5e5 - 1.0) / std::sqrt(5.0) * std::sqrt(hot), kMostSigmas);  // exponential

  std::size_t inside = 0;
  for (const auto& [place, pixel] : by_place) inside += place.first >= 333 && place.first < 533 && place.second >= 77;
  const auto part = find_defects(200, 323, defects, 9, {333, 77});
  EXPECT_EQ(part.size(), inside);
  for (const DefectivePixel& pixel : part) {
    const DefectivePixel& whole = by_place.at({333 + pixel.x, 77 + pixel.y});
    EXPECT_EQ(pixel.dead, whole.dead);
    EXPECT_EQ(pixel.excess_e, whole.excess_e);
  }

  mtf::Image image = flat(1000, 400, 100.0F);
  apply_defects(image.view(), found);
  for (std::int64_t y = 0; y < 400; ++y)
    for (std::int64_t x = 0; x < 1000; ++x) {
      const auto pixel = by_place.find({x, y});
      const float expected = pixel == by_place.end() ? 100.0F
                             : pixel->second.dead    ? 0.0F
                                                     : 100.0F + pixel->second.excess_e;
      ASSERT_EQ(image.at(x, y), expected);
    }
  EXPECT_TRUE(find_defects(1000, 400, {}, 9).empty());
  EXPECT_EQ(find_defects(20, 20, {.dead_fraction = 1.0}, 9).size(), 400U);
}

TEST(FixedPattern, refusals) {
  mtf::Image image = flat(4, 3, 1.0F), other = flat(3, 4, 1.0F);
  expect_refused({"1.5 rms", "0 to 1"}, [&] { responsivity_map(image.view(), {1.5}, 1); });
  expect_refused({"-1 rms"}, [&] { offset_map(image.view(), -1.0, 1); });
  expect_refused({"map of 3 x 4", "image of 4 x 3"}, [&] { multiply_by(image.view(), other.view()); });
  expect_refused({"map of 3 x 4"}, [&] { add_map(image.view(), other.view()); });
  expect_refused({"row noise of nan"}, [&] { add_row_noise(image.view(), std::nan(""), {}, Stream::temporal_row); });
  expect_refused({"defects.dead_fraction = 1.5"}, [] { find_defects(4, 4, {.dead_fraction = 1.5}, 1); });
  expect_refused({"more than all pixels"}, [] { find_defects(4, 4, {.dead_fraction = 0.6, .hot_fraction = 0.6}, 1); });
  const DefectivePixel outside{.x = 4, .y = 0};
  expect_refused({"pixel 4, 0", "4 x 3"}, [&] { apply_defects(image.view(), {&outside, 1}); });
}

}  // namespace
}  // namespace radiometry
