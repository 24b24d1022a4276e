// SPDX-License-Identifier: Apache-2.0

// `mtf measure`: the lateral shift between the planes of a colour image.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "mtf/io/image_io.h"
#include "tests/apps/command.h"
#include "tests/calib/made_edges.h"

namespace apps_test {
namespace {

using Json = nlohmann::json;

constexpr double kAngle_deg = 5.0;

mtf::Image plane(double mtf50_cy_px, double x, std::uint64_t seed) {
  return made::make(made::Step::gaussian(mtf50_cy_px),
                    {.angle_deg = kAngle_deg, .x = x, .y = 50.0, .noise_sd = 0.005, .seed = seed});
}

void write_rgb(const Scratch& scratch, double x_red, double x_blue) {
  const mtf::Image red = plane(0.25, x_red, 1), green = plane(0.3, 64.0, 2), blue = plane(0.2, x_blue, 3);
  mtf::io::write_exr((scratch / "rgb.exr").string(), {{"R", red.view()}, {"G", green.view()}, {"B", blue.view()}}, {});
}

TEST(LateralColour, IsTheDisplacementOfThePlanes) {
  const Scratch scratch;
  write_rgb(scratch, 64.3, 63.1);
  const std::string measure = "mtf measure rgb.exr --channel all --roi 20,10,90,80 ";
  const auto result = scratch.run(measure + "--format json");
  ASSERT_EQ(result.status, 0) << result.err;
  const Json report = Json::parse(result.out);
  int shifted = 0;
  for (const Json& edge : report.at("edges")) {
    const std::string channel = edge.at("channel");
    if (channel == "G") {
      EXPECT_FALSE(edge.contains("lateral_shift"));
      continue;
    }
    const Json& shift = edge.at("lateral_shift");
    EXPECT_EQ(shift.at("from"), "G");
    const double truth = (channel == "R" ? 0.3 : -0.9) * std::cos(kAngle_deg * std::numbers::pi / 180.0);
    const double sd = shift.at("sd");
    EXPECT_NEAR(shift.at("value").get<double>(), truth, 4.0 * sd) << channel;
    EXPECT_GT(sd, 1e-5);
    EXPECT_LT(sd, 0.01);
    ++shifted;
  }
  EXPECT_EQ(shifted, 2);

  const std::string table = scratch.run(measure).out;
  expect_says(table, {"Lateral colour"});
  const std::string csv = scratch.run(measure + "--format csv").out;
  expect_says(csv, {",lateral_shift_px,lateral_shift_px_sd,lateral_shift_from\n"});
}

TEST(LateralColour, NeedsTheSameEdgeInAnotherPlane) {
  const Scratch scratch;
  write_rgb(scratch, 74.0, 54.0);  // ten pixels away: another edge
  const auto far = scratch.run("mtf measure rgb.exr --channel all --roi 20,10,90,80");
  ASSERT_EQ(far.status, 0) << far.err;
  EXPECT_FALSE(says(far.out, "Lateral colour")) << far.out;
  const auto one = scratch.run("mtf measure rgb.exr --channel R --roi 20,10,90,80 --format csv");
  ASSERT_EQ(one.status, 0) << one.err;
  EXPECT_FALSE(says(one.out, "lateral_shift")) << one.out;
}

}  // namespace
}  // namespace apps_test
