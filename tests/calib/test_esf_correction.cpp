// SPDX-License-Identifier: Apache-2.0
// The joint solution where there is nothing to correct with, or no reason to: plain least squares. (Eigen must not be
// asked to solve for no columns: the undefined-behaviour sanitizer stops there.)

#include "calib/measure/correction/esf_correction.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "calib/edge/edge_pixels.h"
#include "calib/measure/edge_region.h"
#include "calib/measure/edge_terms.h"
#include "tests/calib/made_edges.h"

namespace {

TEST(EsfCorrection, WithoutSplinesItIsPlainLeastSquares) {
  made::Scene scene;
  scene.noise_sd = 0.01;
  const mtf::Image image = made::make(made::Step::gaussian(0.3), scene);
  const calib::Roi roi{0, 0, image.width(), image.height()};
  const calib::RegionFacts facts = calib::survey(image.view(), roi, {});
  std::int64_t block_px = 1;
  const calib::EdgePixels blocks = calib::gather_blocks(image.view(), roi, facts, {}, block_px);
  const calib::EdgeModel model = calib::start_edge(blocks, static_cast<double>(block_px), 128.0, 100.0);
  const calib::EdgePixels pixels = calib::gather_pixels(image.view(), roi, facts, {}, model.curve, calib::kRange_px);
  calib::FitSettings settings;
  settings.unknowns = calib::basic_unknowns().reset(calib::kFirstShape);
  const calib::FitState state = calib::evaluate(pixels, model, settings);

  const auto count = static_cast<Eigen::Index>(settings.unknowns.count());
  Eigen::MatrixXd normal(count, count);
  Eigen::VectorXd gradient(count);
  calib::NormalEquations with_prior = state.normal;
  calib::add_prior(with_prior, model.shape, settings.unknowns);

  // There are no splines where few distances a pixel occur, nor in a region too short for a single one.
  for (const auto& [detail, range_px] : {std::pair{calib::Detail::none, 0.4}, {calib::Detail::coarse, 0.4}}) {
    const calib::JointFit joint = calib::solve_jointly(state, model, settings.unknowns, detail, 1.0, range_px);
    for (const double one : joint.probability) EXPECT_EQ(one, 0.0);
    EXPECT_TRUE(joint.changes.empty());
    ASSERT_EQ(joint.value.size(), count);
    for (Eigen::Index i = 0; i < count; ++i) {
      gradient[i] = with_prior.gradient[joint.unknowns[static_cast<std::size_t>(i)]];
      for (Eigen::Index j = 0; j < count; ++j)
        normal(i, j) =
            with_prior.matrix(joint.unknowns[static_cast<std::size_t>(i)], joint.unknowns[static_cast<std::size_t>(j)]);
    }
    // The expected values come from another factorisation, so that they differ by rounding times the condition.
    const Eigen::VectorXd sd_of_one = normal.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = sd_of_one.asDiagonal() * normal * sd_of_one.asDiagonal();
    const Eigen::FullPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
    const Eigen::VectorXd value = sd_of_one.cwiseProduct(qr.solve(sd_of_one.cwiseProduct(gradient)));
    const Eigen::MatrixXd inverse = sd_of_one.asDiagonal() * qr.inverse() * sd_of_one.asDiagonal();
    for (Eigen::Index i = 0; i < count; ++i) {
      EXPECT_NEAR(joint.value[i], value[i], 1e-6 * std::sqrt(inverse(i, i))) << i;
      EXPECT_NEAR(joint.covariance(i, i) / (std::max(1.0, joint.chi2_per_dof) * inverse(i, i)), 1.0, 1e-6) << i;
    }
  }
}

}  // namespace
