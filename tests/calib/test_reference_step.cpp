// SPDX-License-Identifier: Apache-2.0
// The reference step's table against images' own quadrature, its derivatives against differences.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "calib/edge/exponential.h"
#include "calib/edge/reference_step.h"
#include "calib/measure/residual_sums.h"
#include "tests/calib/made_edges.h"

namespace {

constexpr double kAngle_deg = 20.0, kAngle_rad = kAngle_deg * std::numbers::pi / 180.0;
const calib::Point kNormal{std::cos(kAngle_rad), std::sin(kAngle_rad)};

double knot(std::size_t i) { return calib::DistanceBins::get().knot(calib::kSideBins + static_cast<int>(i)); }

}  // namespace

TEST(ReferenceStep, BinsHoldTheirDistances) {
  const calib::DistanceBins& bins = calib::DistanceBins::get();
  EXPECT_EQ(bins.knot(0), -calib::kRange_px);
  EXPECT_EQ(bins.knot(calib::kBins), calib::kRange_px);
  for (int i = 0; i < calib::kBins; ++i) {
    EXPECT_EQ(bins.index(bins.centre(i)), i);
    const double inside = bins.knot(i) + 1e-9 * (bins.knot(i + 1) - bins.knot(i));
    EXPECT_EQ(bins.index(inside), i);
  }
}

// A distance that is less than the range by a rounding error lies in the last bin or in none, on either side.
TEST(ReferenceStep, BinsEndAtTheirRange) {
  const double last = std::nextafter(calib::kRange_px, 0.0);
  EXPECT_EQ(calib::DistanceBins::get().index(last), calib::kBins - 1);
  EXPECT_EQ(calib::DistanceBins::get().index(-last), 0);
  for (const double off : {-1.5e-14, 0.0, 1.5e-14}) {
    calib::EdgePixels pixels(2);
    pixels.add(-calib::kRange_px, 0.0, 0.1);
    pixels.add(calib::kRange_px, 0.0, 0.9);
    calib::EdgeModel model;
    model.curve.half_length_px = 10.0;
    model.curve.origin = {off, 0.0};
    model.plateau = {0.0, 1.0};
    const calib::EdgeSums sums =
        calib::accumulate(pixels, model, calib::StepProfile(calib::tabulate(model.shape, 0.0)), 1);
    double count = 0.0;
    for (int i = 0; i < calib::kBins; ++i) count += sums.count(i);
    EXPECT_LE(count, 1.0) << off;
  }
}

TEST(ReferenceStep, ExponentialIsTheFunction) {
  for (double x = -690.0; x < 690.0; x += 0.0137) EXPECT_NEAR(calib::exponential(x) / std::exp(x), 1.0, 5e-16);
}

TEST(ReferenceStep, HasOneOtf) {
  for (const calib::ReferenceShape shape :
       {calib::ReferenceShape{0.93, 0.02, 1.0}, calib::ReferenceShape{0.0, 40.0, 0.0},
        calib::ReferenceShape{0.0, 0.0036, 64.0}}) {
    std::vector<double> f_cy_px(41);
    for (std::size_t i = 0; i < f_cy_px.size(); ++i) f_cy_px[i] = 0.05 * static_cast<double>(i);
    const std::vector<calib::ReferenceOtf> all = calib::reference_otfs(shape, kNormal, f_cy_px);
    for (std::size_t i = 0; i < f_cy_px.size(); ++i) {
      const calib::ReferenceOtf one = calib::reference_otf(shape, kNormal, f_cy_px[i]);
      EXPECT_NEAR(all[i].value, one.value, 1e-15);
      for (std::size_t k = 0; k < calib::kShapes; ++k)
        EXPECT_NEAR(all[i].slope[k], one.slope[k], 1e-14 * (1.0 + std::abs(one.slope[k])));
    }
  }
}

TEST(ReferenceStep, IsTheStepOfItsOtf) {
  for (const calib::ReferenceShape shape :
       {calib::ReferenceShape{0.93, 0.02, 1.0}, calib::ReferenceShape{0.33, 0.01, 1.0},
        calib::ReferenceShape{1.86, 0.01, 1.0}, calib::ReferenceShape{0.0, 0.39, 0.0},
        calib::ReferenceShape{0.0, 0.0036, 1.0}, calib::ReferenceShape{3.0, 4.0, 9.0}}) {
    const made::Camera camera{.s = shape.s_px, .pixel = std::sqrt(shape.q_px2), .variance = shape.v_px2};
    const made::Step step = made::camera_step(camera, kAngle_deg, 100.0);
    const calib::ReferenceTable table = calib::tabulate(shape, kAngle_rad);
    for (std::size_t i = 0; i <= calib::kSideBins; ++i)
      EXPECT_NEAR(table.odd[i] + 0.5, step.at(knot(i)), 1e-5) << shape.s_px << ' ' << shape.v_px2 << " at " << knot(i);
    for (double f = 0.0; f < 1.2; f += 0.07)
      EXPECT_NEAR(calib::reference_otf(shape, kNormal, f).value, step.mtf(f), 1e-12);
  }
}

TEST(ReferenceStep, KnowsItsDerivatives) {
  const calib::ReferenceShape shape{0.93, 0.1, 1.0};
  constexpr double kStep = 1e-5;
  const calib::ReferenceTable table = calib::tabulate(shape, kAngle_rad);
  for (std::size_t k = 0; k < calib::kShapes; ++k) {
    calib::ReferenceShape more = shape, less = shape;
    const auto field = [k](calib::ReferenceShape& s) -> double& {
      return k == 0 ? s.s_px : k == 1 ? s.v_px2 : s.q_px2;
    };
    field(more) += kStep;
    field(less) -= kStep;
    const calib::ReferenceTable above = calib::tabulate(more, kAngle_rad), below = calib::tabulate(less, kAngle_rad);
    for (std::size_t i = 0; i <= calib::kSideBins; ++i)
      EXPECT_NEAR(table.slope[k][i], (above.odd[i] - below.odd[i]) / (2.0 * kStep), 2e-5) << k << " at " << knot(i);
    for (double f = 0.05; f < 1.0; f += 0.05)
      EXPECT_NEAR(
          calib::reference_otf(shape, kNormal, f).slope[k],
          (calib::reference_otf(more, kNormal, f).value - calib::reference_otf(less, kNormal, f).value) / (2.0 * kStep),
          1e-8);
  }
}
