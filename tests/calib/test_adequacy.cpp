// SPDX-License-Identifier: Apache-2.0
// Wrong models are told from right ones.
#include <gtest/gtest.h>

#include <cmath>

#include "calib/fit/confidence/adequacy.h"
#include "tests/calib/fit_cases.h"
#include "tests/calib/made_defects.h"
#include "tests/expect_error.h"

namespace calib {
namespace {

using fit_cases::data_of;
using fit_cases::edge_of;
using fit_cases::parameter;

made::Scene noisy(std::uint64_t seed, double noise_sd = 0.01) {
  made::Scene scene;
  scene.noise_sd = noise_sd;
  scene.seed = seed;
  return scene;
}

TEST(Adequacy, AGaussianOnADiffractionEdgeIsFlagged) {
  const made::Scene scene = noisy(3);
  const made::Step step = made::camera_step(made::camera_of(8.0), scene.angle_deg);
  const mtf::Image image = made::make(step, scene);
  FitOptions options;
  options.residual_otf = true;
  const FitResult result = fit(data_of(fit_cases::gaussian(0.6), edge_of(image, scene)),
                               std::vector{parameter("presample[0].sigma")}, options);
  EXPECT_EQ(result.status, FitStatus::converged_model_wrong);
  EXPECT_LT(result.whiteness_p, 1e-6);
  expect_says(result.reason, {"edge"});
  // The residuals show what the model lacks: low frequencies that diffraction has lost.
  double most = 0.0;
  for (std::size_t i = 0; i < 100; ++i) most = std::max(most, result.residual_otf[i]);
  EXPECT_GT(most, 0.01);
  EXPECT_LT(most, 0.2);
}

TEST(Adequacy, UnmodelledDefocusIsFlagged) {
  made::Camera camera = made::camera_of(8.0);
  camera.w020 = 0.3;
  const made::Scene scene = noisy(4, 0.003);
  const made::Step step = made::camera_step(camera, scene.angle_deg);
  const mtf::Image image = made::make(step, scene);
  const FitResult result =
      fit(data_of(fit_cases::camera(8.0), edge_of(image, scene)), std::vector{parameter("optics.f_number")});
  EXPECT_EQ(result.status, FitStatus::converged_model_wrong) << result.whiteness_p;
}

// Noise that neighbouring pixels share has structure of its own, which is none of the model.
TEST(Adequacy, CorrelatedNoiseIsNoWrongModel) {
  const made::Step step = made::Step::gaussian(0.3), airy = made::camera_step(made::camera_of(8.0), 5.0);
  int wrong = 0, warned = 0, missed = 0;
  constexpr int kDraws = 20;
  for (int draw = 0; draw < kDraws; ++draw) {
    made::Scene scene = noisy(static_cast<std::uint64_t>(40 + draw));
    const auto fitted = [&](const made::Step& truth) {
      mtf::Image image = made::make(truth, scene);
      made::correlate_noise(image, scene, truth, 0.8);
      return fit(data_of(fit_cases::gaussian(0.6), edge_of(image, scene)),
                 std::vector{parameter("presample[0].sigma")});
    };
    const FitResult right = fitted(step);
    wrong += right.status == FitStatus::converged_model_wrong ? 1 : 0;
    for (const std::string& warning : right.warnings)
      warned += warning.find("correlated between neighbouring pixels") != std::string::npos ? 1 : 0;
    missed += fitted(airy).status == FitStatus::converged_model_wrong ? 0 : 1;
  }
  EXPECT_LE(wrong, 1);
  EXPECT_EQ(warned, kDraws);
  EXPECT_LE(missed, kDraws / 4);  // at low frequencies the noise has eight times its variance
}

TEST(Adequacy, ARightModelIsNotAndItsProbabilityIsUniform) {
  const made::Step step = made::Step::gaussian(0.3);
  int below10 = 0, below50 = 0;
  constexpr int kDraws = 100;
  for (int draw = 0; draw < kDraws; ++draw) {
    made::Scene scene = noisy(static_cast<std::uint64_t>(100 + draw));
    scene.height = 60;
    scene.half_length_px = 30.0;
    scene.width = 80;
    scene.x = 40.0 + 0.37 * draw - std::floor(0.37 * draw);
    const mtf::Image image = made::make(step, scene);
    EdgeData edge = edge_of(image, scene);
    edge.start.noise_sd *= 0.9;  // the stated noise is wrong: the test does not depend on it
    FitOptions options;
    options.residual_otf = true;
    const FitResult result =
        fit(data_of(fit_cases::gaussian(0.6), edge), std::vector{parameter("presample[0].sigma")}, options);
    EXPECT_EQ(result.status, FitStatus::converged) << result.whiteness_p;
    below10 += result.whiteness_p < 0.1;
    below50 += result.whiteness_p < 0.5;
    double most = 0.0;
    for (const double r : result.residual_otf) most = std::max(most, r);
    EXPECT_TRUE(most == 0.0 || result.whiteness_p < 0.01);
  }
  EXPECT_LT(below10, 25);  // 10 expected
  EXPECT_GT(below50, 20);  // 50 expected; the smaller of two probabilities, doubled, leans towards 1
  EXPECT_LT(below50, 70);
}

TEST(Adequacy, RoundingIsNoModelError) {
  for (const double quantum : {1.0 / 65535.0, 1.0 / 4095.0, 1.0 / 255.0})
    for (const double noise : {0.0, 0.1, 0.3, 1.0}) {
      made::Scene scene = noisy(5, noise * quantum);
      scene.quantum = quantum;
      const made::Step step = made::camera_step(made::camera_of(8.0), scene.angle_deg);
      const mtf::Image image = made::make(step, scene);
      const FitResult result =
          fit(data_of(fit_cases::camera(9.0), edge_of(image, scene)), std::vector{parameter("optics.f_number")});
      EXPECT_EQ(result.status, FitStatus::converged) << quantum << " " << noise << " p " << result.whiteness_p;
    }
}

TEST(Adequacy, TailOfTheVarianceRatio) {
  // F(0.95; 5, 10) = 3.3258, F(0.99; 30, 1000) = 1.7176: tables of the F distribution.
  EXPECT_NEAR(f_tail(3.3258, 5, 10), 0.05, 2e-5);
  EXPECT_NEAR(f_tail(1.0 / 3.3258, 10, 5), 0.95, 2e-5);
  // One degree of freedom: the square of Student's t; t(0.975; 20) = 2.0860.
  EXPECT_NEAR(f_tail(2.0860 * 2.0860, 1, 20), 0.05, 2e-5);
  EXPECT_EQ(f_tail(0.0, 5, 10), 1.0);
  EXPECT_LT(f_tail(50.0, 100, 10000), 1e-200);
}

}  // namespace
}  // namespace calib
