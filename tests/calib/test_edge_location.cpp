// SPDX-License-Identifier: Apache-2.0

// The curve of a measured edge lies where the edge is, to within its standard deviation.

#include <gtest/gtest.h>

#include <cmath>

#include "calib/measure/measure.h"
#include "tests/calib/made_edges.h"

namespace calib {
namespace {

// z has an rms of 1; over 200 draws it scatters by 1/sqrt(400) = 0.05, the bounds are four of that.
TEST(EdgeLocation, ScattersByItsStandardDeviation) {
  constexpr int kDraws = 200;
  for (const double angle_deg : {5.0, 38.0, 95.0}) {
    const made::Step step = made::camera_step(made::camera_of(5.6), angle_deg);
    double sum = 0.0, squares = 0.0;
    for (int draw = 0; draw < kDraws; ++draw) {
      const made::Scene scene{.angle_deg = angle_deg,
                              .x = 64.0 + 0.01 * draw,
                              .y = 50.0,
                              .noise_sd = 0.03,
                              .seed = static_cast<std::uint64_t>(7000 + draw)};
      const mtf::Image image = made::make(step, scene);
      const EdgeMeasurement edge = measure_edge(image.view(), {0, 0, image.width(), image.height()});
      ASSERT_EQ(edge.trouble, Trouble::none) << edge.reason;
      ASSERT_TRUE(edge.location_sd_px.has_value());
      const double z = made::distance(scene, edge.curve.origin.x, edge.curve.origin.y) / *edge.location_sd_px;
      sum += z;
      squares += z * z;
    }
    EXPECT_NEAR(sum / kDraws, 0.0, 4.0 / std::sqrt(kDraws)) << angle_deg;
    EXPECT_NEAR(std::sqrt(squares / kDraws), 1.0, 0.2) << angle_deg;
  }
}

}  // namespace
}  // namespace calib
