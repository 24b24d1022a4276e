// SPDX-License-Identifier: Apache-2.0
#include "mtf/grid.h"

#include <gtest/gtest.h>

#include <string>

#include "mtf/border.h"

namespace mtf::test {
namespace {

TEST(FrequencyAxis, even_canvas_has_its_highest_frequency_twice) {
  const FrequencyAxis axis{Basis::fourier, 8, 5.0};
  EXPECT_DOUBLE_EQ(axis.period_um(), 40.0);
  EXPECT_DOUBLE_EQ(axis.cy_mm(1), 25.0);
  EXPECT_DOUBLE_EQ(axis.nyquist_cy_mm(), 100.0);
  EXPECT_EQ(axis.half_frequencies(), (std::vector<double>{0, 25, 50, 75, 100}));
  EXPECT_EQ(axis.all_frequencies(), (std::vector<double>{0, 25, 50, 75, 100, -75, -50, -25, -100}));
}

TEST(FrequencyAxis, odd_canvas_ends_below_the_nyquist_frequency) {
  const FrequencyAxis axis{Basis::fourier, 5, 10.0};
  EXPECT_EQ(axis.half_frequencies(), (std::vector<double>{0, 20, 40}));
  EXPECT_EQ(axis.all_frequencies(), (std::vector<double>{0, 20, 40, -40, -20}));
}

TEST(FrequencyAxis, cosines_are_half_as_far_apart) {
  const FrequencyAxis axis{Basis::cosine, 4, 10.0};
  EXPECT_DOUBLE_EQ(axis.period_um(), 80.0);
  EXPECT_EQ(axis.half_count(), 4);
  EXPECT_EQ(axis.all_frequencies(), (std::vector<double>{0, 12.5, 25, 37.5}));
}

TEST(FrequencyAxis, one_sample_has_one_frequency) {
  for (const Basis basis : {Basis::fourier, Basis::cosine})
    EXPECT_EQ((FrequencyAxis{basis, 1, 3.0}.all_frequencies()), std::vector<double>{0.0});
}

TEST(SmoothLength, is_the_least_product_of_2_3_5_7) {
  EXPECT_EQ(next_smooth(1), 1);
  EXPECT_EQ(next_smooth(11), 12);
  EXPECT_EQ(next_smooth(127), 128);
  EXPECT_EQ(next_smooth(211), 216);
  for (std::int64_t n = 1; n < 3000; ++n) {
    const std::int64_t m = next_smooth(n);
    EXPECT_TRUE(is_smooth(m));
    for (std::int64_t k = n; k < m; ++k) {
      std::int64_t rest = k;
      for (const std::int64_t p : {2, 3, 5, 7})
        while (rest % p == 0) rest /= p;
      ASSERT_GT(rest, 1) << k << " was passed over";
    }
  }
}

std::string canvas(Border border, std::int64_t n, std::int64_t from, std::int64_t to) {
  std::string text;
  for (std::int64_t i = from; i < to; ++i) {
    const std::int64_t s = border_source(border, i, n);
    text += s < 0 ? '.' : static_cast<char>('a' + s);
  }
  return text;
}

TEST(Border, continues_the_image_as_its_name_says) {
  EXPECT_EQ(canvas(Border::reflect, 4, -4, 8), "dcbaabcddcba");
  EXPECT_EQ(canvas(Border::replicate, 4, -4, 8), "aaaaabcddddd");
  EXPECT_EQ(canvas(Border::constant, 4, -4, 8), "....abcd....");
  EXPECT_EQ(canvas(Border::periodic, 4, -4, 8), "abcdabcdabcd");
  EXPECT_EQ(canvas(Border::reflect, 1, -2, 3), "aaaaa");
  EXPECT_EQ(canvas(Border::replicate, 1, -1, 2), "aaa");
}

TEST(Border, canvas_repeats_with_its_length) {
  for (const Border border : {Border::reflect, Border::replicate, Border::constant, Border::periodic})
    for (const std::int64_t n : {1, 2, 3, 7})
      for (std::int64_t i = -5 * n; i < 5 * n; ++i)
        ASSERT_EQ(border_source(border, i, n), border_source(border, i + canvas_length(border, n), n));
}

}  // namespace
}  // namespace mtf::test
