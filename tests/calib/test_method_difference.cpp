// SPDX-License-Identifier: Apache-2.0
// The reasons for which ISO 12233 differs from the MTF: their sizes, and what they leave.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "calib/iso12233/iso12233_difference.h"
#include "mtf/error.h"
#include "tests/calib/made_edges.h"
#include "tests/expect_error.h"

namespace {

using calib::Iso12233Difference;

Iso12233Difference difference_of(const made::Step& step, const made::Scene& scene) {
  const mtf::Image image = made::make(step, scene);
  const calib::Roi roi{0, 0, image.width(), image.height()};
  const auto edge = calib::measure_edge(image.view(), roi);
  const auto standard = calib::measure_iso12233(image.view(), roi);
  EXPECT_EQ(edge.trouble, calib::Trouble::none) << edge.reason;
  return calib::explain_difference(edge, standard);
}

/// What a reason says, of a list that has it.
double of_nyquist(const Iso12233Difference& difference, const std::string& word) {
  for (const calib::Iso12233Reason& one : difference.reasons)
    if (one.reason.find(word) != std::string_view::npos) return one.change.nyquist.value();
  ADD_FAILURE() << word;
  return NAN;
}

void expect_explained(const Iso12233Difference& difference, double share) {
  const double total = std::abs(difference.total.mtf50_cy_px.value());
  EXPECT_LT(std::abs(difference.unexplained.mtf50_cy_px.value()), share * total) << total;
  double sum_mtf50 = *difference.unexplained.mtf50_cy_px, sum_nyquist = *difference.unexplained.nyquist, last = 1.0;
  for (const calib::Iso12233Reason& one : difference.reasons) {
    sum_mtf50 += one.change.mtf50_cy_px.value();
    sum_nyquist += one.change.nyquist.value();
    EXPECT_LE(std::abs(*one.change.mtf50_cy_px), last);
    last = std::abs(*one.change.mtf50_cy_px);
  }
  // The crossing without the correction of its mean is where the reasons begin; without noise they are the same.
  EXPECT_NEAR(sum_mtf50, *difference.total.mtf50_cy_px, 1e-5);
  EXPECT_NEAR(sum_nyquist, *difference.total.nyquist, 1e-9);
}

// Without noise the reasons leave little: a fifth of the difference where the phases of the pixels within the bins are
// uneven, as at 5 degrees, a tenth of it in most cases.
TEST(MethodDifference, ReasonsExplainEdgesWithoutNoise) {
  for (const double angle_deg : {5.0, 95.0}) {
    SCOPED_TRACE(angle_deg);
    expect_explained(difference_of(made::Step::gaussian(0.3), {.angle_deg = angle_deg}), 0.1);
    const auto camera = [&](double f_number) { return made::camera_step(made::camera_of(f_number), angle_deg); };
    expect_explained(difference_of(camera(4.0), {.angle_deg = angle_deg}), 0.2);
    expect_explained(difference_of(camera(16.0), {.angle_deg = angle_deg}), 0.1);
  }
}

TEST(MethodDifference, TheLargestReasonComesFirst) {
  const auto sharp = difference_of(made::Step::gaussian(0.3), {});
  expect_says(sharp.reasons.front().reason, {"quarter pixel"});
  // sinc(f cos(a) / 4) of 0.146 at 0.5 cycles/pixel: 2.6 % of it.
  EXPECT_NEAR(of_nyquist(sharp, "quarter pixel"), -0.0254 * made::Step::gaussian(0.3).mtf(0.5), 1e-4);
  // The tails of diffraction end with the region: +1.1 % of MTF50 in 128 columns, of which the bins leave 0.8 %.
  const made::Step step = made::camera_step(made::camera_of(16.0), 5.0);
  const auto wide = difference_of(step, {}), narrow = difference_of(step, {.width = 48});
  for (const auto& difference : {wide, narrow}) expect_says(difference.reasons.front().reason, {"window"});
  EXPECT_NEAR(wide.reasons.front().change.mtf50_cy_px.value() / step.crossing(0.5), 0.0114, 0.001);
  EXPECT_NEAR(wide.total.mtf50_cy_px.value() / step.crossing(0.5), 0.008, 0.001);
  EXPECT_GT(*narrow.reasons.front().change.mtf50_cy_px, 2.0 * *wide.reasons.front().change.mtf50_cy_px);
}

// The mean of noisy curves at Nyquist is above that of clean ones by what the reason says.
TEST(MethodDifference, NoiseAddsToTheModulus) {
  constexpr int kDraws = 60;
  double total = 0.0, squares = 0.0, said = 0.0, scatter = 0.0;
  const made::Step step = made::Step::gaussian(0.3);
  const double clean = difference_of(step, {}).total.nyquist.value();
  for (int draw = 0; draw < kDraws; ++draw) {
    const made::Scene scene{.x = 64.0 + draw / 60.0, .noise_sd = 0.02, .seed = static_cast<std::uint64_t>(draw) + 1};
    const auto difference = difference_of(step, scene);
    const double more = *difference.total.nyquist - clean;
    total += more / kDraws;
    squares += more * more / kDraws;
    said += of_nyquist(difference, "noise") / kDraws;
    scatter += difference.scatter.nyquist.value() / kDraws;
  }
  const double error = std::sqrt((squares - total * total) / kDraws);
  EXPECT_NEAR(total, said, 3.0 * error);
  EXPECT_GT(said, 0.005);
  EXPECT_LT(said, 0.015);
  // Straight lines between samples average the noise of two of them: up to a quarter less.
  const double rms = error * std::sqrt(kDraws);
  EXPECT_GT(rms, 0.65 * scatter);
  EXPECT_LT(rms, 1.2 * scatter);
}

TEST(MethodDifference, OnlyResultsOfOneRegionAreCompared) {
  const mtf::Image image = made::make(made::Step::gaussian(0.3), {});
  const auto edge = calib::measure_edge(image.view(), {0, 0, 128, 100});
  const auto standard = calib::measure_iso12233(image.view(), {0, 0, 120, 100});
  EXPECT_THROW(calib::explain_difference(edge, standard), mtf::UsageError);
  EXPECT_THROW(calib::explain_difference({}, standard), mtf::UsageError);
}

}  // namespace
