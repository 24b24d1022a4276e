// SPDX-License-Identifier: Apache-2.0
// The images that the tests of measurements use, against closed forms and the public set.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/calib/made_edges.h"
#include "tests/calib/public_edges.h"

TEST(MadeEdges, TheTableIsTheClosedFormOfAGaussian) {
  const made::Step gaussian = made::Step::gaussian(0.3);
  const made::Step table([&](double f) { return gaussian.mtf(f); }, 2.4, 60.0);
  for (double d = -59.0; d < 59.0; d += 0.1373) EXPECT_NEAR(table.at(d), gaussian.at(d), 1e-9) << d;
}

// E - 1 -> -2 S / (pi^3 d): the cusp of diffraction at frequency zero.
TEST(MadeEdges, DiffractionHasItsTail) {
  for (const double f_number : {2.8, 8.0, 16.0}) {
    const made::Camera camera = made::camera_of(f_number);
    const made::Step step = made::camera_step(camera, 4.0);
    const double tail = 2.0 * camera.s / std::pow(std::numbers::pi, 3);
    EXPECT_NEAR((1.0 - step.at(40.0)) * 40.0 / tail, 1.0, 2e-3) << f_number;
    EXPECT_NEAR(step.at(-40.0) + step.at(40.0), 1.0, 1e-14);
  }
}

TEST(MadeEdges, HaveTheMtfOfThePublicSet) {
  const auto all = public_edges::cases();
  if (all.empty()) GTEST_SKIP() << "no shared data";
  const auto crossing_of = [&](const std::string& file) {
    for (const auto& one : all)
      if (one.file == file) return one.mtf50;
    return 0.0;
  };
  made::Camera camera = made::camera_of(8.0);
  EXPECT_NEAR(made::camera_step(camera, 30.0).crossing(0.5), crossing_of("ex_ab_f8_a30.png"), 2e-6);
  camera.w020 = 0.3;
  EXPECT_NEAR(made::camera_step(camera, 5.0).crossing(0.5), crossing_of("ex_wf_f8_a05.png"), 2e-6);
  camera = made::camera_of(5.6);
  camera.olpf = 0.25;
  EXPECT_NEAR(made::camera_step(camera, 4.0).crossing(0.5), crossing_of("ex_olpf_f5p6_a04.png"), 2e-6);
}

// The public image is rounded to 16 bits and how it was made was checked to 1.1e-6 of full scale.
TEST(MadeEdges, HaveThePixelsOfThePublicSet) {
  const auto all = public_edges::cases();
  if (all.empty()) GTEST_SKIP() << "no shared data";
  for (const auto& one : all) {
    if (one.file != "ex_ab_f8_a08.png" && one.file != "ex_g30_a05_curved.png") continue;
    const mtf::Image image = public_edges::read(one);
    const made::Step step =
        one.psf == "gaussian" ? made::Step::gaussian(0.3) : made::camera_step(made::camera_of(8.0), one.angle_deg);
    // The set's angle has the opposite sign; its half length is that of the edge inside the image.
    const double half_length = 0.5 * 100.0 / std::cos(one.angle_deg * std::numbers::pi / 180.0);
    const made::Scene scene{.width = image.width(),
                            .height = image.height(),
                            .angle_deg = -one.angle_deg,
                            .x = one.x,
                            .y = one.y,
                            .sagitta_px = one.sagitta_px,
                            .half_length_px = half_length};
    const mtf::Image made = made::make(step, scene);
    double worst = 0.0;
    for (std::int64_t i = 0; i < image.size(); ++i)
      worst = std::max(worst, std::abs(static_cast<double>(made.data()[i]) - static_cast<double>(image.data()[i])));
    EXPECT_LT(worst, one.sagitta_px > 0.0 ? 2e-4 : 1.2e-5) << one.file;
  }
}
