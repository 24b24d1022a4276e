// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/confidence/residual_tests.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace calib {
namespace {

mtf::Image residual_image(const Roi& roi, std::span<const Residual> residuals) {
  mtf::Image image(roi.width, roi.height);
  std::fill_n(image.data(), image.size(), std::numeric_limits<float>::quiet_NaN());
  for (const Residual& r : residuals) image.at(r.x - roi.x, r.y - roi.y) = static_cast<float>(r.value);
  return image;
}

void test_edge(const FitProblem& problem, std::size_t b, std::span<const Residual> residuals, double noise_factor,
               ResidualTests& tests) {
  constexpr double kTables = 0.1;  // chi-square per degree of freedom: residuals below are those of tables and rounding
  constexpr double kFlatWidths = 2.0, kFlat_px = 6.0;
  const EdgeBlock& edge = std::get<EdgeBlock>(problem.blocks[b]);
  const std::optional<Estimate>& fwhm_px = edge.data().start.fwhm_px;
  const double flat_px = fwhm_px ? kFlatWidths * fwhm_px->value : kFlat_px;
  const auto judge = [&](std::span<const Residual> some) {
    // The unknowns that change E: offset, plateaus and parameters.
    return judge_edge(some, 3 + problem.variables.size(), std::abs(problem.own[b][edge.contrast_index()]),
                      edge.data().quantum);
  };
  tests.image = residual_image(edge.data().roi, residuals);
  tests.adequacy = judge(residuals);
  IndependentResiduals some =
      independent({residuals.begin(), residuals.end()}, edge.curve(problem.own[b]).normal(), flat_px);
  if (some.spacing_px == 1) return;
  const double chi2 = tests.adequacy.chi2, outlier_share = tests.adequacy.outlier_share;
  tests.adequacy = judge(some.residuals);
  tests.adequacy.chi2 = chi2;
  tests.adequacy.outlier_share = outlier_share;
  const bool noise = noise_factor >= kTables && !edge.rounding_hides_noise();
  (noise ? tests.noise : tests.left_out) = std::move(some.noise);
}

}  // namespace

std::vector<ResidualTests> test_residuals(const FitProblem& problem, std::span<const double> noise_factor) {
  std::vector<ResidualTests> all(problem.blocks.size());
  for (std::size_t b = 0; b < all.size(); ++b) {
    const Block& block = problem.blocks[b];
    const std::vector<Residual> residuals =
        std::visit([&](const auto& one) { return one.residuals(*problem.sensors, problem.own[b]); }, block);
    all[b].count = residuals.size();
    if (std::holds_alternative<EdgeBlock>(block))
      test_edge(problem, b, residuals, noise_factor[b], all[b]);
    else
      all[b].adequacy = judge_sequence(residuals);
    if (const auto* spot = std::get_if<SpotBlock>(&block)) all[b].image = residual_image(spot->roi(), residuals);
  }
  return all;
}

std::vector<NoiseCorrelation> noise_of(std::span<const ResidualTests> tests) {
  std::vector<NoiseCorrelation> all;
  for (const ResidualTests& one : tests) all.push_back(one.noise);
  return all;
}

}  // namespace calib
