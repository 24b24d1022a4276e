// SPDX-License-Identifier: Apache-2.0
// What one edge determines and what it does not: standard deviations of a camera's parameters at a contrast-to-noise
// ratio of 60, edges of 100 px, offset, angle and two plateaus of each edge unknown as well.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "calib/fit/confidence/identifiability.h"
#include "tests/calib/fit_cases.h"
#include "tests/expect_error.h"

namespace calib {
namespace {

using fit_cases::parameter;
using mtf::System;

const std::map<std::string, std::string> kPaths{{"F/#", "optics.f_number"},
                                                {"pixel", "presample[1].width"},
                                                {"WFE", "presample[2].rms"},
                                                {"jitter", "presample[3].rms"},
                                                {"smear", "presample[4].travel"}};

struct Row {
  std::vector<std::string> names;
  std::vector<double> angles_deg;
  std::vector<double> sd_percent;          ///< of each, in the order of the names
  std::map<std::string, double> priors{};  ///< relative sd
  std::vector<std::string> not_determined{};
};

/// Noise-free images whose noise is said to be 0.01: the fit ends at the truth, and its errors are the Fisher bound.
FitResult fit_row(const Row& row) {
  const System<double> sensor = fit_cases::table_sensor(0.07, 0.25, 0.5);
  std::vector<mtf::Image> images;
  FitData data;
  data.conditions.push_back(sensor);
  for (const double angle : row.angles_deg) {
    made::Scene scene;
    scene.angle_deg = angle;
    if (std::abs(std::sin(angle * std::numbers::pi / 180.0)) > 0.8) std::swap(scene.width, scene.height);
    const made::Step step([&](double f) { return fit_cases::mtf_along(sensor, angle, f); }, 1.0 / 0.93, 120.0);
    images.push_back(made::make(step, scene));
    data.edges.push_back(fit_cases::edge_of(images.back(), scene, "edge at " + std::to_string(angle)));
    data.edges.back().start.noise_sd = 0.01;
  }
  std::vector<FitParameter> parameters;
  for (const std::string& name : row.names) {
    parameters.push_back(parameter(kPaths.at(name), name));
    System<double> copy = sensor;
    const double value = *parameter_at(copy, kPaths.at(name));
    if (row.priors.contains(name)) parameters.back().prior = {value, row.priors.at(name) * value};
  }
  return fit(data, parameters);
}

TEST(Identifiability, TableOfOneToFiveParameters) {
  const std::vector<Row> rows{
      {{"F/#"}, {5}, {1.0}},
      {{"jitter"}, {5}, {3.9}},
      {{"WFE"}, {5}, {1.9}},
      {{"smear"}, {5}, {11.7}},
      {{"pixel"}, {5}, {2.7}},
      {{"F/#", "jitter"}, {5}, {2.0, 7.7}},
      {{"WFE", "jitter"}, {5}, {2.9, 6.1}},
      {{"jitter", "smear"}, {5}, {236, 700}, {}, {"jitter", "smear"}},
      {{"jitter", "smear"}, {5, 95}, {3.8, 16}},
      {{"F/#", "WFE", "jitter"}, {5}, {25, 36, 26}, {}, {"F/#", "WFE", "jitter"}},
      {{"F/#", "WFE", "jitter"}, {5}, {2.0, 4.1, 6.4}, {{"F/#", 0.02}}},
      {{"WFE", "jitter", "smear"}, {5, 95}, {2.0, 4.9, 16}},
      {{"WFE", "jitter", "smear"}, {5, 50, 95}, {1.6, 4.1, 16}},
      {{"F/#", "WFE", "jitter", "smear", "pixel"},
       {5, 95},
       {76, 116, 83, 16, 101},
       {},
       {"F/#", "WFE", "jitter", "pixel"}},
      {{"F/#", "WFE", "jitter", "smear", "pixel"}, {5, 95}, {2.0, 3.5, 6.1, 16, 2.0}, {{"F/#", 0.02}, {"pixel", 0.02}}},
  };
  for (const Row& row : rows) {
    const FitResult result = fit_row(row);
    std::string label =
        std::to_string(row.angles_deg.size()) + " edges, " + std::to_string(row.priors.size()) + " priors:";
    for (const std::string& name : row.names) label += " " + name;
    SCOPED_TRACE(label);
    EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
    for (std::size_t i = 0; i < row.names.size(); ++i) {
      const FittedParameter& p = result.parameters[i];
      const double percent = 100.0 * p.linear_sd / p.value;
      // The table is given in two digits; where nothing is known, the size is what counts.
      EXPECT_NEAR(percent, row.sd_percent[i], (row.sd_percent[i] > 200.0 ? 0.15 : 0.04) * row.sd_percent[i] + 0.05)
          << row.names[i];
      const bool lost =
          std::find(row.not_determined.begin(), row.not_determined.end(), row.names[i]) != row.not_determined.end();
      EXPECT_EQ(p.knowledge == Knowledge::not_determined, lost) << row.names[i];
      EXPECT_EQ(p.stderr_value.has_value(), !lost) << row.names[i];
    }
    EXPECT_EQ(result.not_separable.empty(), row.not_determined.empty());
    // The curve is known, whichever parameters are fitted.
    EXPECT_LT(result.mtf_sd[50], 0.0042);
    EXPECT_LT(result.mtf_sd[100], 0.0075);
  }
}

TEST(Identifiability, JitterAndSmearInWords) {
  const FitResult one = fit_row({{"jitter", "smear"}, {5}, {}});
  ASSERT_EQ(one.not_separable.size(), 1u);
  const std::string& text = one.not_separable[0].text;
  expect_says(text, {"smear and jitter", "not separable", "moment is known (0.083"});  // 0.25^2 + 0.5^2 / 12
  expect_says(text, {"add an edge across"});
  EXPECT_LT(one.correlation[0][1], -0.999);

  // An edge across is not advised where it determines no more than another one along.
  const FitResult radial = fit_row({{"F/#", "WFE", "jitter"}, {5}, {}});
  ASSERT_FALSE(radial.not_separable.empty());
  EXPECT_FALSE(says(radial.not_separable[0].text, "add an edge across")) << radial.not_separable[0].text;
  expect_says(radial.not_separable[0].text, {"prior"});
  EXPECT_LT(radial.correlation[0][1], -0.99);
}

TEST(Identifiability, AParameterWithoutEffect) {
  // The travel is 0: its direction has nothing to turn.
  System<double> sensor = fit_cases::table_sensor(0.07, 0.25, 0.0);
  made::Scene scene;
  const made::Step step([&](double f) { return fit_cases::mtf_along(sensor, 5.0, f); }, 1.0 / 0.93, 120.0);
  const mtf::Image image = made::make(step, scene);
  EdgeData edge = fit_cases::edge_of(image, scene);
  edge.start.noise_sd = 0.01;
  const FitResult result =
      fit(fit_cases::data_of(sensor, edge),
          std::vector{parameter("presample[4].direction", "direction"), parameter("presample[3].rms")});
  EXPECT_EQ(result.parameters[0].knowledge, Knowledge::not_determined);
  EXPECT_EQ(result.parameters[1].knowledge, Knowledge::determined);
  ASSERT_EQ(result.not_separable.size(), 1u);
  expect_says(result.not_separable[0].text, {"direction is not determined"});
}

TEST(Identifiability, APureShiftIsTheEdgesOwnOffset) {
  System<double> sensor = fit_cases::camera(8.0);
  auto wavefront = mtf::Component<double>::make("wavefront");
  mtf::test::set(wavefront, "w311", 0.02);
  sensor.stages[0][0].component = wavefront;
  made::Scene scene;
  const made::Step step = made::camera_step(made::camera_of(8.0), scene.angle_deg);
  const mtf::Image image = made::make(step, scene);
  EdgeData edge = fit_cases::edge_of(image, scene);
  edge.start.noise_sd = 0.01;
  const FitResult result = fit(fit_cases::data_of(sensor, edge), std::vector{parameter("presample[0].w311", "tilt")});
  EXPECT_EQ(result.parameters[0].knowledge, Knowledge::not_determined);
}

TEST(Identifiability, DirectionsOfAKnownMatrix) {
  // x1 + x2 is known to 0.01, x1 - x2 to 10.
  const Eigen::Matrix2d v = (Eigen::Matrix2d() << 1, 1, 1, -1).finished() / std::sqrt(2.0);
  const Eigen::MatrixXd information = v * Eigen::Vector2d(1e4, 1e-2).asDiagonal() * v.transpose();
  const Identified identified = identify(information, std::vector{1.0, 1.0});
  ASSERT_EQ(identified.weak.size(), 1u);
  EXPECT_NEAR(std::abs(identified.weak[0].weight[0]), std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(identified.covariance(0, 0), 50.0, 0.01);
  EXPECT_FALSE(identified.determined[0]);
  EXPECT_TRUE(identify(information, std::vector{100.0, 100.0}).determined[0]);
  // No information at all is a direction like any other.
  EXPECT_EQ(identify(Eigen::MatrixXd::Zero(2, 2), std::vector{1.0, 1.0}).weak.size(), 2u);
}

}  // namespace
}  // namespace calib
