// SPDX-License-Identifier: Apache-2.0
#include "calib/fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "calib/adequacy.h"
#include "calib/fit_build.h"
#include "calib/fit_report.h"
#include "calib/profile.h"

namespace calib {
namespace {

constexpr double kWrongModel_p = 1e-4;
/// Structure in the residuals that matters: rms over the region, of the contrast. Below, tables and rounding show.
constexpr double kStructureMatters = 1e-5;
constexpr double kGradientChi2 = 18.47;  // of four more unknowns: one edge in a thousand has it by chance
constexpr int kMostRounds = 3;
constexpr double kNoiseDoubt = 1.5;  // residuals / noise

/// The share of the work, for the caller: each solution counts one step.
class Progress {
 public:
  Progress(const FitOptions& options, int steps) : options_(&options), steps_(steps) {}
  void step() { ++done_; }
  bool stopped() const { return stopped_; }
  std::function<bool()> asks() {
    if (!options_->progress) return {};
    return [this] {
      if (!options_->progress(std::min(1.0, static_cast<double>(done_) / steps_))) stopped_ = true;
      return !stopped_;
    };
  }

 private:
  const FitOptions* options_;
  int steps_ = 1, done_ = 0;
  bool stopped_ = false;
};

std::vector<Residual> residuals_of(const FitProblem& problem, std::size_t b) {
  return std::visit([&](const auto& block) { return block.residuals(*problem.sensors, problem.own[b]); },
                    problem.blocks[b]);
}

double contrast_of(const FitProblem& problem, std::size_t b) {
  const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b]);
  return edge == nullptr ? 0.0 : std::abs(problem.own[b][edge->contrast_index()]);
}

Adequacy adequacy_of(const FitProblem& problem, std::size_t b, std::span<const Residual> residuals) {
  const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b]);
  if (edge == nullptr) return judge_sequence(residuals);
  // Offset, levels and parameters shape E.
  return judge_edge(residuals, 3 + problem.variables.size(), contrast_of(problem, b), edge->data().quantum);
}

/// Chi-square of each block a degree of freedom; the shared parameters are counted by the blocks' sizes.
std::vector<double> noise_factors(const FitProblem& problem, std::span<const Eigen::MatrixXd> normals,
                                  std::span<const std::size_t> counts) {
  double all = 0.0;
  for (const std::size_t count : counts) all += static_cast<double>(count);
  std::vector<double> factors;
  for (std::size_t b = 0; b < normals.size(); ++b) {
    const auto n = static_cast<double>(counts[b]);
    const double used =
        static_cast<double>(problem.own[b].size()) + static_cast<double>(problem.variables.size()) * n / all;
    factors.push_back(normals[b](normals[b].rows() - 1, normals[b].cols() - 1) / std::max(1.0, n - used));
  }
  return factors;
}

/// Gradients of the levels where they lower chi-square by more than chance; true when one was taken up.
bool take_up_gradients(FitProblem& problem, std::span<const double> noise) {
  bool any = false;
  for (std::size_t b = 0; b < problem.blocks.size(); ++b) {
    auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b]);
    if (edge == nullptr || edge->gradients()) continue;
    const Eigen::MatrixXd all = edge->normal_with_gradients(*problem.sensors, problem.own[b]).matrix();
    const auto first = static_cast<Eigen::Index>(problem.own[b].size()), n = all.cols();
    // The parameters may give way as well, so they stand before the gradients: what the four explain beyond them is
    // the part of r in their rows of the triangular factor.
    std::vector<Eigen::Index> order;
    for (Eigen::Index i = 0; i < n; ++i)
      if (i < first || i >= first + 4) order.push_back(i);
    order.insert(order.end() - 1, {first, first + 1, first + 2, first + 3});
    const Eigen::MatrixXd factor = triangular_factor(all(order, order));
    if (factor.col(n - 1).segment(n - 5, 4).squaredNorm() < kGradientChi2 * std::max(1e-12, noise[b])) continue;
    edge->use_gradients();
    problem.own[b].resize(problem.own[b].size() + 4, 0.0);
    any = true;
  }
  return any;
}

/// Noise by the fitted levels; true when some block's weights have changed enough to fit again.
bool update_weights(FitProblem& problem, std::span<const double> noise) {
  bool any = false;
  for (std::size_t b = 0; b < problem.blocks.size(); ++b) {
    if (auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b]);
        edge != nullptr && edge->data().start.noise_gain != 0.0) {
      edge->update_noise(*problem.sensors, problem.own[b]);
      any = true;
    }
    // Between sets of data and against priors the noise level counts; it is what the residuals say.
    const bool relative = problem.blocks.size() > 1 || std::any_of(problem.priors.begin(), problem.priors.end(),
                                                                   [](auto& p) { return p.has_value(); });
    const bool own_noise = !std::holds_alternative<CurveBlock>(problem.blocks[b]);
    if (!relative || !own_noise || (noise[b] > 0.8 && noise[b] < 1.25) || !(noise[b] > 0.0)) continue;
    std::visit([&](auto& block) { block.scale_noise(noise[b]); }, problem.blocks[b]);
    any = true;
  }
  return any;
}

std::vector<std::size_t> counts_of(const FitProblem& problem) {
  std::vector<std::size_t> counts;
  for (std::size_t b = 0; b < problem.blocks.size(); ++b) {
    const Block& block = problem.blocks[b];
    const auto* edge = std::get_if<EdgeBlock>(&block);
    const auto* spot = std::get_if<SpotBlock>(&block);
    counts.push_back(edge != nullptr   ? edge->pixels()
                     : spot != nullptr ? spot->pixels()
                                       : std::get<CurveBlock>(block).frequencies().size());
  }
  return counts;
}

/// Where residuals are larger than the noise that was given, they decide what counts as an outlier: by their median, so
/// that outliers do not.
void settle_noise(FitProblem& problem) {
  for (std::size_t b = 0; b < problem.blocks.size(); ++b) {
    if (std::holds_alternative<CurveBlock>(problem.blocks[b])) continue;
    std::vector<double> sizes;
    for (const Residual& r : residuals_of(problem, b)) sizes.push_back(std::abs(r.value));
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    const double scale = *middle / 0.6744897501960817;
    if (scale > 1.25) std::visit([&](auto& block) { block.scale_noise(scale * scale); }, problem.blocks[b]);
  }
}

/// Plain least squares first: far from the minimum all residuals are beyond the bend of the loss, where steps are
/// short.
Solution solve_robustly(FitProblem& problem, bool robust, const std::function<bool()>& go_on) {
  constexpr double kCoarse = 1e-4;
  const auto bend_all = [&](bool bent) {
    for (Block& block : problem.blocks) std::visit([&](auto& b) { b.set_robust(bent); }, block);
  };
  bend_all(false);
  Solution first = solve(problem, {.go_on = go_on, .tolerance = robust ? kCoarse : SolveOptions{}.tolerance});
  if (!robust || first.stopped) return first;
  bend_all(true);
  settle_noise(problem);
  Solution second = solve(problem, {.go_on = go_on});
  second.iterations += first.iterations;
  return second;
}

/// The best of several starts; how many runs ended where it did.
Solution solve_from(FitProblem& problem, bool robust, int starts, Progress& progress, int& agreeing) {
  const auto own = problem.own;
  Solution best = solve_robustly(problem, robust, progress.asks());
  progress.step();
  std::vector<double> costs{best.cost};
  auto best_x = problem.x;
  auto best_own = problem.own;
  for (int run = 1; run < starts && !best.stopped; ++run) {
    problem.x = other_start(problem.variables, run);
    problem.own = own;
    const Solution next = solve_robustly(problem, robust, progress.asks());
    progress.step();
    costs.push_back(next.cost);
    best.stopped = next.stopped;
    best.iterations += next.iterations;
    if (!(next.cost < best.cost) || !next.converged) continue;
    best.cost = next.cost;
    best.converged = true;
    best_x = problem.x;
    best_own = problem.own;
  }
  problem.x = best_x;
  problem.own = best_own;
  problem.apply();
  // A tenth of a standard deviation is the same place.
  agreeing = static_cast<int>(
      std::count_if(costs.begin(), costs.end(), [&](double c) { return c < best.cost + 0.01 + 1e-7 * best.cost; }));
  return best;
}

mtf::Image residual_image(const Roi& roi, std::span<const Residual> residuals) {
  mtf::Image image(roi.width, roi.height);
  std::fill_n(image.data(), image.size(), std::numeric_limits<float>::quiet_NaN());
  for (const Residual& r : residuals) image.at(r.x - roi.x, r.y - roi.y) = static_cast<float>(r.value);
  return image;
}

void report_data(const FitData& data, const FitSetup& setup, const Solved& solved, FitResult& result) {
  const FitProblem& problem = setup.problem;
  double chi2 = 0.0, dof = -static_cast<double>(problem.variables.size());
  double least_p = 1.0;
  int tests = 0;
  std::optional<std::size_t> worst;
  for (std::size_t i = 0; i < setup.block_of.size(); ++i) {
    FitResiduals& out = result.data.emplace_back();
    const std::size_t edges = data.edges.size(), curves = data.curves.size();
    out.name = i < edges            ? data.edges[i].name
               : i < edges + curves ? data.curves[i - edges].name
                                    : data.spots[i - edges - curves].name;
    if (!setup.block_of[i]) continue;
    const std::size_t b = *setup.block_of[i];
    const std::vector<Residual> residuals = residuals_of(problem, b);
    const Adequacy adequacy = adequacy_of(problem, b, residuals);
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
      const double information = normal.topLeftCorner(own, own).inverse()(k, k) * solved.noise_factor[b];
      out.contrast = {problem.own[b][edge->contrast_index()], std::sqrt(std::max(0.0, information))};
      out.residual = residual_image(edge->data().roi, residuals);
      matters = kStructureMatters * std::abs(out.contrast.value) / edge->middle_sd();
      if (!result.residual_otf.empty() && b == 0)
        result.residual_otf =
            residual_otf(adequacy, std::abs(out.contrast.value) / edge->middle_sd(), result.frequency_cy_px);
    }
    if (const auto* spot = std::get_if<SpotBlock>(&problem.blocks[b]))
      out.residual = residual_image(spot->data().roi, residuals);
    ++tests;
    if (adequacy.structure < matters && matters > 0.0) continue;
    if (adequacy.whiteness_p < least_p) worst = i;
    least_p = std::min(least_p, adequacy.whiteness_p);
  }
  result.chi2_per_dof = chi2 / std::max(1.0, dof);
  result.whiteness_p = std::min(1.0, least_p * tests);
  for (const FitResiduals& one : result.data)
    if (one.chi2_per_dof > kNoiseDoubt * kNoiseDoubt)
      result.warnings.push_back(one.name + ": the residuals are " +
                                mtf::format_double(std::round(10.0 * std::sqrt(one.chi2_per_dof)) / 10.0) +
                                " times the noise that was given; the errors are scaled to them");
  if (result.status != FitStatus::converged || result.whiteness_p >= kWrongModel_p) return;
  result.status = FitStatus::converged_model_wrong;
  std::array<char, 16> p{};
  std::snprintf(p.data(), p.size(), "%.0e", result.whiteness_p);
  result.reason = "the residuals of " + result.data[*worst].name +
                  " have structure that noise does not explain (p = " + p.data() +
                  "): the model lacks something or has the wrong shape; the errors given are those of noise alone";
}

void report_mtf(const Solved& solved, FitResult& result) {
  for (int i = 0; i < kCurveSamples; ++i) result.frequency_cy_px.push_back(i * kCurveStep_cy_px);
  const std::vector<Functional> h = mtf_of(solved, result.frequency_cy_px);
  for (const Functional& m : h) {
    result.mtf.push_back(m.value);
    result.mtf_sd.push_back(sd_of(solved, m));
  }
  const Functional variance = equivalent_variance(solved);
  result.equivalent_variance_px2 = {variance.value, sd_of(solved, variance)};
  for (std::size_t k = 1; k < h.size(); ++k) {
    if (!(h[k - 1].value >= 0.5 && h[k].value < 0.5)) continue;
    // The secant, refined on the curve itself.
    double lo = result.frequency_cy_px[k - 1], hi = result.frequency_cy_px[k];
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (lo + hi);
      const std::vector<PixelFreq> at = along(solved.angle_rad, {&middle, 1});
      (solved.problem->sensors->modulus(solved.condition, at).front() >= 0.5 ? lo : hi) = middle;
    }
    const Functional at = mtf_of(solved, {&lo, 1}).front();
    const double slope = (h[k].value - h[k - 1].value) / kCurveStep_cy_px;
    result.mtf50 = {lo, sd_of(solved, at) / std::abs(slope)};
    return;
  }
}

void report_profiles(FitProblem& problem, const Solved& solved, double cost, Progress& progress, FitResult& result) {
  double factor = 0.0, weight = 0.0;
  const std::vector<std::size_t> counts = counts_of(problem);
  for (std::size_t b = 0; b < counts.size(); ++b) {
    factor += solved.noise_factor[b] * static_cast<double>(counts[b]);
    weight += static_cast<double>(counts[b]);
  }
  factor /= weight;
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    FittedParameter& p = result.parameters[i];
    if (p.knowledge == Knowledge::not_determined) continue;
    const auto index = static_cast<Eigen::Index>(i);
    const double sd = std::sqrt(solved.identified.covariance(index, index));
    const auto ends = profile(problem, i, sd, cost, factor, progress.asks());
    progress.step();
    if (!ends) return;
    p.interval68 = ends->interval68;
    p.interval95 = ends->interval95;
    const Variable& v = problem.variables[i];
    if (p.limit95) p.limit95 = problem.x[i] - v.lo < v.hi - problem.x[i] ? ends->upper95 : ends->lower95;
  }
}

}  // namespace

std::string_view knowledge_name(Knowledge knowledge) {
  constexpr std::array<std::string_view, 4> kNames{"determined", "at_bound", "prior_only", "not_determined"};
  return kNames[static_cast<std::size_t>(knowledge)];
}
std::string_view status_name(FitStatus status) {
  constexpr std::array<std::string_view, 5> kNames{"converged", "converged_model_wrong", "not_converged", "no_data",
                                                   "stopped"};
  return kNames[static_cast<std::size_t>(status)];
}

FitResult fit(const FitData& data, std::span<const FitParameter> parameters, const FitOptions& options) {
  FitSetup setup = make_setup(data, parameters, options);
  FitProblem& problem = setup.problem;
  FitResult result;
  result.warnings = setup.warnings;
  if (problem.blocks.empty()) {
    result.status = FitStatus::no_data;
    result.reason = setup.warnings.empty() ? "no edges, curves or spots were given" : setup.warnings.front();
    for (std::size_t i = 0; i < parameters.size(); ++i)
      result.parameters.push_back({.parameter = parameters[i], .start = setup.start[i], .value = setup.start[i]});
    result.system = data.conditions.front();
    return result;
  }

  Progress progress(options,
                    options.starts + kMostRounds + (options.profile ? static_cast<int>(parameters.size()) : 0));
  Solution solution =
      solve_from(problem, options.robust, std::max(1, options.starts), progress, result.starts_agreeing);
  const std::vector<std::size_t> counts = counts_of(problem);
  Solved solved{.problem = &problem};
  solved.normals = problem.normals();
  solved.noise_factor = noise_factors(problem, solved.normals, counts);
  result.iterations = solution.iterations;
  for (int round = 0; round < kMostRounds && solution.converged; ++round) {
    const bool gradients = take_up_gradients(problem, solved.noise_factor);
    const bool weights = round < 2 && update_weights(problem, solved.noise_factor);
    if (!gradients && !weights) break;
    solution = solve(problem, {.go_on = progress.asks()});
    progress.step();
    result.iterations += solution.iterations;
    solved.normals = problem.normals();
    solved.noise_factor = noise_factors(problem, solved.normals, counts);
  }
  result.status = solution.stopped     ? FitStatus::stopped
                  : solution.converged ? FitStatus::converged
                                       : FitStatus::not_converged;
  if (solution.stopped)
    result.reason = "stopped before the fit had converged; the values are those of the last step";
  else if (!solution.converged)
    result.reason = "no minimum was found within the allowed steps; start closer, set bounds, or ask for more starts";

  for (std::size_t b = 0; b < problem.blocks.size(); ++b)
    if (const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b])) {
      if (solved.normals_rad.empty()) {
        solved.condition = edge->condition();
        solved.angle_rad = edge->curve(problem.own[b]).angle_rad;
      }
      solved.normals_rad.push_back(edge->curve(problem.own[b]).angle_rad);
    }
  judge(solved, parameters);
  result.not_separable = null_directions(problem, solved, parameters);
  result.parameters = fitted_parameters(solved, parameters, setup.start);
  result.correlation = correlations(solved);
  report_mtf(solved, result);
  if (options.residual_otf) result.residual_otf.assign(result.frequency_cy_px.size(), 0.0);
  report_data(data, setup, solved, result);
  if (options.profile && solution.converged) report_profiles(problem, solved, solution.cost, progress, result);
  if (progress.stopped() && result.status != FitStatus::stopped) {
    result.status = FitStatus::stopped;
    result.reason = "stopped; what had been finished is given";
  }
  // The system last: it shares its components with the sensors, which are not changed any more. Bounds at zero are
  // meant exactly.
  std::vector<double> values;
  for (const FittedParameter& p : result.parameters) values.push_back(p.value);
  setup.sensors->set(values);
  result.system = setup.sensors->system(0);
  result.system.band_nodes = data.conditions.front().band_nodes;
  return result;
}

}  // namespace calib
