// SPDX-License-Identifier: Apache-2.0

// Residuals set by set, and the verdict on the model.

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "calib/fit/confidence/adequacy.h"
#include "calib/fit/fit_report.h"
#include "mtf/units.h"

namespace calib {
namespace {

constexpr double kWrongModel_p = 1e-4;
/// Structure in the residuals that matters: rms over the region, of the contrast. Below, tables and rounding show.
constexpr double kStructureMatters = 1e-5;
constexpr double kNoiseDoubt = 1.5;  // residuals / noise
/// Residuals of curves and spots far below the noise that was given are those of tables and rounding.
constexpr double kBelowNoiseChi2 = 0.04;
/// Residuals this many times the noise are no noise, whatever their structure: the sd of a curve may be known to a
/// factor of two, a spot's own photons may make its peak noisier than the background is.
constexpr double kCurveChi2 = 6.0, kSpotChi2 = 30.0;

/// Chi-square a degree of freedom that noise cannot explain.
bool beyond_noise(const Block& block, double chi2_per_dof, std::size_t count) {
  const double chance = 1.0 + 5.0 * std::sqrt(2.0 / static_cast<double>(std::max<std::size_t>(1, count)));
  if (std::holds_alternative<CurveBlock>(block)) return chi2_per_dof > std::max(kCurveChi2, chance);
  return std::holds_alternative<SpotBlock>(block) && chi2_per_dof > kSpotChi2;
}

double contrast_of(const FitProblem& problem, std::size_t b) {
  const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b]);
  return edge == nullptr ? 0.0 : std::abs(problem.own[b][edge->contrast_index()]);
}

/// An edge's structure is judged by pixels that do not share their noise; `ratio` is that of IndependentResiduals.
Adequacy adequacy_of(const FitProblem& problem, std::size_t b, std::span<const Residual> residuals, double& ratio) {
  const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b]);
  if (edge == nullptr) return judge_sequence(residuals);
  constexpr double kFlatWidths = 2.0, kFlat_px = 6.0;
  const std::optional<Estimate>& fwhm_px = edge->data().start.fwhm_px;
  const double flat_px = fwhm_px ? kFlatWidths * fwhm_px->value : kFlat_px;
  const auto judge = [&](std::span<const Residual> some) {
    // The unknowns that change E: offset, plateaus and parameters.
    return judge_edge(some, 3 + problem.variables.size(), contrast_of(problem, b), edge->data().quantum);
  };
  const Adequacy all = judge(residuals);
  const IndependentResiduals some =
      independent({residuals.begin(), residuals.end()}, edge->curve(problem.own[b]).normal(), flat_px);
  ratio = some.variance_ratio;
  if (some.spacing_px == 1) return all;
  Adequacy adequacy = judge(some.residuals);
  adequacy.chi2 = all.chi2;
  adequacy.outlier_share = all.outlier_share;
  return adequacy;
}

std::string rounded(double value) { return mtf::format_double(std::round(10.0 * value) / 10.0); }

mtf::Image residual_image(const Roi& roi, std::span<const Residual> residuals) {
  mtf::Image image(roi.width, roi.height);
  std::fill_n(image.data(), image.size(), std::numeric_limits<float>::quiet_NaN());
  for (const Residual& r : residuals) image.at(r.x - roi.x, r.y - roi.y) = static_cast<float>(r.value);
  return image;
}

}  // namespace

void report_data(const FitData& data, std::span<const std::optional<std::size_t>> block_of, const Solved& solved,
                 FitResult& result) {
  const FitProblem& problem = *solved.problem;
  double chi2 = 0.0, dof = -static_cast<double>(problem.variables.size());
  double least_p = 1.0;
  int tests = 0;
  std::optional<std::size_t> worst, far;
  for (std::size_t i = 0; i < block_of.size(); ++i) {
    FitResiduals& out = result.data.emplace_back();
    const std::size_t edges = data.edges.size(), curves = data.curves.size();
    out.name = i < edges            ? data.edges[i].name
               : i < edges + curves ? data.curves[i - edges].name
                                    : data.spots[i - edges - curves].name;
    if (!block_of[i]) continue;
    const std::size_t b = *block_of[i];
    const std::vector<Residual> residuals = std::visit(
        [&](const auto& block) { return block.residuals(*problem.sensors, problem.own[b]); }, problem.blocks[b]);
    double variance_ratio = 1.0;
    const Adequacy adequacy = adequacy_of(problem, b, residuals, variance_ratio);
    if (variance_ratio > 1.0)
      result.warnings.push_back(out.name +
                                ": noise is correlated between neighbouring pixels, as after demosaicing, denoising or "
                                "JPEG: the errors given are those of independent pixels, and may be up to " +
                                rounded(std::sqrt(variance_ratio)) + " times too small; fit the raw image");
    out.count = residuals.size();
    const double scale = std::visit([](const auto& block) { return block.noise_scale(); }, problem.blocks[b]);
    out.chi2_per_dof = solved.noise_factor[b] * scale;
    out.outlier_share = adequacy.outlier_share;
    out.whiteness_p = adequacy.whiteness_p;
    chi2 += adequacy.chi2 * scale;
    dof += static_cast<double>(residuals.size() - problem.own[b].size());
    double matters = 0.0;
    if (const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b])) {
      out.curve = edge->curve(problem.own[b]);
      const auto k = static_cast<Eigen::Index>(edge->contrast_index());
      const Eigen::MatrixXd& normal = solved.normals[b];
      const Eigen::Index own = static_cast<Eigen::Index>(problem.own[b].size());
      const double information = normal.topLeftCorner(own, own).inverse()(k, k) * trusted_noise(solved.noise_factor[b]);
      out.contrast = {problem.own[b][edge->contrast_index()], std::sqrt(std::max(0.0, information))};
      out.residual = residual_image(edge->data().roi, residuals);
      matters = kStructureMatters * std::abs(out.contrast.value) / edge->middle_sd();
      if (!result.residual_otf.empty() && b == 0)
        result.residual_otf =
            residual_otf(adequacy, std::abs(out.contrast.value) / edge->middle_sd(), result.frequency_cy_px);
    }
    if (const auto* spot = std::get_if<SpotBlock>(&problem.blocks[b]))
      out.residual = residual_image(spot->roi(), residuals);
    if (beyond_noise(problem.blocks[b], out.chi2_per_dof, out.count) &&
        (!far || out.chi2_per_dof > result.data[*far].chi2_per_dof))
      far = i;
    // What is given of each is what counts.
    const bool edge = std::holds_alternative<EdgeBlock>(problem.blocks[b]);
    if (out.whiteness_p < kWrongModel_p && (edge ? adequacy.structure < matters : out.chi2_per_dof < kBelowNoiseChi2))
      out.whiteness_p = 1.0;
    ++tests;
    if (out.whiteness_p < least_p) worst = i;
    least_p = std::min(least_p, out.whiteness_p);
  }
  result.chi2_per_dof = chi2 / std::max(1.0, dof);
  result.whiteness_p = std::min(1.0, least_p * tests);
  for (const FitResiduals& one : result.data)
    if (one.chi2_per_dof > kNoiseDoubt * kNoiseDoubt)
      result.warnings.push_back(one.name + ": the residuals are " + rounded(std::sqrt(one.chi2_per_dof)) +
                                " times the noise that is assumed; the errors are scaled to them");
  if (result.status == FitStatus::converged && far) {
    const FitResiduals& one = result.data[*far];
    const bool spot = *far >= data.edges.size() + data.curves.size();
    result.status = FitStatus::converged_model_wrong;
    result.reason =
        "the residuals of " + one.name + " are " + rounded(std::sqrt(one.chi2_per_dof)) +
        (spot ? " times the noise of its background: it is saturated, not alone, or the model has the wrong shape"
              : " times the standard deviation that was given: the model has the wrong shape, or the curve is that of "
                "another sensor");
    return;
  }
  if (result.status != FitStatus::converged || result.whiteness_p >= kWrongModel_p) return;
  result.status = FitStatus::converged_model_wrong;
  std::array<char, 16> p{};
  std::snprintf(p.data(), p.size(), "%.0e", result.whiteness_p);
  result.reason = "the residuals of " + result.data[*worst].name +
                  " have structure that noise does not explain (p = " + p.data() +
                  "): the model lacks something or has the wrong shape; the errors given are those of noise alone";
}

}  // namespace calib
