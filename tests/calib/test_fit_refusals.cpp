// SPDX-License-Identifier: Apache-2.0
// What cannot be fitted: mistakes of the request are UsageErrors that name the place, bad data are outcomes.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mtf/error.h"
#include "tests/calib/fit_cases.h"
#include "tests/expect_error.h"

namespace calib {
namespace {

using fit_cases::data_of;
using fit_cases::edge_of;
using fit_cases::parameter;
using mtf::Stage;
using mtf::System;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const std::vector<FitParameter> kSigma{parameter("presample[0].sigma")};

struct Made {
  made::Scene scene;
  mtf::Image image;
  explicit Made(double noise_sd = 0.01) {
    scene.noise_sd = noise_sd;
    image = made::make(made::Step::gaussian(0.3), scene);
  }
  FitData data() const { return data_of(fit_cases::gaussian(0.8), edge_of(image, scene)); }
};

std::string refusal(const FitData& data, const std::vector<FitParameter>& parameters) {
  return message_of<mtf::UsageError>([&] { fit(data, parameters); });
}

TEST(FitRefusals, Parameters) {
  const Made made;
  const FitData data = made.data();
  expect_says(refusal(data, {}), {"nothing to fit"});
  expect_says(refusal(data, {parameter("presample[3].sigma")}), {"presample[3].sigma"});
  expect_says(refusal(data, {parameter("optics.f_number")}), {"optics.f_number"});
  expect_says(refusal(data, {kSigma[0], kSigma[0]}), {"twice"});

  FitParameter p = kSigma[0];
  p.min = 2.0, p.max = 1.0;
  expect_says(refusal(data, {p}), {"bounds"});
  p = kSigma[0];
  p.max = -1.0;
  expect_says(refusal(data, {p}), {"bounds"});
  for (const double bad : {kNan, std::numeric_limits<double>::infinity()}) {
    p = kSigma[0];
    p.min = bad;
    expect_says(refusal(data, {p}), {"finite"});
    p = kSigma[0];
    p.prior = {1.0, bad};
    expect_says(refusal(data, {p}), {"prior"});
  }
  p = kSigma[0];
  p.prior = {1.0, 0.0};
  expect_says(refusal(data, {p}), {"prior"});
}

TEST(FitRefusals, TwoNamesOfOneNumber) {
  const Made made;
  const FitData data = data_of(fit_cases::camera(8.0), edge_of(made.image, made.scene));
  expect_says(refusal(data, {parameter("optics.f_number"), parameter("presample[0].f_number")}), {"the same number"});
  expect_says(refusal(data, {parameter("presample[0].wavelength"), parameter("optics.wavelength")}),
              {"the same number"});
  expect_says(refusal(data, {parameter("frame.pitch"), parameter("frame.pitch_x")}), {"the same number"});
}

TEST(FitRefusals, RegionsConditionsAndSensors) {
  const Made made;
  FitData data = made.data();
  data.edges[0].roi = {100, 0, 100, 50};
  expect_says(refusal(data, kSigma), {"inside the image"});
  data.edges[0].roi = {0, 0, std::numeric_limits<std::int64_t>::max(), 1};
  expect_says(refusal(data, kSigma), {"inside the image"});
  data = made.data();
  data.edges[0].condition = 1;
  expect_says(refusal(data, kSigma), {"condition"});
  data = made.data();
  data.conditions.clear();
  expect_says(refusal(data, kSigma), {"sensor"});
  // A high-pass leaves no plateaus.
  data = made.data();
  data.conditions[0].add(Stage::postsample, mtf::test::fir({{-1.0, 2.0, -1.0}}));
  expect_says(refusal(data, kSigma), {"no constant signal"});
}

// The parameters are set in the sensors of all conditions, so that a condition cannot have its own.
TEST(FitRefusals, AConditionThatSetsWhatIsFitted) {
  const Made made;
  FitData data = made.data();
  data.conditions.push_back(fit_cases::gaussian(0.5));
  EXPECT_EQ(fit(data, kSigma).status, FitStatus::converged);  // no data are taken under it
  data.edges.push_back(data.edges[0]);
  data.edges[1].name = "second.png", data.edges[1].condition = 1;
  std::vector<FitParameter> named = kSigma;
  named[0].name = "blur.sigma";
  expect_says(refusal(data, named), {"second.png", "blur.sigma", "out of the conditions", "fit = true away"});
  data.conditions[1] = data.conditions[0];
  EXPECT_EQ(fit(data, kSigma).status, FitStatus::converged);
}

TEST(FitRefusals, Curves) {
  const Made made;
  FitData data = made.data();
  const CurveData good{.name = "bench.csv",
                       .condition = 0,
                       .angle_deg = 0.0,
                       .unit = mtf::find_unit("cy/mm"),
                       .frequency = {10.0, 20.0},
                       .mtf = {0.9, 0.8},
                       .sd = {0.01}};
  for (const int fault : {0, 1, 2, 3, 4, 5, 6}) {
    data.curves = {good};
    CurveData& curve = data.curves[0];
    if (fault == 0) curve.mtf[1] = kNan;
    if (fault == 1) curve.frequency[0] = -1.0;
    if (fault == 2) curve.mtf.pop_back();
    if (fault == 3) curve.sd = {0.01, 0.0};
    if (fault == 4) curve.sd.clear();
    if (fault == 5) curve.angle_deg = kNan;
    if (fault == 6) curve.unit = nullptr;
    EXPECT_TRUE(says(refusal(data, kSigma), "bench.csv")) << fault;
  }
}

TEST(FitRefusals, EdgesWithTroubleAreLeftOut) {
  const Made made;
  FitData data = made.data();
  data.edges.push_back(data.edges[0]);
  data.edges[1].name = "broken";
  data.edges[1].start.trouble = Trouble::several_edges;
  data.edges[1].start.reason = "two edges cross the region";
  const FitResult one = fit(data, kSigma);
  EXPECT_EQ(one.status, FitStatus::converged) << one.reason;
  ASSERT_EQ(one.warnings.size(), 1u);
  expect_says(one.warnings[0], {"broken", "two edges"});
  ASSERT_EQ(one.data.size(), 2u);
  EXPECT_EQ(one.data[1].count, 0u);

  data.edges[0].start.trouble = Trouble::no_edge;
  const FitResult none = fit(data, kSigma);
  EXPECT_EQ(none.status, FitStatus::no_data);
  EXPECT_FALSE(none.reason.empty());
  EXPECT_TRUE(std::isnan(none.whiteness_p) && std::isnan(none.chi2_per_dof));  // nothing was tested
  EXPECT_EQ(none.parameters.at(0).knowledge, Knowledge::not_determined);
  data.edges.clear();
  EXPECT_EQ(fit(data, kSigma).status, FitStatus::no_data);
}

TEST(FitRefusals, MaskedFlatAndTinyEdges) {
  const Made made;
  for (const int fault : {0, 1, 2, 3, 4, 5}) {
    FitData data = made.data();
    mtf::Image image = made.image.clone();
    data.edges[0].image = image.view();
    if (fault == 4) data.edges[0].start.curve.half_length_px = 0.0;
    if (fault == 5) data.edges[0].start.curve.coefficient = {kNan};
    if (fault == 0) std::fill_n(image.data(), image.size(), std::numeric_limits<float>::quiet_NaN());
    if (fault == 1) data.edges[0].roi = {64, 50, 1, 1};
    if (fault == 2) data.edges[0].start.bright = data.edges[0].start.dark;
    if (fault == 3) data.edges[0].start.curve.angle_rad = kNan;
    EXPECT_EQ(fit(data, kSigma).status, FitStatus::no_data) << fault;
  }
  // Every other pixel masked, as in a Bayer plane.
  FitData data = made.data();
  mtf::Image image = made.image.clone();
  for (std::int64_t y = 0; y < image.height(); ++y)
    for (std::int64_t x = 0; x < image.width(); ++x)
      if (x % 2 == 0 || y % 2 == 0) image.at(x, y) = std::numeric_limits<float>::quiet_NaN();
  data.edges[0].image = image.view();
  const FitResult result = fit(data, kSigma);
  EXPECT_EQ(result.status, FitStatus::converged) << result.reason;
  EXPECT_NEAR(result.parameters[0].value, fit_cases::sigma_of(0.3), 4.0 * result.parameters[0].stderr_value.value());
}

TEST(FitRefusals, ImagesOfOtherThingsEndInSomeOutcome) {
  // The image is not the edge that was measured: flat, noise only, upside down, huge values.
  const Made made;
  for (const int fault : {0, 1, 2, 3}) {
    FitData data = made.data();
    mtf::Image image = made.image.clone();
    for (std::int64_t i = 0; i < image.size(); ++i) {
      float& v = image.data()[i];
      v = fault == 0 ? 0.5F : fault == 1 ? 0.5F + 0.01F * static_cast<float>(i % 7) : fault == 2 ? 1.0F - v : v * 1e30F;
    }
    data.edges[0].image = image.view();
    const FitResult result = fit(data, kSigma);
    EXPECT_FALSE(status_name(result.status).empty());
    EXPECT_TRUE(std::isfinite(result.parameters.at(0).value));
  }
}

TEST(FitRefusals, AbsurdGeometryEndsInSomeOutcome) {
  const Made made;
  for (const int fault : {0, 1, 2, 3, 4}) {
    FitData data = made.data();
    data.edges[0].roi = {44, 30, 40, 40};  // each of these runs for as many iterations as are allowed
    EdgeMeasurement& start = data.edges[0].start;
    if (fault == 0) start.curve.coefficient = {1e200, -1e300}, start.curve.shape = EdgeCurve::Shape::polynomial;
    if (fault == 1) start.curve.coefficient = {40.0}, start.curve.shape = EdgeCurve::Shape::polynomial;
    if (fault == 2) start.curve.curvature_per_px = 1e9, start.curve.shape = EdgeCurve::Shape::circle;
    if (fault == 3) start.dark = 1e30, start.bright = -1e30;
    if (fault == 4) start.noise_sd = 1e200, start.noise_gain = -1e200;
    const FitResult result = fit(data, kSigma);
    EXPECT_TRUE(std::isfinite(result.parameters.at(0).value)) << fault;
    for (const double m : result.mtf) ASSERT_TRUE(std::isfinite(m)) << fault;
  }
}

TEST(FitRefusals, ASpotWithoutLight) {
  mtf::Image flat(20, 20);
  std::fill_n(flat.data(), flat.size(), 3.0F);
  FitData data;
  data.conditions.push_back(fit_cases::camera(8.0));
  data.spots.push_back({.name = "dark", .image = flat.view(), .roi = {0, 0, 20, 20}, .condition = 0});
  const FitResult result = fit(data, std::vector{parameter("optics.f_number")});
  EXPECT_EQ(result.status, FitStatus::no_data);
  expect_says(result.reason, {"dark"});
  data.spots[0].roi = {0, 0, 2, 2};
  EXPECT_EQ(fit(data, std::vector{parameter("optics.f_number")}).status, FitStatus::no_data);
}

}  // namespace
}  // namespace calib
