// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "radiometry/stages/detector/adc.h"
#include "radiometry/stages/noise/noise.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"
#include "tests/radiometry/statistics.h"

namespace radiometry {
namespace {

using test::flat;
using test::samples;

constexpr float kInf = std::numeric_limits<float>::infinity();

std::vector<std::uint32_t> counts_of(std::vector<float> electrons, const Adc& adc) {
  std::vector<std::uint32_t> counts(electrons.size());
  const auto n = static_cast<std::int64_t>(electrons.size());
  digitise_to({electrons.data(), n, 1, n}, adc, {counts.data(), n, 1, n});
  return counts;
}

TEST(Adc, rounds_to_the_nearest_count) {
  const Adc adc{.electrons_per_count = 10.0, .offset_counts = 3.0, .bits = 8};
  EXPECT_EQ(counts_of({0, 4.9F, 5, 14.9F, 15, 1000, -34, -36, 2520, 2530, 1e9F}, adc),
            (std::vector<std::uint32_t>{3, 3, 4, 4, 5, 103, 0, 0, 255, 255, 255}));
  const Adc down{.electrons_per_count = 10.0, .bits = 8, .rounding = Rounding::down};
  EXPECT_EQ(counts_of({0, 9.9F, 10, 19.9F}, down), (std::vector<std::uint32_t>{0, 0, 1, 1}));
}

// The largest count, 1 to 32 bits: the full well gives it exactly, nothing gives more, and the counts rise with the
// electrons.
TEST(Adc, one_to_32_bits_and_wells_of_1_and_1e12) {
  for (int bits = 1; bits <= 32; ++bits)
    for (const double well : {1.0, 7e6, 1e12}) {
      const Adc adc = adc_for_well(well, bits);
      const auto most = static_cast<std::uint32_t>((std::uint64_t{1} << bits) - 1);
      std::vector<float> electrons{-1e30F, 0.0F};
      for (double e = 1e-6 * well; e < 1e3 * well; e *= 1.7) electrons.push_back(static_cast<float>(e));
      electrons.push_back(kInf);
      const std::vector<std::uint32_t> counts = counts_of(electrons, adc);
      EXPECT_EQ(counts.front(), 0U);
      EXPECT_EQ(counts.back(), most);
      for (std::size_t i = 1; i < counts.size(); ++i) ASSERT_GE(counts[i], counts[i - 1]) << bits << " " << well;
      EXPECT_GE(counts_of({static_cast<float>(well)}, adc)[0], most - most / (1U << 23)) << bits;

      mtf::Image image = flat(static_cast<std::int64_t>(electrons.size()), 1, 0.0F);
      std::copy(electrons.begin(), electrons.end(), image.data());
      const Clipped clipped = digitise(image.view(), adc);
      EXPECT_EQ(clipped.low, 1);
      EXPECT_GE(clipped.high, 2);
      for (std::size_t i = 0; i < counts.size(); ++i) ASSERT_EQ(image.data()[i], static_cast<float>(counts[i]));
    }
}

TEST(Adc, rounding_noise_is_a_step_over_root_12) {
  mtf::Image image = flat(512, 512, 1e4F);
  add_gaussian(image.view(), 500.0, {1, 0}, Stream::read);
  const mtf::Image electrons = image.clone();
  const Adc adc{.electrons_per_count = 100.0, .bits = 12};
  digitise(image.view(), adc);
  for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] = image.data()[i] * 100.0F - electrons.data()[i];
  const auto m = test::moments(samples(image));
  EXPECT_NEAR(m.mean, 0.0, test::kMostSigmas * 28.9 / 512);
  EXPECT_NEAR(std::sqrt(m.variance), 100.0 / std::sqrt(12.0), 0.1);
}

TEST(Adc, nan_stays_in_floats_and_is_0_in_integers) {
  mtf::Image image = flat(2, 1, std::nanf(""));
  const Clipped clipped = digitise(image.view(), {});
  EXPECT_TRUE(std::isnan(image.at(0, 0)));
  EXPECT_EQ(clipped.low + clipped.high, 0);
  EXPECT_EQ(counts_of({std::nanf("")}, {})[0], 0U);
}

TEST(Adc, the_same_for_any_threads) {
  mtf::Image one = flat(333, 77, 100.0F), two = flat(333, 77, 100.0F);
  for (mtf::Image* image : {&one, &two}) add_gaussian(image->view(), 90.0, {1, 0}, Stream::read);
  const Clipped a = digitise(one.view(), {.electrons_per_count = 1.5, .bits = 7}, 1);
  const Clipped b = digitise(two.view(), {.electrons_per_count = 1.5, .bits = 7}, 2);
  EXPECT_EQ(a.low, b.low);
  EXPECT_EQ(a.high, b.high);
  EXPECT_GT(a.low, 0);
  EXPECT_GT(a.high, 0);
  EXPECT_TRUE(std::equal(one.data(), one.data() + one.size(), two.data()));
}

TEST(Well, holds_what_it_holds) {
  mtf::Image image = flat(3, 1, 5.0F);
  image.at(1, 0) = 50.0F;
  image.at(2, 0) = std::nanf("");
  EXPECT_EQ(fill_well(image.view(), 10.0).high, 1);
  EXPECT_EQ(image.at(0, 0), 5.0F);
  EXPECT_EQ(image.at(1, 0), 10.0F);
  EXPECT_TRUE(std::isnan(image.at(2, 0)));
}

TEST(Adc, refusals) {
  mtf::Image image = flat(2, 2, 1.0F);
  for (const int bits : {0, -1, 33})
    expect_refused({"adc.bits = " + std::to_string(bits), "1 to 32"}, [&] { digitise(image.view(), {.bits = bits}); });
  expect_refused({"electrons_per_count = 0 e-"}, [&] { digitise(image.view(), {.electrons_per_count = 0.0}); });
  expect_refused({"adc.offset = nan"}, [&] { digitise(image.view(), {.offset_counts = std::nan("")}); });
  expect_refused({"electrons_per_count"}, [] { adc_for_well(-5.0, 14); });
  expect_refused({"full well of 0"}, [&] { fill_well(image.view(), 0.0); });
  std::vector<std::uint32_t> counts(2);
  expect_refused({"2 x 2", "2 x 1"}, [&] { digitise_to(image.view(), {}, {counts.data(), 2, 1, 2}); });
}

}  // namespace
}  // namespace radiometry
