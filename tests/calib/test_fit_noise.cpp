// SPDX-License-Identifier: Apache-2.0
// The errors that a fit states, against its errors over many draws of noise that neighbouring pixels share.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <random>

#include "calib/fit/confidence/identifiability.h"
#include "calib/fit/data/edge_block.h"
#include "calib/fit/fit_build.h"
#include "calib/fit/fit_rounds.h"
#include "tests/calib/fit_cases.h"
#include "tests/calib/made_defects.h"
#include "tests/expect_error.h"

namespace calib {
namespace {

using fit_cases::data_of;
using fit_cases::parameter;

using Noise = std::function<void(mtf::Image&, const made::Scene&, const made::Step&)>;
void leave(mtf::Image&, const made::Scene&, const made::Step&) {}
void blur_noise(mtf::Image& image, const made::Scene& scene, const made::Step& step) {
  made::correlate_noise(image, scene, step, 0.8);
}

constexpr double kContrast = 0.6;
constexpr double kSlanted_deg = 5.0;
constexpr double kCount = kContrast / 153.0;  // of 8 bits

void blur_and_round_noise(mtf::Image& image, const made::Scene& scene, const made::Step& step) {
  blur_noise(image, scene, step);
  for (std::int64_t i = 0; i < image.size(); ++i)
    image.data()[i] = static_cast<float>(kCount * std::round(image.data()[i] / kCount));
}

struct Model {
  made::Step step;
  mtf::System<double> start;
  std::vector<FitParameter> parameters;
  std::vector<double> truth;
};

Model one_width() {
  return {made::Step::gaussian(0.3),
          fit_cases::gaussian(0.7),
          {parameter("presample[0].sigma")},
          {fit_cases::sigma_of(0.3)}};
}

/// Diffraction and a width of the footprint, both unknown.
Model two_widths() {
  return {made::camera_step(made::camera_of(8.0), 5.0),
          fit_cases::camera(9.0, 0.9),
          {parameter("optics.f_number"), parameter("presample[1].width")},
          {8.0, 1.0}};
}

/// rms of (value - truth) / stated deviation of the parameters, and of the MTF at 0.1 and 0.25 cycles/pixel.
struct Deviations {
  std::vector<double> parameter;
  double low = 0.0, high = 0.0;
  int known = 0, wrong = 0, warned = 0, left_out = 0;  ///< draws
};

Deviations deviations(const Model& model, const Noise& noise, double cnr, int draws, double quantum = 0.0,
                      double angle_deg = kSlanted_deg) {
  Deviations rms{.parameter = std::vector<double>(model.truth.size())};
  std::mt19937_64 bits(11);
  std::uniform_real_distribution<double> phase(-0.5, 0.5);
  const auto at = [](double f) { return static_cast<std::size_t>(std::lround(f / kCurveStep_cy_px)); };
  for (int draw = 0; draw < draws; ++draw) {
    made::Scene scene;
    scene.width = 80, scene.height = 60, scene.half_length_px = 30.0;
    scene.x = 40.0 + phase(bits);
    scene.angle_deg = angle_deg;
    scene.noise_sd = kContrast / cnr;
    if (angle_deg != kSlanted_deg) {  // plateaus at any place between two steps
      scene.dark += quantum * phase(bits);
      scene.bright += quantum * phase(bits);
      scene.quantum = quantum;
    }
    scene.seed = bits();
    mtf::Image image = made::make(model.step, scene);
    noise(image, scene, model.step);
    const Roi all{0, 0, image.width(), image.height()};
    EdgeData edge{.name = "edge",
                  .image = image.view(),
                  .roi = all,
                  .condition = 0,
                  .start = measure_edge(image.view(), all, {.quantum = quantum}),
                  .quantum = quantum};
    FitOptions options;
    options.threads = 1;
    const FitResult result = fit(data_of(model.start, std::move(edge)), model.parameters, options);
    rms.wrong += result.status == FitStatus::converged_model_wrong ? 1 : 0;
    for (const std::string& warning : result.warnings) {
      rms.warned += says(warning, "noise is correlated") ? 1 : 0;
      rms.left_out += warning.find("those of independent pixels") != std::string::npos ? 1 : 0;
    }
    bool known = true;
    for (const FittedParameter& p : result.parameters) known = known && p.stderr_value.has_value();
    if (!known) continue;
    ++rms.known;
    const auto add = [](double& sum, double value, double truth, double sd) {
      sum += (value - truth) * (value - truth) / (sd * sd);
    };
    for (std::size_t i = 0; i < model.truth.size(); ++i)
      add(rms.parameter[i], result.parameters[i].value, model.truth[i], *result.parameters[i].stderr_value);
    add(rms.low, result.mtf[at(0.1)], model.step.mtf(0.1), result.mtf_sd[at(0.1)]);
    add(rms.high, result.mtf[at(0.25)], model.step.mtf(0.25), result.mtf_sd[at(0.25)]);
  }
  const auto root = [&](double& sum) { sum = std::sqrt(sum / rms.known); };
  for (double& sum : rms.parameter) root(sum);
  for (double* sum : {&rms.low, &rms.high}) root(*sum);
  return rms;
}

void expect_stated(const Deviations& rms, int draws) {
  EXPECT_EQ(rms.known, draws);
  EXPECT_LE(rms.wrong, draws / 100);
  std::vector<double> all = rms.parameter;
  all.insert(all.end(), {rms.low, rms.high});
  for (const double one : all) {
    EXPECT_GT(one, 0.9);
    EXPECT_LT(one, 1.1);
  }
}

void expect_errors_of_the_draws(const Noise& noise, bool is_shared) {
  constexpr int kDraws = 250;
  const Deviations rms = deviations(one_width(), noise, 60.0, kDraws);
  expect_stated(rms, kDraws);
  EXPECT_EQ(rms.warned, is_shared ? kDraws : 0);
  EXPECT_EQ(rms.left_out, 0);
}

TEST(FitNoise, ErrorsAreThoseOfTheDraws) {
  expect_errors_of_the_draws(leave, false);
  expect_errors_of_the_draws(blur_noise, true);
}
TEST(FitNoiseLong, ErrorsAreThoseOfTheDraws) {
  expect_errors_of_the_draws(made::interpolate_noise, true);
  expect_errors_of_the_draws(made::compress_noise, true);
}

TEST(FitNoise, SharedNoiseOfHalfACountIsPartOfTheErrors) {
  constexpr int kDraws = 200;
  const Deviations rms = deviations(one_width(), blur_and_round_noise, kContrast / (0.5 * kCount), kDraws, kCount);
  expect_stated(rms, kDraws);
  EXPECT_EQ(rms.warned, kDraws);
}

// Near the limit the estimate of the noise decides whether it counts; one of the two is said in every case.
TEST(FitNoise, SharedNoiseThatRoundingHidesIsAWarning) {
  constexpr int kDraws = 20;
  const Deviations rms = deviations(one_width(), blur_and_round_noise, kContrast / (0.35 * kCount), kDraws, kCount);
  EXPECT_GE(rms.left_out, kDraws / 2);
  EXPECT_EQ(rms.warned + rms.left_out, kDraws);
}

void expect_stated_of_two_widths(const Noise& noise) {
  constexpr int kDraws = 200;
  expect_stated(deviations(two_widths(), noise, 400.0, kDraws), kDraws);
}
TEST(FitNoise, ErrorsOfParametersThatCompensateForEachOther) { expect_stated_of_two_widths(blur_noise); }
TEST(FitNoiseLong, ErrorsOfParametersThatCompensateForEachOther) {
  expect_stated_of_two_widths(made::interpolate_noise);
}

void expect_rounding_in_the_errors(std::initializer_list<double> noises) {
  constexpr int kDraws = 100;
  constexpr double kStep = kContrast / 60.0;
  for (const double angle_deg : {0.0, 45.0, 90.0})
    for (const double noise : noises) {
      SCOPED_TRACE(testing::Message() << angle_deg << " degrees, noise " << noise);
      const Deviations rms = deviations(one_width(), leave, kContrast / (noise * kStep), kDraws, kStep, angle_deg);
      EXPECT_EQ(rms.known, kDraws);
      EXPECT_LE(rms.wrong, kDraws / 10);
      for (const double one : {rms.parameter.front(), rms.low, rms.high}) {
        EXPECT_GT(one, 0.65);
        EXPECT_LT(one, 1.15);
      }
    }
}
TEST(FitNoise, RoundingAlongTheGridIsPartOfTheErrors) { expect_rounding_in_the_errors({0.125}); }
TEST(FitNoiseLong, RoundingAlongTheGridIsPartOfTheErrors) { expect_rounding_in_the_errors({0.05, 0.25}); }

struct OneEdge {
  mtf::Image image;
  FitData data;
};
OneEdge one_edge(const Noise& noise) {
  const Model model = one_width();
  made::Scene scene;
  scene.noise_sd = 0.02;
  scene.seed = 5;
  OneEdge edge{made::make(model.step, scene), {}};
  noise(edge.image, scene, model.step);
  edge.data = data_of(model.start, fit_cases::edge_of(edge.image, scene));
  return edge;
}

TEST(FitNoise, IndependentPixelsKeepTheirErrorsToTheLastBit) {
  const OneEdge edge = one_edge(leave);
  const std::vector<FitParameter> parameters = one_width().parameters;
  FitSetup setup = make_setup(edge.data, parameters, {});
  Solved solved{.problem = &setup.problem};
  minimise(setup.problem, solved, {});
  judge(solved, parameters);
  ASSERT_TRUE(solved.tests.front().noise.white());
  EXPECT_EQ(solved.information.matrix(0, 0), solved.information.independent(0, 0));
  EXPECT_EQ(solved.variance_ratio.front(), 1.0);
  const Eigen::MatrixXd alone =
      project_out(solved.normals.front(), setup.problem.own.front().size(), 1) / solved.noise_factor.front();
  EXPECT_EQ(solved.information.matrix(0, 0), alone(0, 0));
}

TEST(FitNoise, AProfileHasTheSameEndsAsTheStandardError) {
  const OneEdge edge = one_edge(blur_noise);
  FitOptions options;
  options.profile = true;
  const FitResult result = fit(edge.data, one_width().parameters, options);
  const FittedParameter& p = result.parameters.front();
  const double half = 1.96 * p.stderr_value.value();
  EXPECT_NEAR(p.interval95.value()[0], p.value - half, 0.05 * half);
  EXPECT_NEAR(p.interval95.value()[1], p.value + half, 0.05 * half);
}

TEST(FitNoise, LimitsAtABoundAreThoseOfTheProfile) {
  const OneEdge edge = one_edge(blur_noise);
  std::vector<FitParameter> parameters = one_width().parameters;
  const FitResult free = fit(edge.data, parameters);
  const double sd = free.parameters.front().stderr_value.value();
  parameters.front().min = free.parameters.front().value + 1.5 * sd;
  const FittedParameter linear = fit(edge.data, parameters).parameters.front();
  FitOptions options;
  options.profile = true;
  const FittedParameter profile = fit(edge.data, parameters, options).parameters.front();
  EXPECT_EQ(linear.knowledge, Knowledge::at_bound);
  EXPECT_NEAR(linear.pressed_sd, 1.5, 0.1);
  EXPECT_NEAR(linear.limit95.value() - linear.value, profile.limit95.value() - linear.value, 0.05 * sd);
}

TEST(FitNoise, ScoresOfPixelPairsAreThoseOfTheWholeCovariance) {
  // Some pixels of 7 x 6, two unknowns.
  std::vector<PixelPlace> places;
  PixelRows rows(2);
  std::mt19937_64 bits(3);
  std::normal_distribution<double> normal;
  for (std::int32_t y = 0; y < 6; ++y)
    for (std::int32_t x = 0; x < 7; ++x) {
      if ((3 * x + 5 * y) % 4 == 0) continue;
      places.push_back({x, y});
      for (double& value : rows.next()) value = normal(bits);
      rows.add();
    }
  const NoiseCorrelation noise{.lags = {{1, 0, 0.4}, {-1, 1, 0.2}, {0, 1, 0.3}, {2, 2, -0.1}}, .margin = 1.2};
  const auto count = std::ssize(places);
  Eigen::MatrixXd r = Eigen::MatrixXd::Identity(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index k = 0; k < count; ++k)
      for (const PixelLag& lag : noise.lags)
        for (const int sign : {-1, 1}) {
          const PixelPlace &a = places[static_cast<std::size_t>(i)], &b = places[static_cast<std::size_t>(k)];
          if (b.x - a.x == sign * lag.x && b.y - a.y == sign * lag.y) r(i, k) = noise.margin * lag.correlation;
        }
  const Eigen::MatrixXd jacobian = rows.jacobian(), whole = jacobian.transpose() * r * jacobian;
  EXPECT_LT((score_covariance(rows, places, noise) - whole).norm(), 1e-12 * whole.norm());
}

TEST(FitNoise, TheSandwichIsNeverNarrowerThanIndependentPixels) {
  const Eigen::MatrixXd information = (Eigen::Matrix2d() << 4.0, 1.0, 1.0, 9.0).finished();
  EXPECT_LT((sandwich_information(information, 4.0 * information) - 0.25 * information).norm(), 1e-8);
  EXPECT_LT((sandwich_information(information, 0.5 * information) - information).norm(), 1e-8);
  // More in one direction only; and a variable of which nothing is known stays so.
  Eigen::MatrixXd scores = information;
  scores(0, 0) += 8.0;
  const Eigen::MatrixXd sandwich = information.inverse() * scores * information.inverse();
  EXPECT_LT((sandwich_information(information, scores).inverse() - sandwich).norm(), 1e-8);
  Eigen::MatrixXd wider = Eigen::MatrixXd::Zero(3, 3);
  wider.topLeftCorner(2, 2) = information;
  EXPECT_EQ(sandwich_information(wider, 4.0 * wider)(2, 2), 0.0);
}

// Photon radiances have values of 1e18. Absolute limits of the solver held back unknowns in such units: the gradients
// of the plateaus were lost, and the blur took their place.
TEST(FitNoise, LargeUnitsOfTheImageDoNotMatter) {
  made::Scene scene;
  scene.gradient_dark = scene.gradient_bright = 5e-4;
  scene.noise_sd = 0.003;
  const mtf::Image image = made::make(made::Step::gaussian(0.21), scene);
  const std::vector<FitParameter> sigma{fit_cases::parameter("presample[0].sigma", "gaussian.sigma")};
  const auto fitted = [&](float unit) {
    mtf::Image scaled = image.clone();
    for (std::int64_t i = 0; i < scaled.size(); ++i) scaled.data()[i] *= unit;
    made::Scene start;
    for (double* value : {&start.dark, &start.bright}) *value *= static_cast<double>(unit);
    return fit(fit_cases::data_of(fit_cases::gaussian(0.5), fit_cases::edge_of(scaled, start)), sigma);
  };
  const FitResult plain = fitted(1.0F), large = fitted(0x1p60F);
  ASSERT_EQ(plain.status, FitStatus::converged);
  EXPECT_EQ(large.status, FitStatus::converged);
  EXPECT_NEAR(large.parameters[0].value, plain.parameters[0].value, 1e-6);
  EXPECT_NEAR(plain.parameters[0].value, fit_cases::sigma_of(0.21), 0.02);
}

}  // namespace
}  // namespace calib
