// SPDX-License-Identifier: Apache-2.0
// Curves and spots as data, priors, bounds, profiles, several starts, several conditions, the loop through a
// simulation.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/calib/fit_cases.h"

namespace calib {
namespace {

using fit_cases::data_of;
using fit_cases::edge_of;
using fit_cases::parameter;
using mtf::Component;
using mtf::Stage;
using mtf::System;

const std::vector<FitParameter> kSigma{parameter("presample[0].sigma", "gaussian.sigma")};

made::Scene noisy(std::uint64_t seed, double noise_sd = 0.01) {
  made::Scene scene;
  scene.noise_sd = noise_sd;
  scene.seed = seed;
  return scene;
}

CurveData curve_of(const System<double>& system, double angle_deg, double sd, std::uint64_t seed) {
  CurveData curve{.name = "curve",
                  .condition = 0,
                  .angle_deg = angle_deg,
                  .unit = mtf::find_unit("cy/mm"),
                  .frequency = {},
                  .mtf = {},
                  .sd = {sd}};
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> normal(0.0, sd);
  for (int i = 1; i <= 40; ++i) {
    const double f_px = 0.02 * i;
    curve.frequency.push_back(system.frame.cy_mm_from_px(f_px, mtf::Axis::x));
    curve.mtf.push_back(fit_cases::mtf_along(system, angle_deg, f_px) + normal(bits));
  }
  return curve;
}

TEST(FitData, ACurveAlone) {
  const System<double> truth = fit_cases::camera(8.0);
  FitData data;
  data.conditions.push_back(fit_cases::camera(6.0));
  data.curves.push_back(curve_of(truth, 0.0, 0.003, 1));
  const FitResult result = fit(data, std::vector{parameter("optics.f_number")});
  EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
  ASSERT_TRUE(result.parameters[0].stderr_value.has_value());
  EXPECT_NEAR(result.parameters[0].value, 8.0, 4.0 * *result.parameters[0].stderr_value);
  EXPECT_LT(*result.parameters[0].stderr_value, 0.03);
  EXPECT_GT(*result.parameters[0].stderr_value, 0.002);
}

TEST(FitData, ACurveAndAnEdgeTellApartWhatNeitherDoes) {
  // The curve is of the camera at another f-number: only the blur is shared.
  const System<double> sensor = fit_cases::table_sensor(0.07, 0.25, 0.5);
  made::Scene scene;
  const made::Step step([&](double f) { return fit_cases::mtf_along(sensor, 5.0, f); }, 1.0 / 0.93, 120.0);
  const mtf::Image image = made::make(step, scene);
  FitData data = data_of(sensor, edge_of(image, scene));
  data.edges[0].start.noise_sd = 0.01;
  const std::vector<FitParameter> both{parameter("presample[3].rms", "jitter"),
                                       parameter("presample[4].travel", "smear")};
  EXPECT_FALSE(fit(data, both).not_separable.empty());
  data.curves.push_back(curve_of(sensor, 90.0, 0.003, 2));
  const FitResult result = fit(data, both);
  EXPECT_TRUE(result.not_separable.empty());
  EXPECT_EQ(result.data.size(), 2u);
  EXPECT_NEAR(result.parameters[1].value, 0.5, 0.2);
}

TEST(FitData, ASpot) {
  System<double> truth = fit_cases::camera(8.0);
  truth.add(Stage::presample, mtf::test::jitter(0.4, "px"));
  // Pixels by a sum over frequencies of another step than the fit's.
  mtf::Image image(24, 20);
  std::mt19937_64 bits(7);
  std::normal_distribution<double> normal(0.0, 2.0);
  constexpr double kPeriod = 160.0, kX = 11.8, kY = 9.3, kFlux = 20000.0;
  const int most = static_cast<int>(std::ceil(kPeriod * 1.09));
  std::vector<double> sums(static_cast<std::size_t>(image.size()), 0.0);
  for (int j = -most; j <= most; ++j)
    for (int i = -most; i <= most; ++i) {
      const double fx = i / kPeriod, fy = j / kPeriod, f = std::hypot(fx, fy);
      if (f * 0.93023 > 1.0) continue;
      const double angle = std::atan2(fy, fx) * 180.0 / std::numbers::pi;
      const double h = f == 0.0 ? 1.0 : fit_cases::mtf_along(truth, angle, f);
      for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 24; ++x)
          sums[static_cast<std::size_t>(y * 24 + x)] +=
              h * std::cos(2.0 * std::numbers::pi * (fx * (x + 0.5 - kX) + fy * (y + 0.5 - kY)));
    }
  for (std::size_t i = 0; i < sums.size(); ++i)
    image.data()[i] = static_cast<float>(100.0 + kFlux * sums[i] / (kPeriod * kPeriod) + normal(bits));
  FitData data;
  System<double> start = truth;
  *parameter_at(start, "presample[2].rms") = 0.3;
  data.conditions.push_back(start);
  data.spots.push_back({.name = "star", .image = image.view(), .roi = {0, 0, 24, 20}, .condition = 0});
  const FitResult result = fit(data, std::vector{parameter("presample[2].rms", "jitter")});
  EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
  ASSERT_TRUE(result.parameters[0].stderr_value.has_value());
  EXPECT_NEAR(result.parameters[0].value, 0.4, 4.0 * *result.parameters[0].stderr_value);
  EXPECT_LT(*result.parameters[0].stderr_value, 0.01);
  EXPECT_NEAR(result.data[0].chi2_per_dof, 1.0, 0.3);
}

TEST(FitData, APriorIsOneMoreMeasurement) {
  const made::Scene scene = noisy(11, 0.05);
  const made::Step step = made::Step::gaussian(0.3);
  const mtf::Image image = made::make(step, scene);
  const FitData data = data_of(fit_cases::gaussian(0.8), edge_of(image, scene));
  const FitResult free = fit(data, kSigma);
  const double value = free.parameters[0].value, sd = free.parameters[0].stderr_value.value();
  std::vector<FitParameter> with = kSigma;
  with[0].prior = {value + 2.0 * sd, sd};  // as good as the data: the mean of both
  const FitResult result = fit(data, with);
  EXPECT_NEAR(result.parameters[0].value, value + sd, 0.1 * sd);
  EXPECT_NEAR(result.parameters[0].stderr_value.value(), sd / std::numbers::sqrt2, 0.05 * sd);
  with[0].prior = {value, 0.01 * sd};
  EXPECT_EQ(fit(data, with).parameters[0].knowledge, Knowledge::prior_only);
}

TEST(FitData, AnUpperLimitAtZero) {
  // No jitter in the image: its square is fitted, and ends at zero or below the noise.
  int limits = 0, held = 0;
  for (int draw = 0; draw < 12; ++draw) {
    const made::Scene scene = noisy(static_cast<std::uint64_t>(20 + draw));
    const made::Step step = made::camera_step(made::camera_of(8.0), scene.angle_deg);
    const mtf::Image image = made::make(step, scene);
    System<double> sensor = fit_cases::camera(8.0);
    sensor.add(Stage::presample, mtf::test::jitter(draw % 2 == 0 ? 0.2 : 0.0, "px"));
    const FitResult result = fit(data_of(sensor, edge_of(image, scene)), std::vector{parameter("presample[2].rms")});
    EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
    const FittedParameter& p = result.parameters[0];
    EXPECT_LT(p.value, 0.2);
    if (p.knowledge != Knowledge::at_bound) continue;
    ++limits;
    ASSERT_TRUE(p.limit95.has_value());
    EXPECT_FALSE(p.stderr_value.has_value());
    EXPECT_GT(*p.limit95, 0.02);
    EXPECT_LT(*p.limit95, 0.25);
    ++held;
  }
  EXPECT_GE(limits, 8);
  EXPECT_EQ(held, limits);
}

TEST(FitData, BoundsThatExcludeTheTruth) {
  const made::Scene scene = noisy(31);
  const made::Step step = made::Step::gaussian(0.3);  // sigma 0.6246
  const mtf::Image image = made::make(step, scene);
  std::vector<FitParameter> parameters = kSigma;
  parameters[0].min = 0.8;
  const FitResult result = fit(data_of(fit_cases::gaussian(0.9), edge_of(image, scene)), parameters);
  EXPECT_EQ(result.parameters[0].knowledge, Knowledge::at_bound);
  EXPECT_NEAR(result.parameters[0].value, 0.8, 1e-9);
  EXPECT_EQ(result.status, FitStatus::converged_model_wrong);
}

TEST(FitData, ProfilesOfAParabolaAreItsErrors) {
  const made::Scene scene = noisy(41);
  const made::Step step = made::Step::gaussian(0.3);
  const mtf::Image image = made::make(step, scene);
  FitOptions options;
  options.profile = true;
  const FitResult result = fit(data_of(fit_cases::gaussian(0.8), edge_of(image, scene)), kSigma, options);
  const FittedParameter& p = result.parameters[0];
  ASSERT_TRUE(p.interval68 && p.interval95 && p.stderr_value);
  EXPECT_NEAR((*p.interval68)[0], p.value - *p.stderr_value, 0.05 * *p.stderr_value);
  EXPECT_NEAR((*p.interval68)[1], p.value + *p.stderr_value, 0.05 * *p.stderr_value);
  EXPECT_NEAR((*p.interval95)[1], p.value + 1.96 * *p.stderr_value, 0.1 * *p.stderr_value);
}

TEST(FitData, SeveralStartsFindTheDeeperMinimum) {
  // Far out of focus the contrast has turned: from there the minimiser goes to a wrong minimum.
  made::Camera camera = made::camera_of(8.0);
  camera.w020 = 0.3;
  camera.w040 = -0.25;
  const made::Scene scene = noisy(51, 0.003);
  const made::Step step = made::camera_step(camera, scene.angle_deg);
  const mtf::Image image = made::make(step, scene);
  System<double> sensor = fit_cases::camera(8.0);
  auto wavefront = Component<double>::make("wavefront");
  mtf::test::set(wavefront, "w020", 0.9);
  mtf::test::set(wavefront, "w040", -0.6);
  sensor.stages[0][0].component = wavefront;
  std::vector<FitParameter> parameters{parameter("presample[0].w020"), parameter("presample[0].w040")};
  for (FitParameter& p : parameters) p.min = -1.5, p.max = 1.5;
  FitOptions options;
  const FitResult one = fit(data_of(sensor, edge_of(image, scene)), parameters, options);
  options.starts = 6;
  const FitResult many = fit(data_of(sensor, edge_of(image, scene)), parameters, options);
  EXPECT_LE(many.chi2_per_dof, one.chi2_per_dof * (1.0 + 1e-6));
  EXPECT_NEAR(many.chi2_per_dof, 1.0, 0.05);
  EXPECT_GE(many.starts_agreeing, 1);
  EXPECT_LE(many.starts_agreeing, 6);
}

TEST(FitData, TwoConditionsShareTheirParameters) {
  const made::Step sharp = made::camera_step(made::camera_of(5.6), 5.0),
                   soft = made::camera_step(made::camera_of(11.0), 5.0);
  const made::Scene scene = noisy(61);
  const mtf::Image a = made::make(sharp, scene), b = made::make(soft, scene);
  FitData data;
  data.conditions = {fit_cases::camera(5.6, 0.8), fit_cases::camera(11.0, 0.8)};
  data.edges = {edge_of(a, scene, "f/5.6"), edge_of(b, scene, "f/11")};
  data.edges[1].condition = 1;
  const FitResult result = fit(data, std::vector{parameter("presample[1].width", "pixel")});
  EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
  EXPECT_NEAR(result.parameters[0].value, 1.0, 4.0 * result.parameters[0].stderr_value.value());
  EXPECT_EQ(*result.system.optics.f_number, 5.6);
}

TEST(FitData, ProgressIsToldAndCanStop) {
  const made::Scene scene = noisy(71);
  const made::Step step = made::Step::gaussian(0.3);
  const mtf::Image image = made::make(step, scene);
  const FitData data = data_of(fit_cases::gaussian(0.8), edge_of(image, scene));
  FitOptions options;
  double last = 0.0;
  int calls = 0;
  options.progress = [&](double share) {
    EXPECT_GE(share, last);
    EXPECT_LE(share, 1.0);
    last = share;
    ++calls;
    return true;
  };
  EXPECT_EQ(fit(data, kSigma, options).status, FitStatus::converged);
  EXPECT_GT(calls, 2);
  options.progress = [](double) { return false; };
  const FitResult stopped = fit(data, kSigma, options);
  EXPECT_EQ(stopped.status, FitStatus::stopped);
  EXPECT_FALSE(stopped.reason.empty());
}

TEST(FitData, NoiseThatGrowsWithTheSignal) {
  made::Scene scene = noisy(81, 0.002);
  scene.noise_gain = 3e-4;
  const made::Step step = made::Step::gaussian(0.3);
  const mtf::Image image = made::make(step, scene);
  const FitResult result = fit(data_of(fit_cases::gaussian(0.8), edge_of(image, scene)), kSigma);
  EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
  EXPECT_NEAR(result.data[0].chi2_per_dof, 1.0, 0.05);
  EXPECT_NEAR(result.parameters[0].value, fit_cases::sigma_of(0.3), 4.0 * result.parameters[0].stderr_value.value());
}

// A band, electronics with a phase, a filter after the detector: the whole system, asymmetric and with a gain.
TEST(FitData, AllStagesOfABandSensor) {
  System<double> truth = fit_cases::bare();
  truth.optics.wavelength_um.reset();
  truth.optics.f_number = 8.0;
  truth.band = mtf::Band{0.45, 0.65};
  truth.add(Stage::presample, Component<double>::make("diffraction"));
  auto pixel = Component<double>::make("footprint");
  mtf::test::set(pixel, "width", 1.0, "px");
  truth.add(Stage::presample, pixel);
  auto rc = Component<double>::make("rc_lowpass");
  mtf::test::set(rc, "cutoff", 0.4, "cy/px");
  mtf::test::choose(rc, "axis", 0);
  truth.add(Stage::readout, rc);
  truth.add(Stage::postsample, mtf::test::fir({{-0.2, 1.4, -0.2}}));
  made::Scene scene = noisy(91, 0.002);
  const double angle = scene.angle_deg * std::numbers::pi / 180.0;
  // E of the complex OTF, by an independent quadrature.
  const auto edge_at = [&](double d) {
    double sum = 0.0;
    constexpr int kNodes = 4000;
    const double top = 1000.0 / (0.45 * 8.0) * fit_cases::kPitch_um * 1e-3;
    for (int k = 0; k < kNodes; ++k) {
      const double f = top * (k + 0.5) / kNodes;
      static std::vector<mtf::Complex<double>> h;
      if (h.size() <= static_cast<std::size_t>(k)) {
        System<double> quick = truth;
        quick.band_nodes = 16;
        h.push_back(quick.otf({quick.frame.cy_mm_from_px(f * std::cos(angle), mtf::Axis::x),
                               quick.frame.cy_mm_from_px(f * std::sin(angle), mtf::Axis::y)}));
      }
      const double turn = 2.0 * std::numbers::pi * f * d;
      sum +=
          (h[static_cast<std::size_t>(k)].re * std::sin(turn) + h[static_cast<std::size_t>(k)].im * std::cos(turn)) / f;
    }
    return 0.5 + sum * top / kNodes / std::numbers::pi;
  };
  std::vector<double> table;
  for (int i = 0; i <= 3200; ++i) table.push_back(edge_at(-20.0 + 0.0125 * i));
  scene.width = 36, scene.height = 60, scene.half_length_px = 30.0;
  mtf::Image image(scene.width, scene.height);
  std::mt19937_64 bits(5);
  std::normal_distribution<double> normal(0.0, scene.noise_sd);
  for (std::int64_t y = 0; y < scene.height; ++y)
    for (std::int64_t x = 0; x < scene.width; ++x) {
      const double at = std::clamp(
          (made::distance(scene, static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5) + 20.0) / 0.0125, 0.0,
          3199.0);
      const auto i = static_cast<std::size_t>(at);
      const double e = table[i] + (at - static_cast<double>(i)) * (table[i + 1] - table[i]);
      image.at(x, y) = static_cast<float>(0.2 + 0.6 * e + normal(bits));
    }
  System<double> start = truth;
  *parameter_at(start, "readout[0].cutoff") = 0.6;
  *parameter_at(start, "presample[1].width") = 0.9;
  const FitResult result = fit(data_of(start, edge_of(image, scene)),
                               std::vector{parameter("readout[0].cutoff"), parameter("presample[1].width")});
  EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_TRUE(result.parameters[i].stderr_value.has_value());
    EXPECT_NEAR(result.parameters[i].value, i == 0 ? 0.4 : 1.0, 4.0 * *result.parameters[i].stderr_value);
  }
  EXPECT_LT(*result.parameters[0].stderr_value, 0.02);
}

}  // namespace
}  // namespace calib
