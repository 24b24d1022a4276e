// SPDX-License-Identifier: Apache-2.0
// Bounds at which the effect of a parameter vanishes with its derivative: what is stated of it and of its partners
// holds the truth, and what cannot be stated is said not to be.
#include <gtest/gtest.h>

#include <utility>

#include "tests/calib/fit_cases.h"
#include "tests/calib/flat_study.h"

namespace calib {
namespace {

using flat_study::Case;
using flat_study::Held;
using flat_study::Outcome;

/// Of every parameter, in so many of a hundred draws.
void expect_held(const Case& one, int draws, int least_percent) {
  const Outcome outcome = flat_study::run(one, draws, 20261123);
  std::string line = one.name + ": at bound " + std::to_string(outcome.at_bound);
  for (const Held& held : outcome.parameters) {
    line += ", inside " + std::to_string(held.inside) + " silent " + std::to_string(held.silent) + " unbounded " +
            std::to_string(held.unbounded) + " width " + std::to_string(held.width);
    EXPECT_GE(100 * held.inside, least_percent * draws) << one.name;
  }
  std::printf("%s, MTF50 inside %d of %d, %.1f ms\n", line.c_str(), outcome.inside_mtf50, draws, outcome.ms);
  EXPECT_EQ(outcome.failed, 0) << one.name;
}

// Few draws: 80 of 100 is what 95 of 100 seldom fall below.
TEST(FitFlat, APartnerOfAVanishedDiffusionHoldsTheTruth) { expect_held(flat_study::diffusion(2.0), 12, 80); }

TEST(FitFlatLong, Diffusion) {
  for (const double um : {0.0, 0.5, 1.0, 2.0, 3.0}) expect_held(flat_study::diffusion(um), 100, 90);
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

TEST(FitFlat, AParameterThatActsInProportionIsLeftAlone) {
  // A jitter that may be 0 is fitted as its square: its standard error stands, and there is no profile.
  const FitResult result = one_fit(flat_study::lens_and_jitter(1.5));
  for (const FittedParameter& p : result.parameters) {
    EXPECT_FALSE(p.interval.has_value()) << p.parameter.path;
    EXPECT_FALSE(p.interval95.has_value()) << p.parameter.path;
  }
}

}  // namespace
}  // namespace calib
