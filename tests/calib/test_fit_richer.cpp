// SPDX-License-Identifier: Apache-2.0
// The errors of a fit hold for its sensor: what one more unknown makes of the values, and whether the data ask for it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/calib/fit_cases.h"
#include "tests/expect_error.h"

namespace calib {
namespace {

using fit_cases::data_of;
using fit_cases::edge_of;
using fit_cases::parameter;
using mtf::System;

const std::vector<FitParameter> kFNumber{parameter("optics.f_number", "f_number")};

struct Edge {
  made::Scene scene;
  mtf::Image image;
  Edge(const made::Camera& camera, double cnr, std::uint64_t seed, double angle_deg = 5.0) {
    scene.angle_deg = angle_deg;
    scene.noise_sd = 0.6 / cnr;
    scene.seed = seed;
    image = made::make(made::camera_step(camera, scene.angle_deg), scene);
  }
  FitResult fit(const System<double>& sensor, const std::vector<FitParameter>& parameters) const {
    return calib::fit(data_of(sensor, edge_of(image, scene)), parameters, {.richer_models = true});
  }
};

made::Camera out_of_focus(double waves) {
  made::Camera camera = made::camera_of(8.0);
  camera.w020 = waves;
  return camera;
}

const RicherModel* model_of(const FitResult& result, const std::string& unknown) {
  const auto found = std::find_if(result.richer_models.begin(), result.richer_models.end(),
                                  [&](const RicherModel& model) { return model.unknown == unknown; });
  return found == result.richer_models.end() ? nullptr : &*found;
}

/// Half of what is said of a parameter, in standard deviations.
double uncertainty(const FittedParameter& p) {
  if (p.stderr_value) return *p.stderr_value;
  return p.interval95 ? 0.25 * ((*p.interval95)[1] - (*p.interval95)[0]) : p.linear_sd;
}

// A lens of f/8 with 0.4 waves of defocus, contrast / noise 30: f/13.8 +- 0.2 in focus, and residuals that look right.
TEST(FitRicher, ALensOutOfFocusIsNoSlowerLens) {
  const Edge edge(out_of_focus(0.4), 30.0, 3);
  const FitResult result = edge.fit(fit_cases::camera(6.0), kFNumber);
  EXPECT_GT(result.whiteness_p, 1e-4);  // they do not show it
  EXPECT_EQ(result.status, FitStatus::converged_model_wrong);
  expect_says(result.reason, {"defocus unknown"});
  EXPECT_GT(std::abs(result.parameters[0].value - 8.0), 10.0 * *result.parameters[0].stderr_value);
  const RicherModel* const focus = model_of(result, "defocus");
  ASSERT_NE(focus, nullptr);
  const FittedParameter &f_number = focus->parameters[0], &waves = focus->parameters[1];
  ASSERT_TRUE(f_number.stderr_value && waves.stderr_value);
  EXPECT_NEAR(f_number.value, 8.0, 4.0 * *f_number.stderr_value);
  EXPECT_NEAR(std::abs(waves.value), 0.4, 4.0 * *waves.stderr_value);
  EXPECT_LT(focus->p, 1e-6);
}

// At contrast / noise 8 the data cannot tell: the companion of the error holds the truth.
TEST(FitRicher, WhereTheDataCannotTellTheErrorHasACompanion) {
  int silent = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    const Edge edge(out_of_focus(0.4), 6.0, seed);
    const FitResult result = edge.fit(fit_cases::camera(6.0), kFNumber);
    silent += result.status == FitStatus::converged;
    const RicherModel* const focus = model_of(result, "defocus");
    ASSERT_NE(focus, nullptr);
    EXPECT_GT(uncertainty(focus->parameters[0]), 1.5 * uncertainty(result.parameters[0])) << seed;
    EXPECT_NEAR(focus->parameters[0].value, 8.0, 3.5 * uncertainty(focus->parameters[0])) << seed;
  }
  EXPECT_GE(silent, 3);
}

// The gain is that of two independent fits: chi-square of each by its residuals.
TEST(FitRicher, TheGainIsTheDifferenceOfChiSquare) {
  const Edge edge(out_of_focus(0.2), 60.0, 5);
  const FitResult plain = edge.fit(fit_cases::camera(8.0), kFNumber);
  System<double> sensor = fit_cases::camera(8.0);
  auto pupil = mtf::Component<double>::make("defocus");
  mtf::test::set(pupil, "waves", 0.2);
  sensor.stages[0][0].component = pupil;
  const FitResult focus = edge.fit(sensor, {kFNumber[0], parameter("presample[0].waves")});
  const auto chi2 = [](const FitResult& result) {
    const mtf::Image& residual = result.data[0].residual;
    double sum = 0.0;
    for (std::int64_t i = 0; i < residual.size(); ++i) {
      const double size = std::abs(static_cast<double>(residual.data()[i]));
      sum += size < 3.0 ? size * size : 3.0 * (2.0 * size - 3.0);  // the Huber loss
    }
    return sum;
  };
  const RicherModel* const model = model_of(plain, "defocus");
  ASSERT_NE(model, nullptr);
  ASSERT_FALSE(plain.data[0].gradients);  // which would take part of the gain
  // In units of the noise, which is known to 1 / sqrt(2 x 12800).
  EXPECT_NEAR(model->chi2_gain, chi2(plain) - chi2(focus), 0.05 * model->chi2_gain + 0.1);
  EXPECT_NEAR(model->parameters[0].value, focus.parameters[0].value, 0.05 * *focus.parameters[0].stderr_value);
  EXPECT_NEAR(*model->parameters[0].stderr_value, *focus.parameters[0].stderr_value,
              0.02 * *focus.parameters[0].stderr_value);
  EXPECT_TRUE(focus.richer_models.empty() || model_of(focus, "defocus") == nullptr);
}

TEST(FitRicher, ARightSensorIsNotTakenForAWrongOne) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Edge edge(made::camera_of(8.0), 60.0, seed);
    const FitResult result = edge.fit(fit_cases::camera(6.0), kFNumber);
    EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
    for (const RicherModel& model : result.richer_models) {
      EXPECT_GT(model.p, 1e-4) << model.unknown;
      EXPECT_NEAR(model.parameters[0].value, 8.0, 4.0 * uncertainty(model.parameters[0])) << model.unknown;
    }
  }
}

// Without noise, rounded or not, tables and rounding are no defocus.
TEST(FitRicher, RoundingIsNoRicherModel) {
  for (const double quantum : {0.0, 1.0 / 255.0}) {
    Edge edge(made::camera_of(8.0), 60.0, 1);
    edge.scene.noise_sd = 0.0;
    edge.scene.quantum = quantum;
    edge.image = made::make(made::camera_step(made::camera_of(8.0), edge.scene.angle_deg), edge.scene);
    const FitResult result = edge.fit(fit_cases::camera(6.0), kFNumber);
    EXPECT_EQ(result.status, FitStatus::converged) << quantum << ": " << result.reason;
  }
}

TEST(FitRicher, OnlyWhatTheSensorLacks) {
  const auto unknowns = [](const System<double>& sensor, const std::vector<FitParameter>& parameters,
                           double angle_deg) {
    std::vector<std::string> names;
    for (const RicherModel& model :
         Edge(made::camera_of(8.0), 60.0, 1, angle_deg).fit(sensor, parameters).richer_models)
      names.push_back(model.unknown);
    return names;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(unknowns(fit_cases::camera(8.0), kFNumber, 5.0), (Names{"defocus", "jitter", "motion along x"}));
  EXPECT_EQ(unknowns(fit_cases::camera(8.0), kFNumber, 85.0), (Names{"defocus", "jitter", "motion along y"}));
  EXPECT_EQ(unknowns(fit_cases::table_sensor(0.05, 0.1, 0.1), kFNumber, 5.0), Names{});
  // A Gaussian stands for every cause of blur.
  EXPECT_EQ(unknowns(fit_cases::gaussian(0.5), {parameter("presample[0].sigma")}, 5.0), Names{});
  System<double> wavefront = fit_cases::table_sensor(0.0, 0.1, 0.1);
  auto pupil = mtf::Component<double>::make("wavefront");
  mtf::test::set(pupil, "w040", 0.02);
  wavefront.stages[0] = {{pupil, "wavefront"}, wavefront.stages[0][1], wavefront.stages[0][3], wavefront.stages[0][4]};
  EXPECT_EQ(unknowns(wavefront, kFNumber, 5.0), Names{"defocus"});
}

TEST(FitRicherLong, FalseAlarmsAreRareAndCompanionsHold) {
  constexpr int kDraws = 500;
  int wrong = 0, held = 0;
  for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
    const FitResult right = Edge(made::camera_of(8.0), 60.0, seed).fit(fit_cases::camera(6.0), kFNumber);
    wrong += right.status != FitStatus::converged;
    const FitResult lacks = Edge(out_of_focus(0.3), 20.0, 1000 + seed).fit(fit_cases::camera(6.0), kFNumber);
    const RicherModel* const focus = model_of(lacks, "defocus");
    ASSERT_NE(focus, nullptr);
    const FittedParameter& p = focus->parameters[0];
    held += p.interval95 ? (*p.interval95)[0] < 8.0 && (*p.interval95)[1] > 8.0
                         : p.stderr_value && std::abs(p.value - 8.0) < 1.96 * *p.stderr_value;
  }
  std::printf("right sensors said to be wrong: %d, companions that hold: %d of %d\n", wrong, held, kDraws);
  EXPECT_LE(wrong, 2);
  EXPECT_GE(100 * held, 91 * kDraws);
}

}  // namespace
}  // namespace calib
