// SPDX-License-Identifier: Apache-2.0
// A fit on sums by distance against the fit of the pixels themselves, both from one state short of the best.

#include <gtest/gtest.h>

#include <cmath>

#include "calib/measure/edge_bin_fit.h"
#include "calib/measure/edge_start.h"
#include "calib/measure/edge_sums.h"
#include "calib/measure/edge_terms.h"
#include "tests/calib/made_edges.h"

namespace {

double blur_px2(const calib::ReferenceShape& shape) {
  return shape.v_px2 + shape.q_px2 / 12.0 + 0.1 * shape.s_px * shape.s_px;
}

struct Case {
  double angle_deg = 5.0, sagitta_px = 0.0;
  int order = 1;
};

class BinFit : public testing::TestWithParam<Case> {};

TEST_P(BinFit, EndsWhereThePixelsDo) {
  constexpr double kCnr = 60.0, kContrast = 0.6;
  made::Scene scene;
  scene.angle_deg = GetParam().angle_deg;
  scene.sagitta_px = GetParam().sagitta_px;
  scene.half_length_px = 50.0;
  scene.noise_sd = kContrast / kCnr;
  const mtf::Image image = made::make(made::Step::gaussian(0.3), scene);
  const calib::Roi roi{0, 0, image.width(), image.height()};
  const calib::RegionFacts facts = calib::survey(image.view(), roi, {});
  std::int64_t block_px = 1;
  const calib::EdgePixels blocks = calib::gather_blocks(image.view(), roi, facts, {}, block_px);
  calib::EdgeModel near = calib::start_edge(blocks, static_cast<double>(block_px), 128.0, 100.0);
  const calib::EdgePixels pixels = calib::gather_pixels(image.view(), roi, facts, {}, near.curve, calib::kReach_px);

  calib::FitRounds rounds;
  rounds.unknowns = calib::with_order(calib::basic_unknowns(), GetParam().order);
  calib::set_order(near.curve, GetParam().order, false);
  near.shape = {.s_px = 0.0, .v_px2 = 0.8 * near.shape.v_px2, .q_px2 = 0.5};
  rounds.step = 6;
  rounds.rounds = 25;
  calib::fit_reference(pixels, near, rounds);
  rounds.step = 1;
  rounds.rounds = 20;
  rounds.enough = 1e-3;
  const calib::FitState state = calib::evaluate(pixels, near, rounds);
  calib::EdgeModel on_bins = near, on_pixels = near;
  calib::fit_on_bins(state, near, on_bins, rounds);
  calib::fit_reference(pixels, on_pixels, rounds, state);

  // A tenth of what noise leaves: width and place of a Gaussian edge of length L are known to
  // sqrt(4 sqrt(pi) / (L sigma)) / CNR of the width and 0.7 of that of it (the bound of Cramer and Rao).
  const double sigma = std::sqrt(blur_px2(on_pixels.shape));
  const double known = std::sqrt(4.0 * std::sqrt(3.14159265) / (100.0 * sigma)) / kCnr;
  EXPECT_GT(state.normal.gradient.squaredNorm(), 0.0);
  EXPECT_NEAR(blur_px2(on_bins.shape) / blur_px2(on_pixels.shape), 1.0, 0.2 * known);
  const calib::Vector way = calib::way(on_pixels, on_bins);
  EXPECT_NEAR(way[calib::kFirstShift], 0.0, 0.07 * known * sigma);
  EXPECT_NEAR(way[calib::kFirstShift + 1], 0.0, 0.14 * known * sigma);
  EXPECT_NEAR(way[calib::kFirstShift + 2], 0.0, 0.25 * known * sigma);
  EXPECT_NEAR(way[0], 0.0, 1e-4);
  EXPECT_NEAR(way[1], 0.0, 1e-4);
  // Both are as near to the pixels.
  const double chi2 = calib::evaluate(pixels, on_pixels, rounds).normal.chi2;
  EXPECT_LT(calib::evaluate(pixels, on_bins, rounds).normal.chi2, chi2 + 0.5);
  EXPECT_GT(state.normal.chi2, chi2 + 2.0) << "the start was the end";
}

INSTANTIATE_TEST_SUITE_P(Edges, BinFit,
                         testing::Values(Case{}, Case{.angle_deg = 45.0}, Case{.angle_deg = 0.0},
                                         Case{.angle_deg = 20.0, .sagitta_px = 1.5, .order = 2}));

// The way between two models is the step that was taken.
TEST(BinFit, WayIsTheStep) {
  calib::EdgeModel from;
  from.curve.half_length_px = 50.0;
  from.curve.angle_rad = 0.3;
  from.level = {0.2, 0.8};
  calib::set_order(from.curve, 3, false);
  calib::Vector step = calib::Vector::Zero();
  step.head<calib::kFirstShift + 4>() << 0.01, -0.02, 1e-4, 2e-4, 3e-3, 4e-3, 0.05, -0.1, 0.2, -0.3;
  calib::EdgeModel to = from;
  calib::move(to, step);
  EXPECT_LT((calib::way(from, to) - step).cwiseAbs().maxCoeff(), 1e-12);
}

// What is a hair within the reach rounds to its end in places: it is in the last bin, or out of reach, on either side.
TEST(DistanceBins, EndAtTheReach) {
  const double last = std::nextafter(calib::kReach_px, 0.0);
  EXPECT_EQ(calib::DistanceBins::get().index(last), calib::kBins - 1);
  EXPECT_EQ(calib::DistanceBins::get().index(-last), 0);
  for (const double off : {-1.5e-14, 0.0, 1.5e-14}) {
    calib::EdgePixels pixels(2);
    pixels.add(-calib::kReach_px, 0.0, 0.1);
    pixels.add(calib::kReach_px, 0.0, 0.9);
    calib::EdgeModel model;
    model.curve.half_length_px = 10.0;
    model.curve.origin = {off, 0.0};
    model.level = {0.0, 1.0};
    const calib::EdgeSums sums =
        calib::accumulate(pixels, model, calib::StepProfile(calib::tabulate(model.shape, 0.0)), 1);
    double count = 0.0;
    for (int i = 0; i < calib::kBins; ++i) count += sums.count(i);
    EXPECT_LE(count, 1.0) << off;
  }
}

}  // namespace
