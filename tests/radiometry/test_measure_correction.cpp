// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "radiometry/stages/detector/nonlinearity.h"
#include "radiometry/stages/noise/fixed_pattern.h"
#include "radiometry/stages/processing/correction.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"
#include "tests/radiometry/statistics.h"

namespace radiometry {
namespace {

using test::flat;
using test::samples;

constexpr double kWell_e = 1e5;

/// A detector of unlike pixels; `read_e` of noise in each frame, `a2` of nonlinearity.
FlatFrame detector(double read_e, double a2, std::set<std::uint32_t>* numbers = nullptr) {
  return [=](double fill, std::uint32_t frame, mtf::ImageView<float> out) {
    if (numbers != nullptr) {
      EXPECT_TRUE(numbers->insert(frame).second) << frame;
    }
    mtf::Image map(out.width, out.height);
    responsivity_map(map.view(), {0.05}, 6);
    for (std::int64_t y = 0; y < out.height; ++y)
      for (std::int64_t x = 0; x < out.width; ++x) out.at(x, y) = static_cast<float>(fill * kWell_e) * map.at(x, y);
    offset_map(map.view(), 300.0, 6);
    add_map(out, map.view());
    apply_response(out, Response({.a2 = a2}, kWell_e));
    add_gaussian(out, read_e, {6, frame}, Stream::read);
  };
}

double residual_rms(const TwoPoint& correction, const FlatFrame& flat_frame, double fill) {
  mtf::Image image(200, 150);
  flat_frame(fill, 0, image.view());
  correct(image.view(), correction);
  return std::sqrt(test::moments(samples(image)).variance);
}

TEST(MeasuredCorrection, takes_away_what_is_linear) {
  std::set<std::uint32_t> numbers;
  const TwoPoint correction = measure_correction(200, 150, {.frames = 3}, detector(0.0, 0.0, &numbers));
  EXPECT_TRUE(correction.bad.empty());
  EXPECT_EQ(numbers.size(), 6U);
  EXPECT_EQ(*numbers.rbegin(), 0xffffffffU);
  for (const double fill : {0.0, 0.2, 0.5, 0.8, 1.0}) EXPECT_LT(residual_rms(correction, detector(0, 0), fill), 0.05);
}

// The noise of the means stays: (s^2 / n)(w^2 + (1 - w)^2) at a signal of low + w (high - low).
TEST(MeasuredCorrection, leaves_the_noise_of_its_means) {
  const int frames = 16;
  const TwoPoint correction = measure_correction(200, 150, {.frames = frames}, detector(40.0, 0.0));
  for (const double w : {0.0, 0.5, 1.0, 1.25}) {
    const double rms = residual_rms(correction, detector(0.0, 0.0), 0.2 + 0.6 * w);
    const double expected = 40.0 * std::sqrt((w * w + (1.0 - w) * (1.0 - w)) / frames);
    EXPECT_NEAR(rms / expected, 1.0, 4.5 / std::sqrt(2.0 * 200 * 150)) << w;
  }
}

// A response that is not linear leaves a residual between the signals of the flat frames and beyond, none at them.
TEST(MeasuredCorrection, leaves_what_is_not_linear) {
  const FlatFrame bent = detector(0.0, -0.05);
  const TwoPoint correction = measure_correction(200, 150, {.frames = 1}, bent);
  EXPECT_LT(residual_rms(correction, bent, 0.2), 0.05);
  EXPECT_LT(residual_rms(correction, bent, 0.8), 0.05);
  // Of a pixel of responsivity g: g (1 + a2 g u) about g (1 + a2 g 0.2) and g (1 + a2 g 0.8), over the mean slope: the
  // bow a2 g (u - 0.2)(u - 0.8) varies with g, by 0.05 rms.
  const double slope = 1.0 - 0.05 * (0.2 + 0.8), expected = 0.05 * 0.05 * 0.09 * kWell_e / slope;
  EXPECT_NEAR(residual_rms(correction, bent, 0.5) / expected, 1.0, 0.1);
}

TEST(MeasuredCorrection, is_the_same_every_time) {
  const TwoPoint a = measure_correction(30, 20, {}, detector(40.0, 0.0));
  const TwoPoint b = measure_correction(30, 20, {}, detector(40.0, 0.0));
  EXPECT_TRUE(std::equal(a.gain.data(), a.gain.data() + a.gain.size(), b.gain.data()));
  EXPECT_TRUE(std::equal(a.offset.data(), a.offset.data() + a.offset.size(), b.offset.data()));
  const TwoPoint one = measure_correction(1, 1, {}, detector(0.0, 0.0));
  EXPECT_NEAR(one.gain.at(0, 0), 1.0, 1e-6);
}

TEST(MeasuredCorrection, refusals) {
  const FlatFrame flat_frame = detector(0.0, 0.0);
  expect_refused({"low = 0.8", "high = 0.8"}, [&] { measure_correction(4, 3, {.low = 0.8}, flat_frame); });
  expect_refused({"correction.frames = 0"}, [&] { measure_correction(4, 3, {.frames = 0}, flat_frame); });
  expect_refused({"correction.limit = 0"}, [&] { measure_correction(4, 3, {.limit = 0.0}, flat_frame); });
  expect_refused({"detector of 0 x 3"}, [&] { measure_correction(0, 3, {}, flat_frame); });
}

}  // namespace
}  // namespace radiometry
