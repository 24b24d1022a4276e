// SPDX-License-Identifier: Apache-2.0
// Fits with the right model give back what the images were made with: noise-free to a few parts in a million.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/calib/fit_cases.h"
#include "tests/calib/public_edges.h"

namespace calib {
namespace {

using fit_cases::data_of;
using fit_cases::edge_of;
using fit_cases::parameter;
using mtf::Component;
using mtf::System;

constexpr double kStep16 = 1.0 / 65535.0;

/// Relative error of MTF50, and the largest error of the MTF up to the Nyquist frequency, against a step's own MTF.
struct Errors {
  double mtf50 = 0.0, largest = 0.0;
};
Errors errors(const FitResult& result, const made::Step& step, double angle_deg) {
  Errors e{fit_cases::mtf50_along(result.system, angle_deg) / step.crossing(0.5) - 1.0, 0.0};
  for (int i = 1; i <= 50; ++i) {
    const double f = 0.01 * i;
    e.largest = std::max(e.largest, std::abs(fit_cases::mtf_along(result.system, angle_deg, f) - step.mtf(f)));
  }
  return e;
}

made::Scene scene16(double angle_deg) {
  made::Scene scene;
  scene.angle_deg = angle_deg;
  scene.quantum = kStep16;
  return scene;
}

TEST(Fit, GaussianAtAnyAngle) {
  for (const double mtf50 : {0.08, 0.3, 0.5})
    for (const double angle : {2.0, 5.0, 15.0, 26.57, 44.0, 93.0, -150.0}) {
      const made::Scene scene = scene16(angle);
      const made::Step step = made::Step::gaussian(mtf50);
      const mtf::Image image = made::make(step, scene);
      const double truth = fit_cases::sigma_of(mtf50);
      const std::vector<FitParameter> sigma{parameter("presample[0].sigma", "gaussian.sigma")};
      const FitResult result = fit(data_of(fit_cases::gaussian(1.3 * truth), edge_of(image, scene)), sigma);
      const Errors e = errors(result, step, angle);
      SCOPED_TRACE(std::to_string(mtf50) + " at " + std::to_string(angle));
      EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
      EXPECT_EQ(result.parameters[0].knowledge, Knowledge::determined);
      EXPECT_LT(std::abs(e.mtf50), 2e-5);
      EXPECT_LT(e.largest, 2e-5);
      EXPECT_NEAR(result.equivalent_variance_px2->value, truth * truth, 1e-4 * truth * truth);
      ASSERT_TRUE(result.mtf50.has_value());
      EXPECT_NEAR(result.mtf50->value, mtf50, 2e-5 * mtf50);
    }
}

TEST(Fit, CameraWithItsFNumberOrItsPixelUnknown) {
  for (const double f_number : {2.8, 5.6, 8.0, 16.0})
    for (const char* path : {"optics.f_number", "presample[1].width"}) {
      made::Camera camera = made::camera_of(f_number);
      const made::Scene scene = scene16(8.0);
      const made::Step step = made::camera_step(camera, scene.angle_deg);
      const mtf::Image image = made::make(step, scene);
      System<double> start = fit_cases::camera(f_number);
      *parameter_at(start, path) *= 1.1;
      const FitResult result = fit(data_of(start, edge_of(image, scene)), std::vector{parameter(path)});
      const Errors e = errors(result, step, scene.angle_deg);
      SCOPED_TRACE(std::string(path) + " at f/" + std::to_string(f_number));
      EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
      EXPECT_LT(std::abs(e.mtf50), 5e-5);
      EXPECT_LT(e.largest, 5e-5);
    }
}

TEST(Fit, DefocusFoundFromEitherSide) {
  made::Camera camera = made::camera_of(8.0);
  camera.w020 = 0.3;
  const made::Scene scene = scene16(5.0);
  const made::Step step = made::camera_step(camera, scene.angle_deg);
  const mtf::Image image = made::make(step, scene);
  for (const double start : {0.0, 0.6, -0.1}) {
    System<double> sensor = fit_cases::camera(8.0);
    auto defocus = Component<double>::make("defocus");
    mtf::test::set(defocus, "waves", start);
    sensor.stages[0][0].component = defocus;
    const FitResult result = fit(data_of(sensor, edge_of(image, scene)), std::vector{parameter("presample[0].waves")});
    EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
    EXPECT_NEAR(std::abs(result.parameters[0].value), 0.3, 1e-5) << start;
    EXPECT_LT(std::abs(errors(result, step, scene.angle_deg).mtf50), 1e-4);
  }
}

TEST(Fit, WavefrontOfTwoTerms) {
  made::Camera camera = made::camera_of(8.0);
  camera.w020 = -0.3;
  camera.w040 = 0.5;
  const made::Scene scene = scene16(5.0);
  const made::Step step = made::camera_step(camera, scene.angle_deg);
  const mtf::Image image = made::make(step, scene);
  System<double> sensor = fit_cases::camera(8.0);
  auto wavefront = Component<double>::make("wavefront");
  mtf::test::set(wavefront, "w020", -0.2);
  mtf::test::set(wavefront, "w040", 0.4);
  sensor.stages[0][0].component = wavefront;
  const FitResult result = fit(data_of(sensor, edge_of(image, scene)),
                               std::vector{parameter("presample[0].w020"), parameter("presample[0].w040")});
  EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
  const Errors e = errors(result, step, scene.angle_deg);
  EXPECT_LT(std::abs(e.mtf50), 1e-4);
  EXPECT_LT(e.largest, 1e-4);
}

TEST(Fit, CurvedEdgeLikeAStraightOne) {
  made::Scene scene = scene16(5.0);
  scene.sagitta_px = 1.5;
  const made::Step step = made::Step::gaussian(0.3);
  const mtf::Image image = made::make(step, scene);
  const FitResult result =
      fit(data_of(fit_cases::gaussian(0.8), edge_of(image, scene)), std::vector{parameter("presample[0].sigma")});
  EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
  EXPECT_LT(std::abs(errors(result, step, scene.angle_deg).mtf50), 5e-5);
  EXPECT_NEAR(result.data.front().curve.coefficient.at(0), 1.5, 1e-3);
}

TEST(Fit, GradientsOfThePlateausAreFound) {
  made::Scene scene = scene16(7.0);
  scene.gradient_dark = 4e-4;
  scene.gradient_bright = -3e-4;
  const made::Step step = made::Step::gaussian(0.3);
  const mtf::Image image = made::make(step, scene);
  const FitResult result =
      fit(data_of(fit_cases::gaussian(0.8), edge_of(image, scene)), std::vector{parameter("presample[0].sigma")});
  EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
  // Where the plateaus meet, the scene's gradients have a kink that the model's have not blurred.
  EXPECT_LT(std::abs(errors(result, step, scene.angle_deg).mtf50), 2e-3);
}

TEST(Fit, OutliersCountLittle) {
  made::Scene scene = scene16(5.0);
  scene.noise_sd = 0.01;
  const made::Step step = made::Step::gaussian(0.3);
  mtf::Image image = made::make(step, scene);
  for (std::int64_t i = 37; i < image.size(); i += 211) image.data()[i] = i % 2 == 0 ? 1.0F : 0.0F;
  const FitResult result =
      fit(data_of(fit_cases::gaussian(0.8), edge_of(image, scene)), std::vector{parameter("presample[0].sigma")});
  ASSERT_TRUE(result.parameters[0].stderr_value.has_value());
  EXPECT_NEAR(result.parameters[0].value, fit_cases::sigma_of(0.3), 4.0 * *result.parameters[0].stderr_value);
  EXPECT_LT(*result.parameters[0].stderr_value, 0.006);
  EXPECT_NEAR(result.data.front().outlier_share, 1.0 / 211.0, 5e-4);
}

TEST(Fit, CoarseRoundingIsKnownForWhatItIs) {
  // 8 bits without noise: a plateau may be off by half a step, however many pixels it has.
  const made::Step step = made::Step::gaussian(0.3);
  int within = 0, all = 0;
  for (const double dark : {0.2, 0.2008, 0.2017, 0.2031})
    for (const double bright : {0.8, 0.7989, 0.8023}) {
      made::Scene scene;
      scene.quantum = 1.0 / 255.0;
      scene.dark = dark, scene.bright = bright;
      const mtf::Image image = made::make(step, scene);
      const FitResult result =
          fit(data_of(fit_cases::gaussian(0.8), edge_of(image, scene)), std::vector{parameter("presample[0].sigma")});
      ASSERT_TRUE(result.mtf50.has_value());
      EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
      EXPECT_NEAR(result.mtf50->value, 0.3, 0.007 * 0.3) << dark << " " << bright;
      EXPECT_LT(result.mtf50->sd, 0.0025 * 0.3);
      within += std::abs(result.mtf50->value - 0.3) < 2.0 * result.mtf50->sd;
      ++all;
    }
  EXPECT_GE(within, all - 1);
}

TEST(Fit, SameBitsForAnyNumberOfThreads) {
  made::Scene scene = scene16(5.0);
  scene.noise_sd = 0.01;
  const made::Step step = made::Step::gaussian(0.3);
  std::vector<mtf::Image> images;
  FitData data;
  data.conditions.push_back(fit_cases::gaussian(0.8));
  for (int i = 0; i < 6; ++i) {
    scene.seed = static_cast<std::uint64_t>(i + 1);
    scene.angle_deg = 5.0 + 15.0 * i;
    images.push_back(made::make(step, scene));
    data.edges.push_back(edge_of(images.back(), scene, "edge " + std::to_string(i)));
  }
  for (std::size_t i = 0; i < images.size(); ++i) data.edges[i].image = images[i].view();
  FitOptions options;
  options.threads = 1;
  const FitResult one = fit(data, std::vector{parameter("presample[0].sigma")}, options);
  const FitResult again = fit(data, std::vector{parameter("presample[0].sigma")}, options);
  EXPECT_EQ(one.parameters[0].value, again.parameters[0].value);
  options.threads = 3;
  const FitResult three = fit(data, std::vector{parameter("presample[0].sigma")}, options);
  EXPECT_EQ(one.status, FitStatus::converged) << one.reason;
  EXPECT_EQ(one.parameters[0].value, three.parameters[0].value);
  EXPECT_EQ(one.mtf_sd, three.mtf_sd);
  EXPECT_EQ(one.chi2_per_dof, three.chi2_per_dof);
  ASSERT_TRUE(one.parameters[0].stderr_value.has_value());
  EXPECT_NEAR(one.parameters[0].value, fit_cases::sigma_of(0.3), 4.0 * *one.parameters[0].stderr_value);
}

/// "ex_ab_f2p8_a04.png" -> 2.8
double f_number_in(const std::string& file) {
  const auto at = file.find("_f") + 2;
  std::string number = file.substr(at, file.find('_', at) - at);
  if (const auto p = number.find('p'); p != std::string::npos) number[p] = '.';
  return std::stod(number);
}

// The mm_ images of the pupil are not exact.
TEST(Fit, PublicEdgesWithTheRightModel) {
  const auto all = public_edges::cases();
  if (all.empty()) GTEST_SKIP() << "no shared data";
  int fitted = 0;
  for (const auto& one : all) {
    const bool gaussian = one.psf == "gaussian", airy = one.file.starts_with("ex_ab"),
               olpf = one.file == "ex_olpf_f5p6_a04.png", pupil = one.file == "ex_wf_f8_a05.png";
    if (one.bits < 16 || one.noise_sigma > 0.0 || !(gaussian || airy || olpf || pupil)) continue;
    const mtf::Image image = public_edges::read(one);
    made::Scene scene = scene16(one.file.starts_with("mm_") ? 180.0 - one.angle_deg : -one.angle_deg);
    scene.width = image.width(), scene.height = image.height();
    scene.x = one.x, scene.y = one.y, scene.sagitta_px = one.sagitta_px;
    System<double> sensor = gaussian ? fit_cases::gaussian(1.2 * fit_cases::sigma_of(one.mtf50))
                                     : fit_cases::camera(1.1 * f_number_in(one.file));
    std::vector<FitParameter> parameters{parameter(gaussian ? "presample[0].sigma" : "optics.f_number")};
    if (pupil) {
      *sensor.optics.f_number = 8.0;
      auto defocus = Component<double>::make("defocus");
      mtf::test::set(defocus, "waves", 0.1);
      sensor.stages[0][0].component = defocus;
      parameters = {parameter("presample[0].waves")};
    }
    if (olpf) {
      auto filter = Component<double>::make("birefringent_filter");
      const mtf::Unit* px = mtf::find_unit("px");
      *std::get<mtf::AxisPair<double>*>(filter.fields().front().value) = {{0.6, px}, {0.6, px}, false};
      sensor.add(mtf::Stage::presample, filter);
      parameters.push_back(parameter("presample[2].separation"));
    }
    const FitResult result = fit(data_of(sensor, edge_of(image, scene)), parameters);
    SCOPED_TRACE(one.file);
    EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
    // The bars are 5e-5 for a Gaussian and 1e-4 for a pupil; the truth itself is given to 1e-6.
    EXPECT_NEAR(fit_cases::mtf50_along(result.system, scene.angle_deg) / one.mtf50, 1.0, gaussian ? 1e-5 : 2e-5);
    for (std::size_t i = 0; i < one.frequency.size() && one.frequency[i] <= 0.5; ++i)
      EXPECT_NEAR(fit_cases::mtf_along(result.system, scene.angle_deg, one.frequency[i]), one.mtf[i], 5e-6);
    ++fitted;
  }
  EXPECT_GE(fitted, 14);
}

}  // namespace
}  // namespace calib
