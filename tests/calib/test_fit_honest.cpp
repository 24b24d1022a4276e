// SPDX-License-Identifier: Apache-2.0
// What must not be given as known: units that a parameter has no part in, clipped pixels, starts and bounds that keep
// the fit from its minimum, spots that are none.
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
using mtf::System;

const std::vector<FitParameter> kSigma{parameter("presample[0].sigma", "gaussian.sigma")};

/// sigma of fit_cases::gaussian in its unit, from pixels of the camera's pitch.
CurveData gaussian_curve(const std::string& unit, double step, double sigma, double sd = 0.01) {
  CurveData curve{.name = "bench.csv",
                  .condition = 0,
                  .angle_deg = 90.0,
                  .unit = mtf::find_unit(unit),
                  .frequency = {},
                  .mtf = {},
                  .sd = {sd}};
  for (int i = 1; i <= 40; ++i) {
    curve.frequency.push_back(step * i);
    curve.mtf.push_back(std::exp(-2.0 * std::pow(std::numbers::pi * sigma * step * i, 2)));
  }
  return curve;
}

/// A Gaussian of 6 um whatever the pitch.
System<double> gaussian_um(double sigma_um) {
  System<double> system = fit_cases::bare();
  auto blur = mtf::Component<double>::make("gaussian");
  mtf::test::set(blur, "sigma", sigma_um, "um");
  system.add(mtf::Stage::presample, blur);
  return system;
}

TEST(FitHonest, ACurveInPixelsIsReadInThoseOfItsAxis) {
  FitData data;
  data.conditions.push_back(gaussian_um(4.0));
  data.conditions[0].frame.pitch_y_um = 2.0 * data.conditions[0].frame.pitch_x_um;
  data.curves.push_back(gaussian_curve("cy/px", 0.02, 6.0 / data.conditions[0].frame.pitch_y_um));
  EXPECT_NEAR(fit(data, kSigma).parameters[0].value, 6.0, 1e-4);
}

TEST(FitHonest, APitchHasNoPartInACurvePerMillimetre) {
  FitData data;
  data.conditions.push_back(gaussian_um(5.0));
  data.curves.push_back(gaussian_curve("cy/mm", 2.0, 6e-3));
  const FitResult result = fit(data, std::vector{parameter("frame.pitch")});
  EXPECT_EQ(result.parameters[0].knowledge, Knowledge::not_determined);
  data.curves[0].unit = mtf::find_unit("cy/mrad");
  const FitResult focal = fit(data, std::vector{parameter("frame.pitch")});
  EXPECT_EQ(focal.parameters[0].knowledge, Knowledge::not_determined);
  data.curves[0] = gaussian_curve("cy/px", 0.02, 6.0 / (1.2 * fit_cases::kPitch_um));
  data.conditions[0] = gaussian_um(6.0);
  const FitResult pitch = fit(data, std::vector{parameter("frame.pitch")});
  EXPECT_EQ(pitch.parameters[0].knowledge, Knowledge::determined);
  EXPECT_NEAR(pitch.parameters[0].value, 1.2 * fit_cases::kPitch_um, 1e-4);
}

TEST(FitHonest, APathOfTwoNumbersIsSetInBoth) {
  System<double> system = fit_cases::bare();
  EXPECT_TRUE(set_parameter(system, "frame.pitch", 7.0));
  EXPECT_EQ(system.frame.pitch_x_um, 7.0);
  EXPECT_EQ(system.frame.pitch_y_um, 7.0);
  EXPECT_FALSE(set_parameter(system, "presample[0].sigma", 1.0));
}

struct Edge {
  made::Scene scene;
  mtf::Image image;
  explicit Edge(double noise_sd = 0.01, std::int64_t width = 0, std::int64_t height = 0) {
    scene.noise_sd = noise_sd;
    scene.seed = 3;
    if (width > 0) scene.width = width, scene.height = height;
    image = made::make(made::Step::gaussian(0.3), scene);
  }
  FitData data(double sigma = 0.8) const { return data_of(fit_cases::gaussian(sigma), edge_of(image, scene)); }
};

TEST(FitHonest, ClippedPixelsDoNotCount) {
  Edge edge;
  const float most = 0.79F;  // the bright side is 0.8
  std::size_t clipped = 0;
  for (std::int64_t i = 0; i < edge.image.size(); ++i)
    if (edge.image.data()[i] >= most) edge.image.data()[i] = most, ++clipped;
  ASSERT_GT(clipped, 100u);
  FitData data = edge.data();
  const std::size_t all = fit(data, kSigma).data[0].count;
  data.edges[0].saturation = static_cast<double>(most);
  EXPECT_EQ(fit(data, kSigma).data[0].count, all - clipped);
}

TEST(FitHonest, ALongReachIsCutAndManyPixelsAreThinned) {
  const Edge edge(0.02, 700, 6000);
  FitData data = edge.data(0.1);  // sharp: 32 cycles/px over 700 px would be too many frequencies
  const FitResult result = fit(data, kSigma);
  EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
  EXPECT_LE(result.data[0].count, 1010000u);
  EXPECT_GT(result.data[0].count, 990000u);
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_NE(result.warnings[0].find("many pixels"), std::string::npos);
  EXPECT_NEAR(result.parameters[0].value, fit_cases::sigma_of(0.3), 4.0 * result.parameters[0].stderr_value.value());
}

}  // namespace
}  // namespace calib
