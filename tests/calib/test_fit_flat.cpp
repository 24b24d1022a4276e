// SPDX-License-Identifier: Apache-2.0
// Bounds at which the effect of a parameter vanishes with its derivative: the statements of it and of its partners
// hold the truth, and what cannot be stated is reported as such.
#include <gtest/gtest.h>

#include <array>
#include <utility>

#include "tests/calib/fit_cases.h"
#include "tests/calib/flat_study.h"
#include "tests/expect_error.h"

namespace calib {
namespace {

using flat_study::Case;
using flat_study::Held;
using flat_study::Outcome;

constexpr std::uint64_t kSeed = 20261123;

/// Of every parameter, in so many of a hundred draws. Where nothing is stated nothing is held, unless that is allowed.
void expect_held(const Case& one, int draws, int least_percent, std::uint64_t seed = kSeed,
                 bool may_be_silent = false) {
  const Outcome outcome = flat_study::run(one, draws, seed);
  std::string line = one.name + ": at bound " + std::to_string(outcome.at_bound);
  for (const Held& held : outcome.parameters) {
    line += ", inside " + std::to_string(held.inside) + " silent " + std::to_string(held.silent) + " unbounded " +
            std::to_string(held.unbounded) + " width " + std::to_string(held.width);
    const int right = held.inside + (may_be_silent ? held.silent : 0);
    EXPECT_GE(100 * right, least_percent * draws) << one.name << ", seed " << seed;
  }
  std::printf("%s, MTF50 inside %d of %d, %.1f ms\n", line.c_str(), outcome.inside_mtf50, draws, outcome.ms);
  EXPECT_EQ(outcome.failed, 0) << one.name;
}

// Few draws: 80 of 100 is what 95 of 100 seldom fall below.
TEST(FitFlat, APartnerOfAVanishedDiffusionHoldsTheTruth) { expect_held(flat_study::diffusion(2.0), 12, 80); }

// Value +- 1.96 standard errors of a square's root never holds 0: 80 of 100.
TEST(FitFlat, AJitterNearZeroHoldsTheTruth) { expect_held(flat_study::lens_and_jitter(0.5), 30, 90); }

// Two of these three draws end between one and two standard deviations of the square above 0.
TEST(FitFlat, ADefocusAtZeroHoldsTheTruth) { expect_held(flat_study::lens_out_of_focus(0.0), 3, 100, 5); }

constexpr std::array<std::uint64_t, 2> kSeeds{kSeed, 4711};

TEST(FitFlatLong, Diffusion) {
  for (const std::uint64_t seed : kSeeds)
    for (const double um : {0.0, 0.5, 1.0, 2.0, 3.0}) expect_held(flat_study::diffusion(um), 100, 90, seed);
}

TEST(FitFlatLong, Jitter) {
  for (const std::uint64_t seed : kSeeds)
    for (const double um : {0.0, 0.3, 0.5, 0.75, 1.0, 1.5}) expect_held(flat_study::lens_and_jitter(um), 100, 90, seed);
}

TEST(FitFlatLong, Defocus) {
  for (const std::uint64_t seed : kSeeds)
    for (const double waves : {0.0, 0.05, 0.1, 0.15, 0.2, 0.3})
      expect_held(flat_study::lens_out_of_focus(waves), 100, 90, seed);
}

// Most of them are reported as not separable.
TEST(FitFlatLong, SecondFootprint) {
  for (const std::uint64_t seed : kSeeds)
    for (const double um : {0.0, 1.0, 2.0, 3.5}) expect_held(flat_study::two_footprints(um), 100, 90, seed, true);
}

/// One fit of the study's first draw, its start and bounds changed.
FitResult one_fit(const Case& one, const FitOptions& options = {}) {
  Outcome outcome = flat_study::run(one, 1, 20261123, options);
  return std::move(outcome.results.front());
}

TEST(FitFlat, AStartAtTheBoundIsLeft) {
  Case one = flat_study::diffusion(4.0);
  const FitResult off = one_fit(one);
  one.fitted[1].start = 1e-6;
  const FitResult at = one_fit(one);
  for (std::size_t i = 0; i < 2; ++i) {
    // The same minimum: to a twentieth of a standard deviation.
    EXPECT_NEAR(at.parameters[i].value, off.parameters[i].value, 0.05 * off.parameters[i].linear_sd) << i;
    EXPECT_EQ(at.parameters[i].knowledge, off.parameters[i].knowledge) << i;
  }
}

// A diffusion length so large that more of it changes nothing leaves no gradient to start with. Lengths are in
// micrometres, beside a jitter of 2.5.
TEST(FitFlat, AStartBeyondAllEffectFindsTheMinimum) {
  Case one = flat_study::diffusion(4.0);
  const FitResult near = one_fit(one);
  for (const double start : {1e5, 1e6}) {
    one.fitted[1].start = start;
    const FitResult far = one_fit(one);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(far.parameters[i].knowledge, near.parameters[i].knowledge) << start;
      EXPECT_NEAR(far.parameters[i].value, near.parameters[i].value, 0.05 * near.parameters[i].linear_sd) << start;
      EXPECT_NEAR(far.parameters[i].linear_sd, near.parameters[i].linear_sd, 0.01 * near.parameters[i].linear_sd);
    }
    ASSERT_EQ(far.warnings.size(), 1u);
    expect_says(far.warnings[0], {"the fit begins at"});
  }
}

TEST(FitFlat, PartnersAreKnownWhateverTheStartOfWhatIsAtItsBound) {
  Case one = flat_study::diffusion(0.4);
  for (const double start : {3.0, 100.0, 1e6}) {
    one.fitted[1].start = start;
    const FitResult result = one_fit(one);
    EXPECT_EQ(result.parameters[0].knowledge, Knowledge::interval) << start;
    EXPECT_EQ(result.parameters[1].knowledge, Knowledge::at_bound) << start;
    EXPECT_TRUE(result.not_separable.empty()) << start;
  }
}

TEST(FitFlat, ABoundSeventeenStandardDeviationsAwayIsSeen) {
  // Lopsided by a fifth: 3 um + 0.6 um - 0.8 um.
  const Outcome outcome = flat_study::run(flat_study::diffusion(3.0), 4, kSeed);
  for (const FitResult& result : outcome.results) EXPECT_TRUE(result.parameters[1].interval95.has_value());
}

TEST(FitFlat, OneLimitIsStated) {
  // The end of the interval, with and without profiles, at a bound that is flat and at one that is not.
  for (const bool jitter : {false, true}) {
    const Case one = jitter ? flat_study::lens_and_jitter(0.0) : flat_study::diffusion(0.4);
    const FittedParameter plain = one_fit(one).parameters[1];
    FitOptions options;
    options.profile = true;
    const FittedParameter profiled = one_fit(one, options).parameters[1];
    ASSERT_EQ(plain.knowledge, Knowledge::at_bound);
    ASSERT_TRUE(plain.limit95 && profiled.limit95 && profiled.interval95 && profiled.interval);
    EXPECT_EQ(*profiled.limit95, (*profiled.interval95)[1]);
    EXPECT_EQ(*profiled.limit95, profiled.interval->high.value_or(0.0));
    EXPECT_NEAR(*plain.limit95, *profiled.limit95, 0.02 * *profiled.limit95);
  }
}

// A bound that the user gave, 1 to 3 standard deviations away, is no end of an interval.
TEST(FitFlat, ABoundOfTheUsersIsNotStatedAsAnEnd) {
  const FitResult open = one_fit(flat_study::lens_and_jitter(1.5));
  const double value = open.parameters[1].value, sd = open.parameters[1].linear_sd;
  int held = 0;
  for (double away = 1.05; away < 3.0; away += 0.1) {
    Case one = flat_study::lens_and_jitter(1.5);
    one.fitted[1].min = value - away * sd;
    const FittedParameter p = one_fit(one).parameters[1];
    EXPECT_NE(p.knowledge == Knowledge::determined, p.knowledge == Knowledge::interval) << away;
    EXPECT_EQ(p.stderr_value.has_value(), p.knowledge == Knowledge::determined) << away;
    if (p.knowledge != Knowledge::interval) continue;
    ++held;
    ASSERT_TRUE(p.interval && p.interval95) << away;
    EXPECT_FALSE(p.interval->low.has_value()) << away;
    expect_says(p.interval->reason, {"bound it from below"});
    EXPECT_GT(p.interval->high.value_or(0.0), value) << away;
  }
  EXPECT_GT(held, 5);
}

TEST(FitFlat, WhatPressesAgainstABoundLeavesItsPartnersAtTheirMinimum) {
  // The fourth draw wants a negative square: the f-number is that of a fit without a jitter.
  Case both = flat_study::lens_and_jitter(0.0), one = both;
  one.fitted.pop_back();
  const FitResult held = std::move(flat_study::run(both, 4, kSeed).results.back());
  const FitResult alone = std::move(flat_study::run(one, 4, kSeed).results.back());
  ASSERT_EQ(held.parameters[1].knowledge, Knowledge::at_bound);
  EXPECT_NEAR(held.parameters[0].value, alone.parameters[0].value, 0.05 * alone.parameters[0].linear_sd);
  EXPECT_LT(held.parameters[1].pressed_sd, 3.0);
}

TEST(FitFlat, ASecondFootprintIsUndeterminedOrItsIntervalHolds) {
  const Case one = flat_study::two_footprints(0.0);
  const Outcome outcome = flat_study::run(one, 14, kSeed);
  int stated = 0;
  for (const FitResult& result : outcome.results)
    for (std::size_t i = 0; i < 2; ++i) {
      const FittedParameter& p = result.parameters[i];
      EXPECT_FALSE(p.stderr_value.has_value());
      if (p.knowledge == Knowledge::not_determined) continue;
      ++stated;
      ASSERT_TRUE(p.interval95.has_value());
      EXPECT_LE((*p.interval95)[0], one.fitted[i].value + 1e-3);
      EXPECT_GE((*p.interval95)[1], one.fitted[i].value);
    }
  EXPECT_GE(stated, 2);
}

TEST(FitFlat, AParameterThatActsInProportionIsLeftAlone) {
  // A jitter is fitted as its square: well above 0 its standard error stands, and there is no profile.
  const FitResult result = one_fit(flat_study::lens_and_jitter(1.5));
  for (const FittedParameter& p : result.parameters) {
    EXPECT_FALSE(p.interval.has_value()) << p.parameter.path;
    EXPECT_FALSE(p.interval95.has_value()) << p.parameter.path;
  }
}

}  // namespace
}  // namespace calib
