// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/statistics.h"

#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

TEST(Statistics, of_a_small_image_by_hand) {
  const Image image = image_of(2, 2, [](auto x, auto y) { return static_cast<double>(x + 2 * y); });  // 0 1 2 3
  const Statistics s = statistics(image.view());
  EXPECT_DOUBLE_EQ(s.mean, 1.5);
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(1.25));
  EXPECT_EQ(s.min, 0.0);
  EXPECT_EQ(s.max, 3.0);
  EXPECT_EQ(s.not_finite, 0);
  EXPECT_EQ(s.first_x, -1);
}

TEST(Statistics, leaves_out_what_is_not_finite_and_places_the_first) {
  Image image = image_of(5, 4, [](auto x, auto) { return x == 0 ? 1.0 : 3.0; });
  image.at(3, 1) = std::nanf("");
  image.at(1, 2) = -HUGE_VALF;
  image.at(4, 3) = HUGE_VALF;
  const Statistics s = statistics(image.view());
  EXPECT_EQ(s.not_finite, 3);
  EXPECT_EQ(s.first_x, 3);
  EXPECT_EQ(s.first_y, 1);
  EXPECT_EQ(s.min, 1.0);
  EXPECT_EQ(s.max, 3.0);
  EXPECT_NEAR(s.mean, (4 * 1.0 + 13 * 3.0) / 17.0, 1e-14);
  EXPECT_NEAR(s.std, std::sqrt(4 * std::pow(1.0 - s.mean, 2) + 13 * std::pow(3.0 - s.mean, 2)) / std::sqrt(17.0),
              1e-14);
}

TEST(Statistics, of_nothing_finite) {
  const Image image = image_of(3, 2, [](auto, auto) { return std::nan(""); });
  const Statistics s = statistics(image.view());
  EXPECT_EQ(s.not_finite, 6);
  EXPECT_EQ(s.mean, 0.0);
  EXPECT_EQ(s.std, 0.0);
}

TEST(Statistics, hold_at_any_scale) {
  for (const double scale : {1e-44, 1e-30, 1.0, 1e30, 1e38}) {
    const Image image = image_of(64, 64, [&](auto x, auto) { return x % 2 == 0 ? scale : -scale; });
    const double value = std::abs(image.at(0, 0));  // as float holds it
    EXPECT_NEAR(statistics(image.view()).std / value, 1.0, 1e-14) << scale;
  }
  const Image flat = image_of(31, 17, [](auto, auto) { return 0.1; });
  EXPECT_EQ(statistics(flat.view()).std, 0.0);
  EXPECT_EQ(statistics(flat.view()).mean, static_cast<double>(0.1F));
}

TEST(Statistics, canvas_norm_is_the_rms_of_the_continued_image) {
  const Image image = random_image(7, 5, 3, 2.0);
  const double mean = statistics(image.view()).mean, border_value = -4.0;
  for (const Border border : kBorders) {
    double sum = 0.0;
    for (std::int64_t y = 0; y < canvas_length(border, 5); ++y)
      for (std::int64_t x = 0; x < canvas_length(border, 7); ++x) {
        const std::int64_t sx = border_source(border, x, 7), sy = border_source(border, y, 5);
        sum += std::pow((sx < 0 || sy < 0 ? border_value : static_cast<double>(image.at(sx, sy))) - mean, 2);
      }
    EXPECT_NEAR(canvas_norm_of(row_moments(image.view()), image.width(), border, border_value, mean),
                std::sqrt(sum / 35.0), 1e-12);
  }
}

TEST(Statistics, summary_of_a_flat_plane_is_nothing) {
  const Image flat = image_of(9, 9, [](auto, auto) { return 0.1; });
  EXPECT_FALSE(summarise(flat.view(), Border::reflect, 0.0));
  const Image image = image_of(4, 1, [](auto x, auto) { return x == 0 ? -9.0 : 1.0; });
  EXPECT_EQ(summarise(image.view(), Border::reflect, 50.0)->largest, 9.0);
  EXPECT_EQ(summarise(image.view(), Border::constant, 50.0)->largest, 50.0) << "light of the border enters the image";
}

}  // namespace
}  // namespace mtf::test
