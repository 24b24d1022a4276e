// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "radiometry/stages/detector/adc.h"
#include "radiometry/stages/detector/blooming.h"
#include "radiometry/stages/noise/noise.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"

namespace radiometry {
namespace {

using test::flat;

double sum_of(const mtf::Image& image) {
  double sum = 0.0;
  for (const float value : test::samples(image)) sum += static_cast<double>(value);
  return sum;
}

mtf::Image column(const std::vector<float>& values) {
  mtf::Image image(1, static_cast<std::int64_t>(values.size()));
  std::copy(values.begin(), values.end(), image.data());
  return image;
}

/// Most pixels below the well of 1000, some far above.
mtf::Image bright(std::int64_t width, std::int64_t height) {
  mtf::Image image = flat(width, height, 600.0F);
  add_gaussian(image.view(), 200.0, {3, 0}, Stream::read);
  for (std::int64_t i = 0; i < image.size(); i += 37) image.data()[i] = static_cast<float>(1500 + 40 * (i % 91));
  return image;
}

TEST(Blooming, one_bright_pixel_fills_its_neighbours_evenly) {
  mtf::Image image = column({0, 0, 0, 0, 500, 0, 0, 0, 0});
  EXPECT_EQ(bloom(image.view(), {}, 100.0).left_e, 0.0);
  const std::vector<float> expected{0, 0, 100, 100, 100, 100, 100, 0, 0};
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), image.data()));

  // Half of the excess goes in either direction; at the edge it leaves.
  mtf::Image edge = column({300, 0, 0, 0});
  EXPECT_NEAR(bloom(edge.view(), {}, 100.0).left_e, 100.0, 1e-12);
  const std::vector<float> of_edge{100, 100, 0, 0};
  EXPECT_TRUE(std::equal(of_edge.begin(), of_edge.end(), edge.data()));

  // Charge from two pixels that meets at one well shares it.
  mtf::Image two = column({0, 0, 180, 0, 180, 0, 0});
  bloom(two.view(), {}, 100.0);
  const std::vector<float> of_two{0, 40, 100, 80, 100, 40, 0};
  for (std::size_t i = 0; i < of_two.size(); ++i) EXPECT_FLOAT_EQ(two.data()[i], of_two[i]);
}

TEST(Blooming, charge_is_conserved_but_for_drain_and_edges) {
  for (const BloomingDirection direction :
       {BloomingDirection::columns, BloomingDirection::rows, BloomingDirection::both})
    for (const double drain : {0.0, 0.3, 1.0}) {
      mtf::Image image = bright(123, 77);
      const double before = sum_of(image);
      double above = 0.0;
      for (const float value : test::samples(image)) above += std::max(0.0, static_cast<double>(value) - 1000.0);
      const Spilled spilled = bloom(image.view(), {direction, drain}, 1000.0, 2);
      EXPECT_NEAR((sum_of(image) + spilled.drained_e + spilled.left_e) / before, 1.0, 1e-8);
      EXPECT_NEAR(spilled.drained_e, drain * above, 1e-8 * above);
      EXPECT_LE(*std::max_element(image.data(), image.data() + image.size()), 1000.0F);
      if (drain == 1.0) {
        mtf::Image filled = bright(123, 77);
        fill_well(filled.view(), 1000.0);
        EXPECT_TRUE(std::equal(image.data(), image.data() + image.size(), filled.data()));
      }
    }
}

TEST(Blooming, has_no_preferred_direction) {
  mtf::Image image = bright(60, 50), turned(60, 50), flipped(50, 60);
  for (std::int64_t y = 0; y < 50; ++y)
    for (std::int64_t x = 0; x < 60; ++x) {
      turned.at(59 - x, 49 - y) = image.at(x, y);
      flipped.at(y, x) = image.at(x, y);
    }
  bloom(image.view(), {}, 1000.0);
  bloom(turned.view(), {}, 1000.0);
  bloom(flipped.view(), {.direction = BloomingDirection::rows}, 1000.0);
  for (std::int64_t y = 0; y < 50; ++y)
    for (std::int64_t x = 0; x < 60; ++x) {
      ASSERT_EQ(turned.at(59 - x, 49 - y), image.at(x, y));
      ASSERT_EQ(flipped.at(y, x), image.at(x, y));
    }
}

TEST(Blooming, extremes) {
  // 1e12 electrons on one pixel of a million: the whole column is full, the rest leaves.
  mtf::Image image = flat(3, 1000000, 1.0F);
  image.at(1, 400000) = 1e12F;
  const Spilled spilled = bloom(image.view(), {}, 1000.0);
  const auto spot = static_cast<double>(1e12F);
  EXPECT_NEAR(spilled.left_e / (spot + 999999.0 - 1e9), 1.0, 1e-12);
  for (std::int64_t y = 0; y < image.height(); ++y) {
    ASSERT_EQ(image.at(0, y), 1.0F);
    ASSERT_EQ(image.at(1, y), 1000.0F);
  }
  for (const double well : {1.0, 0x1p40}) {
    mtf::Image line = column({0, static_cast<float>(3.0 * well), 0, std::nanf(""), 0});
    bloom(line.view(), {}, well);
    EXPECT_EQ(line.at(0, 0), static_cast<float>(well));
    EXPECT_EQ(line.at(0, 2), static_cast<float>(well));
    EXPECT_TRUE(std::isnan(line.at(0, 3)));
    EXPECT_EQ(line.at(0, 4), 0.0F);
  }
  // NaN lets charge pass, infinity fills all.
  mtf::Image line = column({0, 500, std::nanf(""), 0, 0});
  bloom(line.view(), {}, 100.0);
  EXPECT_EQ(line.at(0, 3), 100.0F);
  EXPECT_EQ(line.at(0, 4), 100.0F);
  for (const double drain : {0.0, 0.5, 1.0})
    for (const BloomingDirection direction : {BloomingDirection::columns, BloomingDirection::both}) {
      mtf::Image infinite = column({0, std::numeric_limits<float>::infinity(), 0});
      bloom(infinite.view(), {direction, drain}, 100.0);
      EXPECT_EQ(infinite.at(0, 1), 100.0F);
      EXPECT_EQ(infinite.at(0, 2), drain == 1.0 ? 0.0F : 100.0F);
    }
  mtf::Image one = flat(1, 1, 500.0F);
  EXPECT_EQ(bloom(one.view(), {.direction = BloomingDirection::both}, 100.0).left_e, 400.0);
  EXPECT_EQ(one.at(0, 0), 100.0F);
  mtf::Image endless = flat(2, 2, 500.0F);
  bloom(endless.view(), {}, std::numeric_limits<double>::infinity());
  EXPECT_EQ(endless.at(1, 1), 500.0F);
}

TEST(Blooming, refusals) {
  mtf::Image image = flat(4, 3, 1.0F);
  expect_refused({"blooming.drain = 1.1"}, [&] { bloom(image.view(), {.drain = 1.1}, 100.0); });
  expect_refused({"full well of 0"}, [&] { bloom(image.view(), {}, 0.0); });
  expect_refused({"full well of nan"}, [&] { bloom(image.view(), {}, std::nan("")); });
}

}  // namespace
}  // namespace radiometry
