// SPDX-License-Identifier: Apache-2.0
// What must not be reported as known: units that a parameter has no part in, clipped pixels, starts and bounds that
// keep the fit from its minimum, spots that are none.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <list>
#include <numbers>
#include <random>

#include "mtf/error.h"
#include "tests/calib/fit_cases.h"
#include "tests/expect_error.h"

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

/// A Gaussian of 6 um at any pitch.
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

struct Made {
  made::Scene scene;
  mtf::Image image;
};

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

TEST(FitHonest, EdgesOfAnyBrightness) {
  Edge edge;
  const FittedParameter plain = fit(edge.data(), kSigma).parameters[0];
  for (std::int64_t i = 0; i < edge.image.size(); ++i) edge.image.data()[i] *= 1e20F;
  FitData data = edge.data();
  EdgeMeasurement& start = data.edges[0].start;
  for (double* number : {&start.dark, &start.bright, &start.noise_sd}) *number *= 1e20;
  const FitResult vast = fit(data, kSigma);
  EXPECT_EQ(vast.status, FitStatus::converged) << vast.reason;
  EXPECT_NEAR(vast.parameters[0].value, plain.value, 0.05 * plain.stderr_value.value());
}

TEST(FitHonest, PixelsFarAwayAreCutAndManyPixelsAreThinned) {
  const Edge edge(0.02, 700, 6000);
  FitData data = edge.data(0.1);  // sharp: 32 cycles/px over 700 px would be too many frequencies
  const FitResult result = fit(data, kSigma);
  EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
  EXPECT_LE(result.data[0].count, 1010000u);
  EXPECT_GT(result.data[0].count, 990000u);
  ASSERT_FALSE(result.warnings.empty());
  expect_says(result.warnings[0], {"many pixels"});
  EXPECT_NEAR(result.parameters[0].value, fit_cases::sigma_of(0.3), 4.0 * result.parameters[0].stderr_value.value());
}

struct Spot {
  mtf::Image image;
  FitData data;
  /// A Gaussian of 0.6 px, or two, in units of `unit`.
  explicit Spot(double unit = 1.0, std::int64_t side = 32, double sigma = 0.6, double second = 0.0, double most = 1e9)
      : image(side, side) {
    std::mt19937_64 bits(5);
    std::normal_distribution<double> normal(0.0, 0.005);
    const auto bell = [&](double x, double y, double x0, double y0) {
      return std::exp(-((x - x0) * (x - x0) + (y - y0) * (y - y0)) / (2.0 * sigma * sigma));
    };
    for (std::int64_t y = 0; y < side; ++y)
      for (std::int64_t x = 0; x < side; ++x) {
        const double px = static_cast<double>(x) + 0.5, py = static_cast<double>(y) + 0.5;
        const double light = bell(px, py, 16.2, 15.7) + second * bell(px, py, 8.2, 9.7);
        image.at(x, y) = static_cast<float>(unit * std::min(most, 0.1 + light + normal(bits)));
      }
    data.conditions.push_back(fit_cases::gaussian(0.2));
    data.spots.push_back({.name = "star", .image = image.view(), .roi = {0, 0, side, side}, .condition = 0});
  }
};

TEST(FitHonest, SpotsOfAnyBrightnessAndSizeLeadToTheirWidth) {
  for (const int kind : {0, 1, 2, 3, 4}) {
    Spot spot(kind == 1 ? 1e30 : kind == 2 ? 1e-20 : 1.0, kind == 3 ? 200 : 32);
    if (kind == 4) spot.image.at(14, 15) = std::numeric_limits<float>::quiet_NaN();
    const FitResult result = fit(spot.data, kSigma);
    EXPECT_EQ(result.status, FitStatus::converged) << kind << " " << result.reason;
    EXPECT_NEAR(result.parameters[0].value, 0.6, 4.0 * result.parameters[0].stderr_value.value_or(0.0)) << kind;
    EXPECT_LT(result.parameters[0].stderr_value.value_or(1.0), 0.01) << kind;
    EXPECT_EQ(result.warnings.empty(), kind != 3) << kind;
  }
}

// A pixel at the end of the scale holds less light than fell on it.
TEST(FitHonest, ClippedPixelsOfSpotsDoNotCount) {
  Spot spot(1.0, 32, 0.6, 0.0, 0.5);  // two pixels have more
  spot.data.spots[0].saturation = 0.5;
  const FitResult clipped = fit(Spot(1.0, 32, 0.6, 0.0, 0.5).data, kSigma);
  EXPECT_GT(std::abs(clipped.parameters[0].value - 0.6), 0.05);
  const FitResult result = fit(spot.data, kSigma);
  EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
  EXPECT_NEAR(result.parameters[0].value, 0.6, 4.0 * result.parameters[0].stderr_value.value_or(0.0));
}

// 3e5 electrons of light over 100 of background with read noise 3: the noise of the peak is a hundred times that of the
// rim. Of 12 draws the rms of errors over their standard deviation lies in 0.49 to 1.65 with 99.9 %; it was 5.
TEST(FitHonest, ErrorsOfSpotsHoldWithTheNoiseOfTheirLight) {
  constexpr int kDraws = 12;
  double squares = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Spot spot;
    std::mt19937_64 bits(100 + static_cast<std::uint64_t>(draw));
    std::normal_distribution<double> read(0.0, 3.0);
    for (std::int64_t y = 0; y < 32; ++y)
      for (std::int64_t x = 0; x < 32; ++x) {
        const double dx = static_cast<double>(x) + 0.5 - 16.2, dy = static_cast<double>(y) + 0.5 - 15.7;
        const double light = 3e5 / (2.0 * std::numbers::pi * 0.36) * std::exp(-(dx * dx + dy * dy) / 0.72);
        std::poisson_distribution<int> electrons(100.0 + light);
        spot.image.at(x, y) = static_cast<float>(electrons(bits) + read(bits));
      }
    const FitResult result = fit(spot.data, kSigma);
    EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
    const double sd = result.parameters[0].stderr_value.value_or(1e-9);
    squares += (result.parameters[0].value - 0.6) * (result.parameters[0].value - 0.6) / (sd * sd * kDraws);
  }
  EXPECT_GT(std::sqrt(squares), 0.49);
  EXPECT_LT(std::sqrt(squares), 1.65);
}

TEST(FitHonest, SaturatedAndDoubleSpotsAreNoPsf) {
  const Spot saturated(1.0, 32, 1.5, 0.0, 0.4);
  EXPECT_EQ(fit(saturated.data, kSigma).status, FitStatus::no_data);
  expect_says(fit(saturated.data, kSigma).reason, {"saturated"});
  const Spot pair(1.0, 32, 0.6, 0.9);
  EXPECT_NE(fit(pair.data, kSigma).status, FitStatus::converged);
}

TEST(FitHonest, CurvesAreJudgedByTheirStandardDeviation) {
  FitData data;
  data.conditions.push_back(gaussian_um(4.0));
  data.curves.push_back(gaussian_curve("cy/mm", 2.0, 6e-3));
  EXPECT_EQ(fit(data, kSigma).status, FitStatus::converged);  // exact to rounding: no structure that counts
  for (std::size_t i = 0; i < 40; ++i) data.curves[0].mtf[i] = std::max(0.0, 1.0 - 0.02 * static_cast<double>(i));
  data.curves[0].sd = {0.002};
  const FitResult wrong = fit(data, kSigma);
  EXPECT_EQ(wrong.status, FitStatus::converged_model_wrong);
  expect_says(wrong.reason, {"that was given"});
}

TEST(FitHonest, AStartFarOffIsBroughtNearOrSaidToBe) {
  const Edge edge;
  FitData data = edge.data(1e5);
  EXPECT_EQ(fit(data, kSigma).status, FitStatus::not_converged);
  data.edges[0].start.mtf50 = Estimate{0.29, 0.01};
  const FitResult near = fit(data, kSigma);
  EXPECT_EQ(near.status, FitStatus::converged) << near.reason;
  EXPECT_NEAR(near.parameters[0].value, fit_cases::sigma_of(0.3), 4.0 * near.parameters[0].stderr_value.value());
}

TEST(FitHonest, BoundsAndPriorsThatHoldTheFitAreNamed) {
  const Edge edge;
  std::vector<FitParameter> parameters = kSigma;
  parameters[0].min = 0.8;
  const FitResult low = fit(edge.data(0.9), parameters);
  EXPECT_EQ(low.parameters[0].knowledge, Knowledge::at_bound);
  EXPECT_EQ(low.parameters[0].value, 0.8);
  EXPECT_TRUE(low.parameters[0].limit_is_upper);
  expect_says(low.reason, {"lower bound of gaussian.sigma"});
  parameters[0].min.reset();
  parameters[0].max = 0.5;
  const FitResult high = fit(edge.data(0.4), parameters);
  EXPECT_FALSE(high.parameters[0].limit_is_upper);
  expect_says(high.reason, {"the upper bound"});
  parameters[0].max.reset();
  parameters[0].prior = {5.0, 0.01};
  const FitResult prior = fit(edge.data(), parameters);
  ASSERT_FALSE(prior.warnings.empty());
  expect_says(prior.warnings.back(), {"contradicts the data"});
  parameters[0].prior = {2.0, 1e-300};
  EXPECT_THROW(fit(edge.data(), parameters), mtf::UsageError);
  parameters[0].prior = {-5.0, 1.0};
  EXPECT_THROW(fit(edge.data(), parameters), mtf::UsageError);
}

TEST(FitHonest, ADirectionIsGivenWithinHalfItsPeriod) {
  // Three edges of a camera with a motion along x.
  FitData data;
  const System<double> truth = fit_cases::table_sensor(0.0, 0.2, 0.6);
  std::list<Made> all;
  for (const double angle : {4.0, 86.0, 41.0}) {
    Made& made = all.emplace_back();
    made.scene.angle_deg = angle;
    made.scene.noise_sd = 0.004;
    made.scene.seed = static_cast<std::uint64_t>(angle);
    const made::Step step([&](double f) { return fit_cases::mtf_along(truth, angle, f); }, 1.0 / 0.93, 120.0);
    made.image = made::make(step, made.scene);
    data.edges.push_back(edge_of(made.image, made.scene));
  }
  const std::vector<FitParameter> three{parameter("presample[3].rms", "jitter"),
                                        parameter("presample[4].travel", "smear"),
                                        parameter("presample[4].direction", "direction")};
  for (const double start_deg : {5.0, 20.0, -30.0, 60.0}) {
    data.conditions = {truth};
    ASSERT_TRUE(set_parameter(data.conditions[0], three[2].path, start_deg));
    const FitResult result = fit(data, three);
    EXPECT_EQ(result.parameters[2].knowledge, Knowledge::determined)
        << start_deg << " " << result.parameters[0].value << " " << result.parameters[1].value << " "
        << result.parameters[2].value << " " << result.reason;
    EXPECT_NEAR(result.parameters[2].value, 0.0, 4.0 * result.parameters[2].stderr_value.value_or(0.0)) << start_deg;
    if (start_deg != 20.0) continue;
    // Two edges leave it open: their second moments are also those of motions without jitter, at 36
    // and at -38 degrees.
    FitData two = data;
    two.edges.pop_back();
    const FittedParameter open = fit(two, three).parameters[2];
    EXPECT_NE(open.knowledge, Knowledge::determined) << start_deg;
    if (!open.interval95) continue;
    EXPECT_NEAR((*open.interval95)[0], -38.0, 4.0) << start_deg;  // sd of the direction with all edges: 3.6
    EXPECT_NEAR((*open.interval95)[1], 36.0, 4.0) << start_deg;
  }
}

TEST(FitHonest, TheEquivalentVarianceKnowsItsOwnError) {
  const Edge edge(0.0);
  FitData data = edge.data(fit_cases::sigma_of(0.3));
  data.edges[0].start.noise_sd = 1e-9;
  const FitResult result = fit(data, kSigma);
  const double sigma = result.parameters[0].value;
  ASSERT_TRUE(result.equivalent_variance_px2.has_value());
  EXPECT_NEAR(result.equivalent_variance_px2->value, sigma * sigma, 3.0 * result.equivalent_variance_px2->sd + 1e-13);
}

}  // namespace
}  // namespace calib
