// SPDX-License-Identifier: Apache-2.0

// Fits of a series: exact values, errors that hold for correlated noise, bounds, and what is not separable.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "calib/series/series_fit.h"
#include "mtf/error.h"
#include "tests/expect_error.h"

namespace {

using calib::Knowledge;
using calib::SeriesParameter;

constexpr std::size_t kCount = 240;

SeriesParameter parameter(const std::string& name, double start, double lo, double hi, double scale = 0.0) {
  return {.parameter = {.path = name, .name = name, .unit = "", .min = lo, .max = hi, .prior = {}},
          .start = start,
          .lo = lo,
          .hi = hi,
          .scale = scale};
}

/// A decay to a constant: a exp(-t / b) + c.
std::vector<double> decay(std::span<const double> v) {
  std::vector<double> y;
  for (std::size_t i = 0; i < kCount; ++i) y.push_back(v[0] * std::exp(-static_cast<double>(i) / v[1]) + v[2]);
  return y;
}

const std::vector<double> kTruth{5.0, 40.0, 2.0};

std::vector<SeriesParameter> decay_parameters() {
  return {parameter("a", 3.0, 0.1, 50.0), parameter("b", 20.0, 1.0, 500.0), parameter("c", 0.0, -10.0, 10.0, 1.0)};
}

/// First-order autoregressive noise of a standard deviation.
std::vector<double> with_noise(std::vector<double> y, double sd, double phi, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  double e = normal(random);
  for (double& value : y) {
    value += sd * e;
    e = phi * e + std::sqrt(1.0 - phi * phi) * normal(random);
  }
  return y;
}

TEST(SeriesFit, FindsExactValues) {
  const calib::SeriesFit fit = calib::fit_series({decay(kTruth)}, decay_parameters(), decay, {.threads = 1});
  ASSERT_EQ(fit.status, calib::FitStatus::converged) << fit.reason;
  // The minimum is sought to 1e-5 of the cost of the start; without noise the values are far more exact.
  for (std::size_t i = 0; i < kTruth.size(); ++i) EXPECT_NEAR(fit.parameters[i].value, kTruth[i], 1e-4 * kTruth[i]);
  EXPECT_LT(fit.after.rms, 1e-4);
  EXPECT_GT(fit.before.rms, 1.0);
}

// Errors of correlated noise: z scores have an rms of 1. With 400 draws the rms is known to 3.5 %; phi of a series of
// 240 values is itself known to 10 %, which widens the tails.
TEST(SeriesFit, StatesErrorsThatHold) {
  for (const double phi : {0.0, 0.5, 0.9}) {
    constexpr unsigned kDraws = 400;
    std::array<double, 3> square{};
    double neighbours = 0.0;
    for (unsigned draw = 0; draw < kDraws; ++draw) {
      const calib::SeriesFit fit = calib::fit_series({with_noise(decay(kTruth), 0.1, phi, 1000 + draw)},
                                                     decay_parameters(), decay, {.threads = 1});
      ASSERT_EQ(fit.status, calib::FitStatus::converged);
      for (std::size_t i = 0; i < 3; ++i)
        square[i] += std::pow((fit.parameters[i].value - kTruth[i]) / fit.parameters[i].linear_sd, 2) / kDraws;
      neighbours += fit.phi / kDraws;
    }
    for (const double z2 : square) {
      EXPECT_GT(std::sqrt(z2), 0.85) << phi;
      EXPECT_LT(std::sqrt(z2), 1.2) << phi;
    }
    EXPECT_NEAR(neighbours, phi, 0.04);
  }
}

TEST(SeriesFit, SaysWhatIsAtItsBound) {
  std::vector<SeriesParameter> parameters = decay_parameters();
  parameters[1].parameter.max = 30.0;
  const calib::SeriesFit fit =
      calib::fit_series({with_noise(decay(kTruth), 0.1, 0.0, 7)}, parameters, decay, {.threads = 1});
  ASSERT_TRUE(fit.fitted());
  EXPECT_EQ(fit.parameters[1].knowledge, Knowledge::at_bound);
  EXPECT_EQ(fit.parameters[1].value, 30.0);
  EXPECT_FALSE(fit.parameters[1].limit_is_upper);
  EXPECT_LT(*fit.parameters[1].limit95, 30.0);
  EXPECT_FALSE(fit.parameters[1].stderr_value);
}

TEST(SeriesFit, SaysWhatIsNotSeparable) {
  const auto product = [](std::span<const double> v) { return decay(std::vector{v[0] * v[1], 40.0, v[2]}); };
  const std::vector<SeriesParameter> parameters{parameter("height", 2.0, 0.1, 50.0), parameter("gain", 2.0, 0.1, 50.0),
                                                parameter("c", 0.0, -10.0, 10.0, 1.0)};
  const calib::SeriesFit fit =
      calib::fit_series({with_noise(decay(kTruth), 0.1, 0.0, 8)}, parameters, product, {.threads = 1});
  ASSERT_TRUE(fit.fitted());
  ASSERT_EQ(fit.not_separable.size(), 1U);
  expect_says(fit.not_separable[0].text, {"not separable"});
  EXPECT_EQ(fit.parameters[0].knowledge, Knowledge::not_determined);
  EXPECT_EQ(fit.parameters[1].knowledge, Knowledge::not_determined);
  EXPECT_EQ(fit.parameters[2].knowledge, Knowledge::determined);
  // A prior separates them.
  std::vector<SeriesParameter> held = parameters;
  held[1].parameter.prior = {2.0, 0.02};
  const calib::SeriesFit known =
      calib::fit_series({with_noise(decay(kTruth), 0.1, 0.0, 8)}, held, product, {.threads = 1});
  ASSERT_TRUE(known.fitted());
  EXPECT_EQ(known.parameters[0].knowledge, Knowledge::determined);
  EXPECT_NEAR(known.parameters[0].value, 2.5, 4.0 * known.parameters[0].linear_sd);
  EXPECT_EQ(known.parameters[1].knowledge, Knowledge::prior_only);
}

TEST(SeriesFit, JudgesTheModelByAStatedDeviation) {
  const std::vector<double> noisy = with_noise(decay(kTruth), 0.1, 0.0, 9);
  EXPECT_EQ(calib::fit_series({noisy, 0.1}, decay_parameters(), decay, {.threads = 1}).status,
            calib::FitStatus::converged);
  const calib::SeriesFit wrong = calib::fit_series({noisy, 0.05}, decay_parameters(), decay, {.threads = 1});
  EXPECT_EQ(wrong.status, calib::FitStatus::converged_model_wrong);
  EXPECT_FALSE(wrong.reason.empty());
  // Their errors are those of the residuals all the same.
  EXPECT_NEAR(wrong.chi2_per_dof, 4.0, 1.0);
}

TEST(SeriesFit, LeavesOutWhatIsMissing) {
  std::vector<double> y = decay(kTruth);
  for (std::size_t i = 20; i < 60; ++i) y[i] = std::numeric_limits<double>::quiet_NaN();
  const calib::SeriesFit fit = calib::fit_series({y}, decay_parameters(), decay, {.threads = 1});
  ASSERT_TRUE(fit.fitted());
  EXPECT_EQ(fit.count, kCount - 40);
  EXPECT_NEAR(fit.parameters[1].value, kTruth[1], 1e-3);
}

TEST(SeriesFit, RefusesWhatIsNoFit) {
  EXPECT_THROW(calib::fit_series({decay(kTruth)}, {}, decay), mtf::UsageError);
  EXPECT_THROW(calib::fit_series({{1.0, 2.0}}, decay_parameters(), decay), mtf::UsageError);
  std::vector<SeriesParameter> outside = decay_parameters();
  outside[0].start = 100.0;
  EXPECT_THROW(calib::fit_series({decay(kTruth)}, outside, decay), mtf::UsageError);
  const auto never = [](std::span<const double>) { return std::vector<double>(); };
  EXPECT_THROW(calib::fit_series({decay(kTruth)}, decay_parameters(), never), mtf::UsageError);
}

}  // namespace
