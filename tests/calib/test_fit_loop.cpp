// SPDX-License-Identifier: Apache-2.0
// The loop closes: a sensor simulates edges, its file with other values is fitted to them, and simulates the same
// again. The study of scatter and coverage (tests/bench/bench_fit.cpp) runs in a short version, and in a long one on
// request.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mtf/plan/sensor_plan.h"

#include "tests/calib/fit_cases.h"
#include "tests/calib/fit_study.h"

namespace calib {
namespace {

using fit_cases::parameter;
using mtf::System;

constexpr std::int64_t kRatio = 8;  // scene samples a pixel

/// A half plane as a scene of fine samples, each the mean of what it covers.
mtf::Image half_plane(double angle_deg, std::int64_t width, std::int64_t height) {
  mtf::Image scene(width * kRatio, height * kRatio);
  const double a = angle_deg * std::numbers::pi / 180.0, c = std::cos(a), s = std::sin(a);
  const double big = std::max(std::abs(c), std::abs(s)), small = std::min(std::abs(c), std::abs(s));
  for (std::int64_t y = 0; y < scene.height(); ++y)
    for (std::int64_t x = 0; x < scene.width(); ++x) {
      const double d = c * (static_cast<double>(x) + 0.5 - 0.5 * static_cast<double>(scene.width())) +
                       s * (static_cast<double>(y) + 0.5 - 0.5 * static_cast<double>(scene.height()));
      // Area of a unit square on the bright side of a line at distance d: a trapezoid's integral.
      const double outer = 0.5 * (big + small), inner = 0.5 * (big - small), size = std::abs(d);
      double half = size >= outer   ? 0.5
                    : size <= inner ? size / big
                                    : 0.5 - (outer - size) * (outer - size) / (2.0 * big * small);
      scene.at(x, y) = static_cast<float>(0.2 + 0.6 * (0.5 + std::copysign(half, d)));
    }
  return scene;
}

mtf::Image simulate(const System<double>& system, const mtf::Image& scene) {
  const double step = system.frame.pitch_x_um / kRatio;
  mtf::PlanOptions options;
  options.tolerance = 1e-6;
  options.aperture.kind = mtf::SceneAperture::Kind::box;
  options.aperture.size = {{step, mtf::find_unit("um")}, {}, false};
  const mtf::SensorPlan plan = mtf::compile_sensor(system, {scene.width(), scene.height(), step, step}, options);
  const mtf::ImageView<const float> view = scene.view();
  return std::move(plan.run(std::span(&view, 1)).front());
}

TEST(FitLoop, SimulateFitSimulateAgrees) {
  System<double> truth = fit_cases::camera(8.0);
  truth.add(mtf::Stage::presample, mtf::test::jitter(0.3, "px"));
  truth.add(mtf::Stage::postsample, mtf::test::fir({{0, -0.1, 0}, {-0.1, 1.4, -0.1}, {0, -0.1, 0}}));
  System<double> start = truth;
  *parameter_at(start, "optics.f_number") = 9.5;
  *parameter_at(start, "presample[2].rms") = 0.15;
  std::vector<mtf::Image> images;
  FitData data;
  data.conditions.push_back(start);
  constexpr std::int64_t kSize = 160, kMargin = 32;
  for (const double angle : {6.0, 98.0}) {
    made::Scene scene;
    scene.width = scene.height = kSize;
    scene.angle_deg = angle;
    images.push_back(simulate(truth, half_plane(angle, kSize, kSize)));
    data.edges.push_back(fit_cases::edge_of(images.back(), scene, "edge at " + std::to_string(angle)));
    data.edges.back().roi = {kMargin, kMargin, kSize - 2 * kMargin, kSize - 2 * kMargin};
    data.edges.back().start.noise_sd = 1e-5;
  }
  const FitResult result =
      fit(data, std::vector{parameter("optics.f_number"), parameter("presample[2].rms", "jitter")});
  EXPECT_TRUE(result.status == FitStatus::converged || result.status == FitStatus::converged_model_wrong)
      << result.reason;
  EXPECT_NEAR(result.parameters[0].value, 8.0, 8e-3);
  EXPECT_NEAR(result.parameters[1].value, 0.3, 3e-3);
  const mtf::Image again = simulate(result.system, half_plane(31.0, 96, 96));
  const mtf::Image wanted = simulate(truth, half_plane(31.0, 96, 96));
  double most = 0.0;
  for (std::int64_t i = 0; i < again.size(); ++i)
    most = std::max(most, std::abs(static_cast<double>(again.data()[i]) - static_cast<double>(wanted.data()[i])));
  EXPECT_LT(most, 2e-5);  // of a contrast of 0.6
}

void expect_study(const fit_study::Outcome& o, double margin) {
  EXPECT_EQ(o.failed, 0);
  EXPECT_LE(o.flagged_wrong, 1);
  // sd of an sd over n draws: 1 / sqrt(2 n).
  const double scatter = margin / std::sqrt(2.0 * o.draws);
  EXPECT_LT(o.sd / o.bound, 1.1 + scatter);
  EXPECT_LT(o.sd_mtf50 / o.bound_mtf50, 1.1 + scatter);
  EXPECT_LT(std::abs(o.bias_mtf50), margin * o.sd_mtf50 / std::sqrt(o.draws) + 1e-3);
  const double n = o.draws, wide68 = margin * std::sqrt(0.68 * 0.32 / n), wide95 = margin * std::sqrt(0.95 * 0.05 / n);
  EXPECT_NEAR(o.cover68, 0.68, 0.02 + wide68);
  EXPECT_NEAR(o.cover68_mtf50, 0.68, 0.02 + wide68);
  EXPECT_NEAR(o.cover95, 0.95, 0.01 + wide95);
  EXPECT_NEAR(o.cover95_mtf50, 0.95, 0.01 + wide95);
}

TEST(FitStudy, ReachesTheCramerRaoBound) {
  for (const fit_study::Case& one : fit_study::cases()) {
    if (one.sagitta_px > 0.0 || one.model == fit_study::Model::wavefront) continue;  // slow
    SCOPED_TRACE(one.name);
    expect_study(fit_study::run(one, 40, 7), 3.5);
  }
}

TEST(FitStudyLong, ReachesTheCramerRaoBoundAndCovers) {
  for (const fit_study::Case& one : fit_study::cases()) {
    SCOPED_TRACE(one.name);
    const fit_study::Outcome o = fit_study::run(one, 2000, 20261121);
    expect_study(o, 1.0);
    EXPECT_NEAR(o.cover68, 0.68, 0.04);
    EXPECT_NEAR(o.cover95, 0.95, 0.025);
    EXPECT_LT(o.sd / o.bound, 1.1);
  }
}

}  // namespace
}  // namespace calib
