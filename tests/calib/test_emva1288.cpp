// SPDX-License-Identifier: Apache-2.0

// The numbers of EMVA 1288 against those that numpy finds from the same frames (emva1288_numbers.py), and their
// deviations and biases against the scatter of cameras drawn anew.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "calib/characterize/emva1288.h"
#include "tests/expect_error.h"

namespace calib {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// What emva1288_numbers.py prints.
constexpr std::int64_t kSum = 4101628;
const std::map<std::string, double> kNumpy{{"K", 0.46822258510324327},
                                           {"R", 0.23777815934065935},
                                           {"eta", 50.78314607319277},
                                           {"sigma_y.dark", 2.8331063735552564},
                                           {"sigma_d", 6.0192759386208765},
                                           {"mu_e.min", 6.550768296301972},
                                           {"mu_p.min", 12.899492849183616},
                                           {"mu_p.sat", 4000.0},
                                           {"mu_e.sat", 2031.3258429277105},
                                           {"DR", 310.08971025191516},
                                           {"SNR_max", 45.070232337183604},
                                           {"LE_min", -2.429064210085796},
                                           {"LE_max", 1.6884502723693018},
                                           {"mu_I.mean", 2202.244759377349},
                                           {"mu_I.var", 6349.749183421124},
                                           {"DSNU", 1.7076701231896052},
                                           {"PRNU", 1.0284556376614693},
                                           {"DSNU_row", 1.152684880841905},
                                           {"PRNU_row", kNone},
                                           {"DSNU_column", kNone},
                                           {"PRNU_column", kNone},
                                           {"DSNU_pixel", 1.3208179080950955},
                                           {"PRNU_pixel", 1.0553622639007703}};

/// The frames of emva1288_numbers.py.
class MadeSet {
 public:
  MadeSet() {
    for (std::int64_t& one : pattern_) one = next() % 9 - 4;
    for (int k = 1; k <= 12; ++k) {
      const int signal = 100 * k - k * k;
      for (const int frames : {2, 5}) {
        if (frames == 5 && k != 5) continue;
        add(k, 400.0 * k, 80 + k + signal, 12.0 + signal / 2.0, frames);
        add(k, 0.0, 80 + k, 10.0 + k, frames);
      }
    }
  }
  std::vector<Stack> stacks;
  std::int64_t sum = 0;

 private:
  std::int64_t next() {
    state_ = 6364136223846793005U * state_ + 1442695040888963407U;
    return static_cast<std::int64_t>(state_ >> 56U);
  }
  void add(int time_ms, double light, std::int64_t mean, double variance, int frames) {
    const auto sd = static_cast<std::int64_t>(256.0 * std::sqrt(variance));
    StackStatistics sums(16, 12, {.low = 0.0, .high = 2047.0});
    mtf::Image frame(16, 12);
    for (int t = 0; t < frames; ++t) {
      for (std::size_t i = 0; i < pattern_.size(); ++i) {
        std::int64_t noise = -1530;
        for (int k = 0; k < 12; ++k) noise += next();
        const std::int64_t count = (256 * mean + mean * pattern_[i] + ((sd * noise) >> 8) + 128) >> 8;
        frame.data()[i] = static_cast<float>(std::min<std::int64_t>(count, 1040));
        sum += std::min<std::int64_t>(count, 1040);
      }
      sums.add(frame.view());
    }
    const std::string name = std::to_string(time_ms) + (light > 0.0 ? " ms bright" : " ms dark");
    stacks.push_back({.name = name, .light = light, .time_s = 1e-3 * time_ms, .sums = summary_of(sums)});
  }
  std::uint64_t state_ = 1288;
  std::array<std::int64_t, 12 * 16> pattern_{};
};

TEST(Emva1288, NumbersOfASmallSetAreThoseOfNumpy) {
  MadeSet made;
  ASSERT_EQ(made.sum, kSum);
  const Emva1288 found = emva1288(std::move(made.stacks), {.most_counts = 2047.0, .counts_time = true}, true);
  for (const auto& [name, value] : kNumpy) {
    const EmvaNumber* number = found.find(name);
    ASSERT_NE(number, nullptr) << name;
    EXPECT_EQ(number->finding.verdict == Verdict::not_determined, std::isnan(value)) << name;
    if (std::isnan(value))
      expect_says(number->finding.why, {"negative"});
    else
      EXPECT_NEAR(number->finding.value, value, 1e-11 * std::abs(value)) << name;
  }
  EXPECT_DOUBLE_EQ(found.find("DR_dB")->finding.value, 20.0 * std::log10(found.find("DR")->finding.value));
  EXPECT_EQ(found.frames, "12 levels with light, stacks of two frames");
  EXPECT_EQ(found.patterns, "5 ms bright of 5 frames, 5 ms dark of 5 frames");
}

TEST(Emva1288, WhatTheStacksDoNotTellIsSaid) {
  MadeSet without_darks, few;
  const auto is_dark = [](const Stack& s) { return s.light == 0.0 && s.time_s > 3e-3; };
  std::erase_if(without_darks.stacks, is_dark);
  expect_refused({"4 ms bright", "no dark stack"},
                 [&] { emva1288(std::move(without_darks.stacks), {.counts_time = true}, true); });
  // One exposure, any unit of light, photons unknown.
  for (Stack& s : few.stacks) s.time_s = 0.0;
  const Emva1288 found = emva1288(std::move(few.stacks), {.most_counts = 2047.0}, false);
  for (const char* const name : {"eta", "mu_p.min", "mu_p.sat", "mu_I.mean", "mu_I.var"})
    EXPECT_EQ(found.find(name)->finding.verdict, Verdict::not_determined) << name;
  EXPECT_EQ(found.find("R")->finding.unit, "DN per unit of light");
  EXPECT_GT(found.find("mu_e.sat")->finding.value, 0.0);
}

// A response that bends by 3 % at full well and no other fault, 40 cameras. Stated deviations are the scatter of the
// values within 30 % (2.7 sd of a scatter of 40), the stated bias of K that of their mean within 4.5 sd of it.
TEST(Emva1288, DeviationsAndBiasesAreThoseOfCamerasDrawnAnew) {
  constexpr int kDraws = 40;
  constexpr double kTrueGain = 0.4, kFullWell = 2e4, kTop = 8191.0;
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal;
  std::map<std::string, std::array<double, 4>> sums;  // of values, their squares, deviations, biases
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<double> response(32 * 32);
    for (double& one : response) one = 1.0 + 0.01 * normal(engine);
    std::vector<Stack> stacks;
    const auto add = [&](double electrons, int frames) {
      StackStatistics sum(32, 32, {.low = 0.0, .high = kTop});
      mtf::Image frame(32, 32);
      for (int t = 0; t < frames; ++t) {
        for (std::size_t i = 0; i < response.size(); ++i) {
          double e = electrons > 0.0 ? std::poisson_distribution<int>(electrons * response[i])(engine) : 0.0;
          e *= 1.0 - 0.03 * e / kFullWell;
          frame.data()[i] =
              static_cast<float>(std::clamp(std::floor(100.5 + kTrueGain * (e + 5.0 * normal(engine))), 0.0, kTop));
        }
        sum.add(frame.view());
      }
      stacks.push_back({.name = std::to_string(electrons), .light = 2.0 * electrons, .sums = summary_of(sum)});
    };
    for (int k = 0; k <= 24; ++k) add(900.0 * k, 2);
    add(0.0, 6);
    add(10e3, 6);
    const Emva1288 found = emva1288(std::move(stacks), {.full_well_e = kFullWell, .most_counts = kTop}, true);
    for (const char* const name : {"K", "sigma_d", "LE_min", "PRNU"}) {
      const EmvaNumber& n = *found.find(name);
      auto& [value, squares, sd, bias] = sums[name];
      value += n.finding.value / kDraws;
      squares += n.finding.value * n.finding.value / kDraws;
      sd += n.finding.sd / kDraws;
      bias += n.bias.value_or(0.0) / kDraws;
    }
    expect_says(found.find("K")->note, {"% low", "the response bends (a2)"});
  }
  for (const auto& [name, sum] : sums) {
    const double scatter = std::sqrt(sum[1] - sum[0] * sum[0]);
    EXPECT_NEAR(sum[2], scatter, 0.3 * scatter) << name;
  }
  const auto& [value, squares, sd, bias] = sums["K"];
  EXPECT_NEAR(bias, value / kTrueGain - 1.0, 4.5 * sd / kTrueGain / std::sqrt(kDraws));
  // The line through 0 over u (1 + a2 u) of (1 + 2 a2 u)^2 u up to u is off by 9/4 a2 u to first order.
  EXPECT_NEAR(bias, -2.25 * 0.03 * 0.7, 0.006);
}

}  // namespace
}  // namespace calib
