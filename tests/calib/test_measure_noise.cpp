// SPDX-License-Identifier: Apache-2.0
// Bias, scatter and stated standard deviation over realisations of noise and sub-pixel phase, fixed seeds. The
// tolerances of the short runs allow for the scatter of so few draws; tests/bench/bench_edges.cpp prints the same for
// more cases.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "calib/measure/measure.h"
#include "tests/calib/made_edges.h"

namespace {

struct Bars {
  double sd_percent, bias_percent, rms;
};

struct Moments {
  double sum = 0.0, squares = 0.0, count = 0.0;
  void add(double x) { sum += x, squares += x * x, count += 1.0; }
  double mean() const { return sum / count; }
  double sd() const { return std::sqrt((squares - sum * mean()) / (count - 1.0)); }
};

void expect_within(const made::Step& step, made::Scene scene, int draws, const Bars& bars) {
  const double truth = step.crossing(0.5);
  std::mt19937_64 bits(20);
  std::uniform_real_distribution<double> phase(-0.5, 0.5);
  Moments error, stated, rms;
  for (int draw = 0; draw < draws; ++draw) {
    scene.x = 0.5 * static_cast<double>(scene.width) + phase(bits);
    scene.y = 0.5 * static_cast<double>(scene.height) + phase(bits);
    scene.seed = bits();
    const mtf::Image image = made::make(step, scene);
    const auto found = calib::measure_edge(image.view(), {0, 0, image.width(), image.height()});
    ASSERT_EQ(found.trouble, calib::Trouble::none) << found.reason;
    ASSERT_TRUE(found.mtf50.has_value());
    error.add(100.0 * (found.mtf50->value / truth - 1.0));
    stated.add(100.0 * found.mtf50->sd / truth);
    double squares = 0.0;
    for (std::size_t i = 0; i <= 100; ++i)
      squares += std::pow(found.mtf[i] - std::abs(step.mtf(found.frequency_cy_px[i])), 2);
    rms.add(std::sqrt(squares / 101.0));
  }
  const double few = 1.0 + 2.5 / std::sqrt(2.0 * draws);  // scatter of a standard deviation
  EXPECT_LE(error.sd(), bars.sd_percent * (draws < 200 ? few : 1.0));
  EXPECT_LE(std::abs(error.mean()), bars.bias_percent + (draws < 200 ? 2.5 * error.sd() / std::sqrt(draws) : 0.0));
  EXPECT_LE(rms.mean(), bars.rms);
  EXPECT_NEAR(stated.mean() / error.sd(), 1.0, 0.15 + (few - 1.0));
}

made::Scene scene_of(double cnr, std::int64_t height = 100) {
  made::Scene scene;
  scene.height = height;
  scene.noise_sd = 0.6 / cnr;
  return scene;
}

void run(int draws) {
  const made::Step gaussian = made::Step::gaussian(0.3);
  const made::Step airy = made::camera_step(made::camera_of(8.0), 5.0);
  {
    SCOPED_TRACE("Gaussian");
    expect_within(gaussian, scene_of(60.0), draws, {0.75, 0.2, 4.5e-3});
  }
  {
    SCOPED_TRACE("Gaussian, CNR 12");
    expect_within(gaussian, scene_of(12.0), draws, {3.4, 0.5, 2e-2});
  }
  {
    SCOPED_TRACE("Gaussian, 32 px");
    expect_within(gaussian, scene_of(60.0, 32), draws, {1.3, 0.4, 8e-3});
  }
  {
    SCOPED_TRACE("Gaussian, bent");
    made::Scene scene = scene_of(60.0);
    scene.sagitta_px = 1.5;
    expect_within(gaussian, scene, draws, {0.80, 0.25, 4.5e-3});
  }
  {
    SCOPED_TRACE("Airy");
    expect_within(airy, scene_of(60.0), draws, {1.15, 0.3, 6e-3});
  }
  {
    SCOPED_TRACE("Airy, CNR 12");
    expect_within(airy, scene_of(12.0), draws, {5.0, 1.0, 2.5e-2});
  }
  {
    SCOPED_TRACE("Airy, 32 px");
    expect_within(airy, scene_of(60.0, 32), draws, {1.8, 0.6, 1e-2});
  }
}

}  // namespace

// All pixels of a plateau round alike: its value, and with it the curve, is known no better than that allows.
TEST(MeasureNoise, RoundingIsPartOfTheDeviation) {
  constexpr double kQuantum = 1.0 / 255.0;
  const made::Step step = made::Step::gaussian(0.3);
  std::mt19937_64 bits(5);
  std::uniform_real_distribution<double> part(-0.5, 0.5);
  Moments error, score;
  for (int draw = 0; draw < 60; ++draw) {
    made::Scene scene = scene_of(1e9);
    scene.x = 64.0 + part(bits);
    scene.dark = 0.2 + 0.02 * part(bits);
    scene.bright = 0.8 + 0.02 * part(bits);
    scene.quantum = kQuantum;
    const mtf::Image image = made::make(step, scene);
    const auto found = calib::measure_edge(image.view(), {0, 0, image.width(), image.height()}, {.quantum = kQuantum});
    ASSERT_EQ(found.trouble, calib::Trouble::none) << found.reason;
    const double off = found.mtf50->value - 0.3;
    error.add(100.0 * off / 0.3);
    score.add(off * off / (found.mtf50->sd * found.mtf50->sd));
  }
  EXPECT_LE(error.sd(), 0.4);
  EXPECT_LE(std::abs(error.mean()), 0.2);
  EXPECT_LE(score.mean(), 4.0);
}

// Along the pixels' grid all pixels at one distance round alike, and their errors do not average out.
TEST(MeasureNoise, RoundingAlongTheGridIsPartOfTheDeviation) {
  struct Case {
    double angle_deg, counts, noise;  ///< contrast and noise in steps
    std::int64_t width, height;
  };
  constexpr int kDraws = 100;
  for (const Case& one : {Case{0.0, 60, 0.05, 128, 100}, Case{45.0, 20, 0.1, 128, 100}, Case{90.0, 150, 0.25, 128, 100},
                          Case{45.0, 60, 0.125, 24, 24}, Case{26.565, 60, 0.05, 40, 60}}) {
    SCOPED_TRACE(one.angle_deg);
    const made::Step step = made::camera_step(made::camera_of(8.0), one.angle_deg);
    const double quantum = 0.6 / one.counts;
    std::mt19937_64 bits(6);
    std::uniform_real_distribution<double> part(-0.5, 0.5);
    std::array<int, 3> held{};
    Moments score;
    for (int draw = 0; draw < kDraws; ++draw) {
      made::Scene scene;
      scene.width = one.width;
      scene.height = one.height;
      scene.angle_deg = one.angle_deg;
      scene.x = 0.5 * static_cast<double>(one.width) + part(bits);
      scene.y = 0.5 * static_cast<double>(one.height) + part(bits);
      scene.dark += quantum * part(bits);
      scene.bright += quantum * part(bits);
      scene.noise_sd = one.noise * quantum;
      scene.quantum = quantum;
      scene.seed = bits();
      const mtf::Image image = made::make(step, scene);
      const auto found = calib::measure_edge(image.view(), {0, 0, one.width, one.height}, {.quantum = quantum});
      ASSERT_EQ(found.trouble, calib::Trouble::none) << found.reason;
      for (std::size_t k = 0; k < held.size(); ++k) {
        constexpr std::array<std::size_t, 3> kAt{20, 50, 100};  // 0.1, 0.25, 0.5 cycles/pixel
        const double z = (found.mtf[kAt[k]] - step.mtf(found.frequency_cy_px[kAt[k]])) / found.mtf_sd[kAt[k]];
        held[k] += std::abs(z) < 1.96 ? 1 : 0;
        score.add(z * z);
        EXPECT_LT(std::abs(z), 8.0) << draw;
      }
    }
    for (const int count : held) EXPECT_GE(count, 93);
    EXPECT_LE(std::sqrt(score.mean()), 1.1);
    EXPECT_GE(std::sqrt(score.mean()), 0.4);
  }
}

// The reference step does not describe a lens out of focus, and noise hides that.
TEST(MeasureNoise, AShapeThatTheReferenceLacksIsPartOfTheDeviation) {
  struct Lens {
    double w020, cnr, most_sd;
  };
  constexpr int kDraws = 60;
  for (const auto& [w020, cnr, most_sd] :
       {Lens{1.0, 12.0, 0.035}, {1.0, 60.0, 0.008}, {1.0, 1e12, 0.004}, {0.3, 30.0, 0.027}}) {
    SCOPED_TRACE(std::to_string(w020) + " waves, CNR " + std::to_string(cnr));
    made::Camera camera = made::camera_of(8.0);
    camera.w020 = w020;
    const made::Step step = made::camera_step(camera, 5.0);
    std::mt19937_64 bits(7);
    std::uniform_real_distribution<double> part(-0.5, 0.5);
    std::array<int, 4> held{};
    Moments half;
    for (int draw = 0; draw < kDraws; ++draw) {
      made::Scene scene = scene_of(cnr);
      scene.x = 64.0 + part(bits);
      scene.seed = bits();
      const mtf::Image image = made::make(step, scene);
      const auto found = calib::measure_edge(image.view(), {0, 0, image.width(), image.height()});
      ASSERT_EQ(found.trouble, calib::Trouble::none) << found.reason;
      for (std::size_t k = 0; k < held.size(); ++k) {
        constexpr std::array<std::size_t, 4> kAt{10, 20, 50, 100};  // 0.05, 0.1, 0.25, 0.5 cycles/pixel
        const double off = found.mtf[kAt[k]] - std::abs(step.mtf(found.frequency_cy_px[kAt[k]]));
        held[k] += std::abs(off) < 1.96 * found.mtf_sd[kAt[k]] ? 1 : 0;
      }
      half.add(found.mtf50->sd / found.mtf50->value);
    }
    for (const int count : held) EXPECT_GE(count, kDraws * 9 / 10);
    EXPECT_LT(half.mean(), most_sd);
  }
}

// Blurs that the reference describes pay for that allowance seldom and little, sharp ones nothing.
TEST(MeasureNoise, WhatTheReferenceDescribesIsSeldomWidened) {
  constexpr int kDraws = 100;
  for (const double mtf50 : {0.2, 0.25, 0.3}) {
    SCOPED_TRACE(mtf50);
    const made::Step step = made::Step::gaussian(mtf50);
    std::mt19937_64 bits(8);
    std::uniform_real_distribution<double> part(-0.5, 0.5);
    std::vector<double> wider;
    for (int draw = 0; draw < kDraws; ++draw) {
      made::Scene scene = scene_of(30.0);
      scene.x = 64.0 + part(bits);
      scene.seed = bits();
      const mtf::Image image = made::make(step, scene);
      const auto found = calib::measure_edge(image.view(), {0, 0, image.width(), image.height()});
      ASSERT_EQ(found.trouble, calib::Trouble::none) << found.reason;
      const auto half = static_cast<std::size_t>(std::lround(mtf50 / calib::kCurveStep_cy_px));
      wider.push_back(found.mtf_sd[half] / found.mtf_noise_sd[half]);
    }
    std::sort(wider.begin(), wider.end());
    // 32 % of normal draws lie beyond one standard deviation; 43 of 100 are 2.5 sd of that share more.
    EXPECT_LT(wider[kDraws - 43], mtf50 < 0.3 ? 1.03 : 1.0001);
    EXPECT_LT(wider[kDraws * 95 / 100], mtf50 < 0.3 ? 2.2 : 1.0001);
  }
}

TEST(MeasureNoise, AFewDraws) { run(40); }
TEST(MeasureNoiseLong, TwoHundredDraws) { run(200); }
