// SPDX-License-Identifier: Apache-2.0

// Residuals set by set, and the verdict on the model.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "calib/dense.h"
#include "calib/fit/fit_report.h"
#include "mtf/units.h"

namespace calib {
namespace {

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

std::string rounded(double value) { return mtf::format_double(std::round(10.0 * value) / 10.0); }

/// sd of an edge's contrast, the shared variables as fitted.
double contrast_sd(const Solved& solved, std::size_t b, const EdgeBlock& edge) {
  const auto k = static_cast<Eigen::Index>(edge.contrast_index());
  const auto own = static_cast<Eigen::Index>(solved.problem->own[b].size());
  const Eigen::MatrixXd inverse = inverse_of(solved.normals[b].topLeftCorner(own, own));
  double variance = inverse(k, k);
  if (solved.scores[b].size() > 0) {
    const Eigen::MatrixXd sandwich = inverse * solved.scores[b].topLeftCorner(own, own) * inverse;
    variance = std::max(variance, sandwich(k, k));
  }
  return std::sqrt(std::max(0.0, variance * trusted_noise(solved.noise_factor[b])));
}

}  // namespace

void report_data(const FitData& data, std::span<const std::optional<std::size_t>> block_of, Solved& solved,
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
    ResidualTests& tested = solved.tests[b];
    const Adequacy& adequacy = tested.adequacy;
    if (!tested.noise.white())
      result.warnings.push_back(out.name +
                                ": noise is correlated between neighbouring pixels, as after demosaicing, denoising or "
                                "JPEG; the errors and intervals given include it");
    if (const double ratio = tested.left_out.sum(); ratio > 1.0)
      result.warnings.push_back(
          out.name +
          ": residuals are correlated between neighbouring pixels, but too small against rounding or the noise that is "
          "assumed to tell what noise they share; the errors given are those of independent pixels, and may be up to " +
          rounded(std::sqrt(ratio)) + " times too small");
    out.count = tested.count;
    const double scale = std::visit([](const auto& block) { return block.noise_scale(); }, problem.blocks[b]);
    out.chi2_per_dof = solved.noise_factor[b] * scale;
    out.outlier_share = adequacy.outlier_share;
    out.whiteness_p = adequacy.whiteness_p;
    chi2 += adequacy.chi2 * scale;
    dof += static_cast<double>(out.count - problem.own[b].size());
    double matters = 0.0;
    if (const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b])) {
      out.curve = edge->curve(problem.own[b]);
      out.gradients = edge->gradients();
      out.contrast = {problem.own[b][edge->contrast_index()], contrast_sd(solved, b, *edge)};
      matters = kStructureMatters * std::abs(out.contrast.value) / edge->middle_sd();
      if (!result.residual_otf.empty() && b == 0)
        result.residual_otf =
            residual_otf(adequacy, std::abs(out.contrast.value) / edge->middle_sd(), result.frequency_cy_px);
    }
    out.residual = std::move(tested.image);
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
