// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "radiometry/stages/noise/noise.h"
#include "radiometry/stages/processing/agc.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"

namespace radiometry {
namespace {

using test::flat;
using test::samples;

mtf::Image ramp() {
  mtf::Image image(100, 10);
  for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] = 1000.0F + static_cast<float>(i);
  return image;
}

TEST(Agc, linear_between_quantiles) {
  mtf::Image image = ramp();
  const ToneCurve curve = tone_curve(image.view(), {.clip = 0.1});
  EXPECT_EQ(curve.low, 1100.0);
  EXPECT_EQ(curve.high, 1899.0);
  apply(image.view(), curve);
  EXPECT_EQ(image.data()[0], 0.0F);
  EXPECT_EQ(image.data()[999], 255.0F);
  EXPECT_NEAR(image.data()[500], 255.0 * 400 / 799, 1e-4);
  const ToneCurve whole = tone_curve(ramp().view(), {.clip = 0.0});
  EXPECT_EQ(whole.low, 1000.0);
  EXPECT_EQ(whole.high, 1999.0);
}

// Without a cap every display level is equally frequent; a small cap gives the line back where all values occur.
TEST(Agc, plateau_goes_from_equal_to_linear) {
  mtf::Image image = flat(256, 256, 0.0F);
  add_gaussian(image.view(), 100.0, {1, 0}, Stream::read);
  mtf::Image equal = image.clone();
  apply(equal.view(),
        tone_curve(equal.view(), {.method = GainMethod::plateau, .clip = 0.0, .plateau = 1.0, .most_level = 256.0}));
  std::vector<double> count(8);
  for (const float level : samples(equal)) ++count[static_cast<std::size_t>(std::min(7.0F, level / 32.0F))];
  for (const double c : count) EXPECT_NEAR(c, 65536 / 8.0, 80.0);

  const AutomaticGain even{.method = GainMethod::plateau, .clip = 0.25, .plateau = 1e-4, .bins = 16};
  const ToneCurve curve = tone_curve(image.view(), even);
  for (std::size_t i = 0; i < curve.level.size(); ++i)
    EXPECT_NEAR(curve.level[i], 255.0 * static_cast<double>(i) / 16.0, 1e-4);
}

TEST(Agc, monotone_and_blind_to_outliers) {
  mtf::Image image = ramp();
  image.data()[0] = 1e30F;
  image.data()[1] = std::nanf("");
  image.data()[2] = std::numeric_limits<float>::infinity();
  for (const GainMethod method : {GainMethod::linear, GainMethod::plateau}) {
    mtf::Image out = image.clone();
    const ToneCurve curve = tone_curve(out.view(), {.method = method, .clip = 0.01});
    EXPECT_LT(curve.high, 2000.0);
    apply(out.view(), curve, 2);
    for (std::int64_t i = 4; i < out.size(); ++i) ASSERT_GE(out.data()[i], out.data()[i - 1]);
    EXPECT_EQ(out.data()[0], 255.0F);
    EXPECT_TRUE(std::isnan(out.data()[1]));
    EXPECT_EQ(out.data()[2], 255.0F);
  }
}

TEST(Agc, one_value_is_the_middle) {
  for (const float value : {0.0F, -3.5F, 1e6F}) {
    mtf::Image image = flat(5, 5, value);
    apply(image.view(), tone_curve(image.view(), {}));
    EXPECT_FLOAT_EQ(image.at(2, 2), 127.5F) << value;
  }
}

TEST(Agc, polarity) {
  mtf::Image image = flat(2, 1, 55.0F);
  invert_polarity(image.view(), 255.0);
  EXPECT_EQ(image.at(1, 0), 200.0F);
}

TEST(Agc, refusals) {
  mtf::Image image = ramp();
  expect_refused({"agc.clip = 0.5"}, [&] { tone_curve(image.view(), {.clip = 0.5}); });
  expect_refused({"agc.bins = 1"}, [&] { tone_curve(image.view(), {.bins = 1}); });
  expect_refused({"agc.plateau = 0"}, [&] { tone_curve(image.view(), {.plateau = 0.0}); });
  const mtf::Image nothing = flat(3, 3, std::nanf(""));
  expect_refused({"without a finite pixel"}, [&] { tone_curve(nothing.view(), {}); });
  expect_refused({"0 levels", "tone_curve"}, [&] { apply(image.view(), ToneCurve{}); });
}

}  // namespace
}  // namespace radiometry
