// SPDX-License-Identifier: Apache-2.0

// Optimisation against closed forms and against optima worked out with mpmath.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "apps/study/optimum/optimize.h"
#include "tests/apps/study/study_files.h"
#include "tests/expect_error.h"

namespace {

using namespace study;
using Status = OptimizeOutcome::Status;
using Method = OptimizeOptions::Method;

/// Two numbers of the study's own between the given ends.
std::string two_numbers(const std::string& x, const std::string& y) {
  return "[[axis]]\nname = \"x\"\n" + x + "\n[[axis]]\nname = \"y\"\n" + y + "\n[sampling]\nmethod = \"sobol\"\n" +
         "points = 16\n";
}
std::string goals(const std::string& objectives, const std::string& constraints = "") {
  return study_test::kHead + "constraints = [" + constraints + "]\nobjectives = [" + objectives + "]\n";
}

class Optimize : public testing::Test {
 protected:
  std::shared_ptr<const Study> read(const std::string& text) const {
    StudyResult result = folder_.parse(text);
    EXPECT_TRUE(result.ok()) << folder_.lines(text);
    return std::make_shared<Study>(std::move(result.study));
  }
  OptimizeOutcome best(const std::string& text, OptimizeOptions options = {}) {
    study_ = read(text);
    if (options.weights.empty()) options.weights.assign(study_->objectives.size(), 1.0);
    OptimizeOutcome outcome = optimize(*study_, options);
    words_.clear();
    for (const std::string& line : sentences(*study_, options, outcome)) words_ += line + "\n";
    return outcome;
  }

  study_test::Folder folder_;
  std::shared_ptr<const Study> study_;
  std::string words_;
};

const std::string kUnit = "from = 0.0\nto = 1.0";

// GSD = pitch x range / focal length: 8 um x 500 km / 0.5 m = 8000 mm, 16000 mm a metre.
TEST_F(Optimize, FocalLengthOfAGroundSampleDistance) {
  const OptimizeOutcome outcome = best(goals("\"minimize focal_length\"", "\"gsd < 0.5 m\"") +
                                       "[[axis]]\nparameter = \"focal_length\"\nfrom = \"1 m\"\nto = \"40 m\"\n"
                                       "count = 5\nscale = \"log\"\n[conditions]\nrange = \"500 km\"\n");
  EXPECT_EQ(outcome.status, Status::optimal) << words_;
  EXPECT_EQ(outcome.best.method, Method::smooth);
  EXPECT_NEAR(outcome.best.axis_values[0], 8000.0, 1e-3);
  EXPECT_GE(outcome.best.axis_values[0], 8000.0);  // < is kept
  ASSERT_EQ(outcome.best.limits.size(), 1U);
  EXPECT_EQ(outcome.best.limits[0].text, "gsd < 0.5 m");
  EXPECT_NEAR(outcome.best.limits[0].gain, 16e3, 1e-2);
  expect_says(words_, {"gsd < 0.5 m limits", "0.01 m", "focal_length by 160 mm"});
  EXPECT_EQ(outcome.best.starts, outcome.starts);
}

// A Gaussian of rms s along x has the MTF exp(-2 (pi s f)^2); s^2 times it is largest at s = 1 / (sqrt(2) pi f).
TEST_F(Optimize, InsideOfAllLimitsThroughTheChainOfMetrics) {
  folder_.write("gauss.toml",
                "schema = 1\n[frame]\nfocal_length = \"1 m\"\npitch = \"5 um\"\n[[presample]]\nkind = \"jitter\"\n"
                "rms = \"3 um\"\n");
  const OptimizeOutcome outcome = best(
      "schema = 1\nsensor = \"gauss.toml\"\nobjectives = [\"maximize (jitter.rms / (1 um)) ^ 2 * "
      "mtf_at_50_cy_mm_x\"]\n[[axis]]\nparameter = \"jitter.rms\"\nfrom = \"1 um\"\nto = \"20 um\"\ncount = 5\n");
  EXPECT_EQ(outcome.status, Status::optimal) << words_;
  // The slope is right to some 1e-9, the place of the optimum so to its root's share of the curvature.
  EXPECT_NEAR(outcome.best.axis_values[0], 1e3 / (std::numbers::sqrt2 * std::numbers::pi * 50.0), 1e-5);
  EXPECT_TRUE(outcome.best.limits.empty());
  expect_says(words_, {"nothing limits"});
}

std::string rosenbrock(const std::string& squared_radius) {
  return goals("\"minimize (1 - x)^2 + 100 * (y - x^2)^2\"", "\"x^2 + y^2 <= " + squared_radius + "\"") +
         two_numbers("from = -1.5\nto = 1.5", "from = -1.5\nto = 1.5");
}

// Rosenbrock's valley in a disc: the point and the multiplier are the roots of its stationarity by mpmath.
TEST_F(Optimize, RosenbrockInADisc) {
  const OptimizeOutcome outcome = best(rosenbrock("1"));
  EXPECT_EQ(outcome.status, Status::optimal) << words_;
  EXPECT_NEAR(outcome.best.axis_values[0], 0.78641515416842783, 1e-6);
  EXPECT_NEAR(outcome.best.axis_values[1], 0.61769831252339348, 1e-6);
  EXPECT_NEAR(outcome.best.objectives[0], 0.04567480871950029, 3e-8);
  ASSERT_EQ(outcome.best.limits.size(), 1U);
  EXPECT_NEAR(outcome.best.limits[0].gain, 0.12149655699928839, 1e-6);
  // The same against optima of a little more and a little less room.
  const double more = best(rosenbrock("1.001")).best.objectives[0], less = best(rosenbrock("0.999")).best.objectives[0];
  EXPECT_NEAR(outcome.best.limits[0].gain, (less - more) / 0.002, 1e-4 * outcome.best.limits[0].gain);
}

TEST_F(Optimize, EndsOfAxes) {
  const OptimizeOutcome outcome =
      best(goals("\"minimize x - 3 * y + x * y\"") + two_numbers("from = 2.0\nto = 5.0", "from = 10.0\nto = 30.0"));
  // d/dx = 1 + y > 0 and at x = 2 d/dy = -1: the corner (2, 30), F = 2 - 90 + 60.
  EXPECT_EQ(outcome.status, Status::optimal) << words_;
  EXPECT_EQ(outcome.best.axis_values, (std::vector<double>{2.0, 30.0}));
  EXPECT_NEAR(outcome.best.objectives[0], -28.0, 1e-9);
  ASSERT_EQ(outcome.best.limits.size(), 2U);
  EXPECT_EQ(outcome.best.limits[0].text, "x >= 2");
  EXPECT_NEAR(outcome.best.limits[0].gain, 31.0, 1e-9);
  EXPECT_EQ(outcome.best.limits[1].text, "y <= 30");
  EXPECT_NEAR(outcome.best.limits[1].gain, 1.0, 1e-9);
}

// 25 (x - 0.2)^2 + (0.6 - x)^2 / 0.36, each in the size of its limit, is least at x = 0.24.
TEST_F(Optimize, NearestDesignOfConstraintsThatContradict) {
  const OptimizeOutcome outcome =
      best(goals("\"minimize y\"", "\"x < 0.2\", \"x > 0.6\", \"y > 0.1\"") + two_numbers(kUnit, kUnit));
  EXPECT_EQ(outcome.status, Status::infeasible);
  EXPECT_NEAR(outcome.best.axis_values[0], 0.24, 1e-6);
  EXPECT_EQ(outcome.contradiction, (std::vector<std::string>{"x < 0.2", "x > 0.6"}));
  ASSERT_EQ(outcome.best.violations.size(), 2U);
  EXPECT_NEAR(outcome.best.violations[1].share, 0.6, 1e-5);
  expect_says(words_, {"contradict", "x < 0.2", "x > 0.6"});
}

TEST_F(Optimize, OneConstraintAgainstTheBox) {
  const OptimizeOutcome outcome = best(goals("\"minimize y\"", "\"x + y > 3\"") + two_numbers(kUnit, kUnit));
  EXPECT_EQ(outcome.status, Status::infeasible);
  EXPECT_EQ(outcome.best.axis_values, (std::vector<double>{1.0, 1.0}));
  EXPECT_EQ(outcome.contradiction, (std::vector<std::string>{"x + y > 3", "x <= 1", "y <= 1"}));
}

TEST_F(Optimize, LevelsOfDiscreteAxes) {
  const std::string axes =
      "[[axis]]\nparameter = \"adc.bits\"\nvalues = [8, 10, 12, 14]\n[[axis]]\nname = \"x\"\nfrom = 0.0\nto = 10.0\n"
      "count = 3\n";
  const OptimizeOutcome outcome =
      best(goals("\"minimize (x - 6.5)^2 + 0.1 * adc.bits\"", "\"adc.bits + x > 17\"") + axes);
  // 8: x > 9, 6.25 + 0.8; 10: x > 7, 0.25 + 1.0; 12: 0 + 1.2; 14: 0 + 1.4.
  EXPECT_EQ(outcome.status, Status::optimal) << words_;
  EXPECT_EQ(study_->axes[0].levels.at(static_cast<std::size_t>(outcome.best.axis_values[0])), "12");
  EXPECT_NEAR(outcome.best.axis_values[1], 6.5, 1e-5);
  EXPECT_NEAR(outcome.best.objectives[0], 1.2, 1e-9);
  ASSERT_GE(outcome.others.size(), 3U);
  EXPECT_NEAR(outcome.others[0].objectives[0], 1.25, 5e-6);  // 10 bits, kept off its constraint by 1e-7
}

TEST_F(Optimize, KinksBySearch) {
  const std::string text =
      goals("\"minimize max(abs(x - 0.3), 2 * abs(y - 0.6)) + 0.5 * abs(x - y)\"", "\"x + y <= 0.8\"") +
      two_numbers(kUnit, kUnit);
  // With both kinks out of reach: on x + y = 0.8, y = 0.8 - x. F = max(|x - 0.3|, 2 |0.2 - x|) + |x - 0.4|, least where
  // 0.3 - x = 2 (x - 0.2): x = 7/30, F = 1/15 + 1/6.
  for (const Method method : {Method::smooth, Method::search}) {
    const OptimizeOutcome outcome = best(text, {.method = method});
    EXPECT_TRUE(outcome.best.feasible);
    EXPECT_EQ(outcome.best.method, Method::search) << words_;
    EXPECT_EQ(outcome.status, Status::stopped);
    EXPECT_NEAR(outcome.best.objectives[0], 7.0 / 30.0, 1e-5);
    EXPECT_NEAR(outcome.best.axis_values[0], 7.0 / 30.0, 1e-4);
    EXPECT_EQ(outcome.best.why.empty(), method == Method::search);
  }
}

// 4 x (x^2 - 1) + 0.1 = 0 has two roots that are minima; by mpmath.
TEST_F(Optimize, SeveralOptima) {
  const OptimizeOutcome outcome =
      best(goals("\"minimize (x^2 - 1)^2 + 0.1 * x\"") + "[[axis]]\nname = \"x\"\nfrom = -2.0\nto = 2.0\ncount = 3\n");
  EXPECT_EQ(outcome.status, Status::optimal) << words_;
  EXPECT_NEAR(outcome.best.axis_values[0], -1.0122731310326814, 1e-6);
  ASSERT_EQ(outcome.others.size(), 1U);
  EXPECT_NEAR(outcome.others[0].axis_values[0], 0.9872574766623533, 1e-6);
  EXPECT_EQ(outcome.best.starts + outcome.others[0].starts, 8);
}

TEST_F(Optimize, SameForAnyThreads) {
  for (const Method method : {Method::smooth, Method::search}) {
    const OptimizeOutcome one = best(rosenbrock("1"), {.method = method, .threads = 1});
    for (const int threads : {2, 5}) {
      const OptimizeOutcome more = best(rosenbrock("1"), {.method = method, .threads = threads});
      EXPECT_EQ(one.best.axis_values, more.best.axis_values);
      EXPECT_EQ(one.evaluations, more.evaluations);
      ASSERT_EQ(one.others.size(), more.others.size());
      for (std::size_t i = 0; i < one.others.size(); ++i)
        EXPECT_EQ(one.others[i].axis_values, more.others[i].axis_values);
    }
  }
}

// Half of the box has no design: a root of a negative number, and an obscuration that no pupil can have.
TEST_F(Optimize, DesignsThatCannotBe) {
  const OptimizeOutcome inside =
      best(goals("\"minimize (x - 0.7)^2 - 0.1 * sqrt(y - 0.5) + (y - 0.8)^2\"") + two_numbers(kUnit, kUnit));
  EXPECT_EQ(inside.status, Status::optimal) << words_;
  EXPECT_NEAR(inside.best.axis_values[0], 0.7, 1e-6);
  const double y = inside.best.axis_values[1];
  EXPECT_NEAR(2.0 * (y - 0.8), 0.05 / std::sqrt(y - 0.5), 1e-5);

  const OptimizeOutcome edge = best(goals("\"maximize x\"") +
                                    "[[axis]]\nname = \"x\"\nfrom = 0.0\nto = 3.0\ncount = 3\n[links]\n"
                                    "optics.obscuration = \"x\"\n");
  EXPECT_EQ(edge.status, Status::stopped);
  EXPECT_NEAR(edge.best.axis_values[0], 0.999, 1e-6);  // the most that the sensor file takes
  expect_says(words_, {"obscuration"});

  const OptimizeOutcome none = best(goals("\"minimize x + sqrt(y - 2)\"") + two_numbers(kUnit, kUnit));
  EXPECT_EQ(none.status, Status::impossible);
  EXPECT_FALSE(none.problem.empty());
}

TEST_F(Optimize, SlopesOfObjectivesAndMargins) {
  study_ = read(goals("\"maximize mtf_nyquist\", \"minimize focal_length\"",
                      "\"netd < 50 mK\", \"2 * gsd >= 1 m + 0.001 * focal_length\"") +
                "[[axis]]\nparameter = \"optics.aperture\"\nfrom = \"100 mm\"\nto = \"400 mm\"\ncount = 3\n"
                "[[axis]]\nparameter = \"frame.pitch\"\nfrom = \"5 um\"\nto = \"15 um\"\ncount = 3\n"
                "[links]\nfocal_length = \"9 * aperture\"\n[conditions]\nrange = \"500 km\"\n");
  auto sharp = std::make_shared<Study>(*study_);
  sharp->tolerance = 1e-12;
  Evaluator evaluator(sharp);
  std::vector<double> row(columns_of(*sharp).size()), at{250.0, 9.0};
  const Gradient gradient = evaluator.gradient_at(at);
  ASSERT_EQ(gradient.objective.size(), 4U);
  ASSERT_EQ(gradient.margin.size(), 4U);
  const auto values = [&](double aperture, double pitch) {
    evaluator.evaluate_at(std::vector<double>{aperture, pitch}, row);
    std::vector<double> all(evaluator.last_objectives().begin(), evaluator.last_objectives().end());
    for (std::size_t j = 0; j < 2; ++j) all.push_back(evaluator.last_sides()[j].margin(sharp->constraints[j].less));
    return all;
  };
  const auto nothing = values(250.0, 9.0);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const double h = 1e-4 * at[axis];
    const auto up = values(at[0] + (axis == 0 ? h : 0.0), at[1] + (axis == 1 ? h : 0.0));
    const auto down = values(at[0] - (axis == 0 ? h : 0.0), at[1] - (axis == 1 ? h : 0.0));
    for (std::size_t k = 0; k < 4; ++k) {
      if (!std::isfinite(nothing[k])) continue;
      const double slope = k < 2 ? gradient.objective[k * 2 + axis] : gradient.margin[(k - 2) * 2 + axis];
      // Second-order differences over 1e-4, values to 1e-12.
      EXPECT_NEAR(slope, (up[k] - down[k]) / (2.0 * h), 1e-6 * (std::abs(slope) + std::abs(nothing[k] / at[axis])))
          << k << " by " << axis;
    }
  }
}

TEST_F(Optimize, Refusals) {
  const std::string axes = two_numbers(kUnit, kUnit);
  const auto refused = [&](const std::string& text, const OptimizeOptions& options, const std::string& word) {
    const auto study = read(text);
    expect_refused({word}, [&] { static_cast<void>(optimize(*study, options)); });
  };
  refused(study_test::kHead + axes + study_test::kMetrics, {.weights = {}}, "no objectives");
  refused(goals("\"minimize x\", \"minimize y\"") + axes, {.weights = {1.0}}, "1 weights for 2");
  refused(goals("\"minimize x\"") + axes, {.weights = {0.0}}, "all are 0");
  refused(goals("\"minimize x\"") + axes, {.weights = {-1.0}}, ">= 0");
  std::string levels = "1";
  for (int i = 2; i <= 15; ++i) levels += ", " + std::to_string(i);
  refused(goals("\"minimize x\"") + "[[axis]]\nparameter = \"adc.bits\"\nvalues = [" + levels +
              "]\n[[axis]]\nparameter = \"frame.format\"\nvalues = [[640, 512], [320, 256], [1, 1], [2, 2], [3, 3], "
              "[4, 4], [5, 5], [6, 6], [7, 7], [8, 8], [9, 9], [10, 10], [11, 11], [12, 12]]\n" +
              axes,
          {.weights = {1.0}}, "210 combinations");
}

}  // namespace
